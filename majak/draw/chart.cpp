// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>

namespace majak::draw {

namespace {

constexpr double kWidth = 900, kHeight = 150, kLeft = 54, kRight = 12, kTop = 24, kBottom = 24;
constexpr std::size_t kMostColumns = 420;

struct Column {
  double low = std::numeric_limits<double>::infinity(),
         high = -std::numeric_limits<double>::infinity();
  double sum_x = 0, sum_y = 0;
  int count = 0;
};

struct Axes {
  double x_min = 0, x_max = 1, y_max = 1;
  double x(double value) const {
    return kLeft + (value - x_min) / (x_max - x_min) * (kWidth - kLeft - kRight);
  }
  double y(double value) const {
    return kHeight - kBottom - std::min(value, y_max) / y_max * (kHeight - kTop - kBottom);
  }
};

std::vector<Point> finite_points(const Chart& chart) {
  std::vector<Point> points;
  std::copy_if(chart.points.begin(), chart.points.end(), std::back_inserter(points),
               [](Point p) { return std::isfinite(p.x) && std::isfinite(p.y); });
  return points;
}

Axes axes_for(const Chart& chart, const std::vector<Point>& points) {
  Axes axes;
  if (!points.empty()) {
    const auto [low, high] = std::minmax_element(points.begin(), points.end(),
                                                 [](Point a, Point b) { return a.x < b.x; });
    axes.x_min = low->x;
    axes.x_max = std::max(high->x, low->x + 1e-3);
  }
  double y_max = chart.y_max;
  if (y_max <= 0) {
    for (const Point& p : points) y_max = std::max(y_max, p.y);
    y_max = ticks(y_max, 3).back();
  }
  axes.y_max = y_max;
  return axes;
}

std::vector<Column> into_columns(const std::vector<Point>& points, const Axes& axes) {
  std::vector<Column> columns(std::clamp<std::size_t>(points.size(), 1, kMostColumns));
  const auto count = static_cast<double>(columns.size());
  for (const Point& p : points) {
    const double share = (p.x - axes.x_min) / (axes.x_max - axes.x_min);
    Column& column = columns[static_cast<std::size_t>(std::clamp(share * count, 0.0, count - 1))];
    column.low = std::min(column.low, p.y);
    column.high = std::max(column.high, p.y);
    column.sum_x += p.x;
    column.sum_y += p.y;
    ++column.count;
  }
  return columns;
}

/// The extent as an area and the mean as a line; columns without a point break both.
std::string curve(const std::vector<Column>& columns, const Axes& axes) {
  std::string area, line;
  constexpr int kGap = 12;  // a line bridges fewer columns without points
  std::vector<Point> upper, lower, mean;
  const auto flush = [&] {
    std::reverse(lower.begin(), lower.end());
    const std::vector<Point> top = upper;
    upper.insert(upper.end(), lower.begin(), lower.end());
    if (upper.size() > 2) area += path_data(upper) + 'Z';
    if (mean.size() == 1) mean.push_back({mean[0].x + 1, mean[0].y});  // or it would not be seen
    line += path_data(mean);
    upper.clear(), lower.clear(), mean.clear();
  };
  int empty = 0;
  for (const Column& column : columns) {
    if (column.count == 0) {
      if (++empty == kGap) flush();
      continue;
    }
    empty = 0;
    const double x = axes.x(column.sum_x / column.count);
    upper.push_back({x, axes.y(column.high)});
    lower.push_back({x, axes.y(column.low)});
    mean.push_back({x, axes.y(column.sum_y / column.count)});
  }
  flush();
  return fmt::format("<path class=\"extent\" d=\"{}\"/><path class=\"mean\" d=\"{}\"/>\n", area,
                     line);
}

std::string frame(const Axes& axes) {
  std::string out;
  for (const double y : ticks(axes.y_max, 3)) {
    if (y > axes.y_max * 1.001) break;
    out += fmt::format(
        "<path class=\"rule\" d=\"M{} {}H{}\"/><text x=\"{}\" y=\"{}\" class=\"end\">{}</text>",
        kLeft, number(axes.y(y), 1), kWidth - kRight, kLeft - 6, number(axes.y(y) + 4, 1),
        number(y, 6));
  }
  for (const double x : ticks(axes.x_max - axes.x_min, 8)) {
    if (x > axes.x_max - axes.x_min) break;
    out += fmt::format("<text x=\"{}\" y=\"{}\" class=\"mid\">{}</text>",
                       number(axes.x(axes.x_min + x), 1), kHeight - 7,
                       number(x, 6) + (x == 0 ? " min" : ""));
  }
  return out + '\n';
}

}  // namespace

std::vector<double> ticks(double max, int wanted) {
  if (!(max > 0) || !std::isfinite(max)) max = 1;
  const double raw = max / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double share = raw / power;
  const double step = power * (share <= 1 ? 1 : share <= 2 ? 2 : share <= 5 ? 5 : 10);
  std::vector<double> values = {0};
  while (values.back() < max * (1 - 1e-9))
    values.push_back(static_cast<double>(values.size()) * step);
  return values;
}

std::string chart_svg(const Chart& chart) {
  const std::vector<Point> points = finite_points(chart);
  const Axes axes = axes_for(chart, points);
  std::string out =
      fmt::format("<svg class=\"chart\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n",
                  kWidth, kHeight, escape(chart.title));
  const std::string unit = chart.unit.empty() ? "" : ", " + chart.unit;
  out += fmt::format("<text x=\"{}\" y=\"{}\" class=\"title\">{}{}</text>\n", kLeft, kTop - 8,
                     escape(chart.title), escape(unit));
  for (const Band& band : chart.bands) {
    const double x = axes.x(band.from), width = std::max(1.5, axes.x(band.to) - x);
    out += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n",
                       band.style, number(x, 1), kTop, number(width, 1), kHeight - kTop - kBottom);
  }
  return out + frame(axes) + curve(into_columns(points, axes), axes) + "</svg>\n";
}

}  // namespace majak::draw
