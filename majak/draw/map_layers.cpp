// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/map_layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "majak/draw/chart.hpp"

namespace majak::draw {

std::string thin_path(const std::vector<Point>& metres, const View& view) {
  std::vector<Point> points;
  points.reserve(metres.size());
  for (const Point& p : metres) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
    const Point q = view(p);
    if (points.empty() || std::hypot(q.x - points.back().x, q.y - points.back().y) > 0.25)
      points.push_back(q);
  }
  if (points.size() == 1) points.push_back(points[0]);  // a round cap makes it a dot
  return path_data(simplify(points, 0.25), 1);
}

std::string line_layer(const char* style, const std::vector<Point>& metres, const View& view) {
  return fmt::format("<path class=\"layer line {}\" d=\"{}\"/>\n", style, thin_path(metres, view));
}

EllipseAxes axes_of(const Eigen::Matrix2d& covariance) {
  const double a = covariance(0, 0), b = covariance(0, 1), d = covariance(1, 1);
  const double mean = 0.5 * (a + d), spread = std::hypot(0.5 * (a - d), b);
  const auto root = [](double v) { return v > 0 && std::isfinite(v) ? std::sqrt(v) : 0.0; };
  return {root(mean + spread), root(mean - spread), 0.5 * std::atan2(2 * b, a - d)};
}

std::string scale_bar(const View& view, double width, double height) {
  const double metres = ticks(width / view.length(1), 8).at(1);
  const double x = 0.02 * width, y = height - 0.02 * height, text = std::max(width, height) / 60;
  return fmt::format(
      "<g class=\"scale\"><path d=\"M{} {}h{}\"/><text x=\"{}\" y=\"{}\" font-size=\"{}\">{} "
      "m</text></g>\n",
      number(x), number(y), number(view.length(metres)), number(x), number(y - text / 2),
      number(text), number(metres, 3));
}

std::string marker(const char* style, Point p, double radius, const char* title) {
  return fmt::format(
      "<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"><title>{}</title></circle>\n", style,
      number(p.x, 1), number(p.y, 1), number(radius, 1), title);
}

}  // namespace majak::draw
