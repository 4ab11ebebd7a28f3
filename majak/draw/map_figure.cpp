// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/map_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "majak/draw/map_layers.hpp"
#include "majak/io/map_files.hpp"

namespace majak::draw {

namespace {

constexpr std::size_t kMaxPicture = std::size_t{1} << 22;  ///< pixels embedded
constexpr std::size_t kMaxClosures = 2000, kEllipses = 40;
constexpr double kChi2Good = 7.815, kChi2Strained = 16.266;  // 95 % and 99.9 % of 3 dof
constexpr double kChi95In2 = 5.991;                          // 95 % of 2 dof
constexpr double kLargestEllipse = 0.02;  ///< of the picture's longer side, when enlarged

Point point_of(const Pose2& pose) { return {pose.x, pose.y}; }

/// Stretches of one health, each as a path of its own.
std::string health_layer(const Site& site, Health health, const char* style, const View& view) {
  std::string d;
  std::vector<Point> stretch;
  const auto flush = [&] {
    if (!stretch.empty()) d += thin_path(stretch, view);
    stretch.clear();
  };
  for (const PosedScan& posed : site.scans) {
    if (posed.estimate.health != health) {
      flush();
    } else {
      stretch.push_back(point_of(posed.estimate.T_map_robot));
    }
  }
  flush();
  return d.empty() ? "" : fmt::format("<path class=\"layer line {}\" d=\"{}\"/>\n", style, d);
}

/// The scans nearest to equal steps along the way.
std::vector<std::size_t> spread_along(const Site& site, std::size_t wanted) {
  std::vector<double> along;
  double length = 0;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    if (i > 0) {
      const double step = (site.scans[i].estimate.T_map_robot.translation() -
                           site.scans[i - 1].estimate.T_map_robot.translation())
                              .norm();
      if (std::isfinite(step)) length += step;
    }
    along.push_back(length);
  }
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < along.size(); ++i) {
    const double next = length * static_cast<double>(chosen.size()) / static_cast<double>(wanted);
    if (along[i] >= next && (chosen.empty() || along[i] > along[chosen.back()]))
      chosen.push_back(i);
  }
  return chosen;
}

double ellipse_scale(double largest, double room) {
  double scale = 1;
  for (const double s : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    if (largest * s <= room) scale = s;
  }
  return scale;
}

std::string ellipse_layer(const Site& site, const View& view, double longer_side,
                          MapFigure& figure) {
  const std::vector<std::size_t> chosen = spread_along(site, kEllipses);
  double largest = 0;
  for (const std::size_t i : chosen)
    largest =
        std::max(largest, axes_of(site.scans[i].estimate.covariance.topLeftCorner<2, 2>()).major);
  if (largest <= 0) return "";
  const double quantile = std::sqrt(kChi95In2);
  figure.ellipse_scale =
      ellipse_scale(view.length(largest * quantile), kLargestEllipse * longer_side);
  const double scale = view.length(quantile * figure.ellipse_scale);
  std::string out = "<g class=\"layer ellipses\">\n";
  for (const std::size_t i : chosen) {
    const EllipseAxes e = axes_of(site.scans[i].estimate.covariance.topLeftCorner<2, 2>());
    const Point c = view(site.scans[i].estimate.T_map_robot);
    out += fmt::format(
        "<ellipse rx=\"{}\" ry=\"{}\" transform=\"translate({} {})rotate({})\"><title>sigma {} x "
        "{} cm, heading "
        "{} degrees</title></ellipse>\n",
        number(e.major * scale, 1), number(e.minor * scale, 1), number(c.x, 1), number(c.y, 1),
        number(-degrees(e.angle), 0), number(100 * e.major, 1), number(100 * e.minor, 1),
        number(degrees(std::sqrt(std::max(0.0, site.scans[i].estimate.covariance(2, 2)))), 2));
  }
  return out + "</g>\n";
}

/// Closures, the best fitting first so that the bad ones lie on top; the worst ones if too many.
std::string closure_layer(const Site& site, Fit fit, const View& view, MapFigure& figure) {
  std::string out;
  for (std::size_t i = 0; i < site.constraints.size() && figure.closures_drawn < kMaxClosures;
       ++i) {
    const Constraint& c = site.constraints[i];
    if (c.kind != ConstraintKind::closure || fit_of(c) != fit) continue;
    const Point a = view(site.scans[c.from].estimate.T_map_robot),
                b = view(site.scans[c.to].estimate.T_map_robot);
    out += fmt::format(
        "<line id=\"c{}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"><title>{} - {}, chi2 "
        "{}</title></line>\n",
        i, number(a.x, 1), number(a.y, 1), number(b.x, 1), number(b.y, 1), c.from, c.to,
        number(c.chi2, 1));
    ++figure.closures_drawn;
  }
  return out.empty() ? ""
                     : fmt::format("<g class=\"layer closure {}\">\n{}</g>\n", style_of(fit), out);
}

void lay_onto(const Pose2& T_map_other, const Pose2& pose, std::vector<Point>& out) {
  out.push_back(point_of(T_map_other * pose));
}

std::vector<Point> truth_path(const Site& site) {
  std::vector<Point> out;
  if (site.scans.empty() || site.truth.empty()) return out;
  const PosedScan& first = site.scans.front();
  const auto distance = [&](const Truth& t) {
    return std::abs(to_seconds(t.time) - to_seconds(first.scan.time));
  };
  const auto nearest =
      std::min_element(site.truth.begin(), site.truth.end(),
                       [&](const Truth& a, const Truth& b) { return distance(a) < distance(b); });
  const Pose2 T_map_world = first.estimate.T_map_robot * nearest->T_world_robot.inverse();
  for (const Truth& t : site.truth) lay_onto(T_map_world, t.T_world_robot, out);
  return out;
}

}  // namespace

Fit fit_of(const Constraint& closure) {
  if (!closure.enabled) return Fit::rejected;
  return closure.chi2 <= kChi2Good       ? Fit::good
         : closure.chi2 <= kChi2Strained ? Fit::strained
                                         : Fit::poor;
}

const char* style_of(Fit fit) {
  constexpr std::array kStyles = {"good", "strained", "poor", "rejected"};
  return kStyles[static_cast<std::size_t>(fit)];
}

Paths paths_of(const Site& site) {
  Paths paths;
  std::optional<Pose2> T_map_odom;
  for (const PosedScan& posed : site.scans) {
    paths.final.push_back(point_of(posed.estimate.T_map_robot));
    paths.front_end.push_back(point_of(posed.T_map_robot_front_end));
    if (!posed.T_odom_robot) continue;
    if (!T_map_odom) T_map_odom = posed.estimate.T_map_robot * posed.T_odom_robot->inverse();
    lay_onto(*T_map_odom, *posed.T_odom_robot, paths.odometry);
  }
  paths.truth = truth_path(site);
  return paths;
}

MapFigure map_figure(const Site& site, const map::OccupancyGrid& grid, const Paths& paths) {
  MapFigure figure;
  const io::MapFrame frame = io::frame_of(grid, kMaxPicture);
  const View view(frame.x0, frame.y0, frame.pixel, frame.height);
  const double longer = std::max(frame.width, frame.height);
  std::string& svg = figure.svg;
  svg = fmt::format(
      "<svg class=\"map\" id=\"map\" viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"the map\">\n"
      "<image class=\"layer picture\" width=\"{0}\" height=\"{1}\" "
      "href=\"data:image/png;base64,{2}\"/>\n",
      frame.width, frame.height, base64(io::encode_png(io::shaded_map(grid, frame))));
  const auto add = [&](std::string layer, const char* style, std::string label, bool shown) {
    if (layer.empty()) return;
    svg += layer;
    figure.layers.push_back({style, std::move(label), shown});
  };
  figure.layers.push_back({"picture", "map", true});
  if (!paths.odometry.empty())
    add(line_layer("odometry", paths.odometry, view), "odometry", "odometry alone", false);
  if (!paths.front_end.empty())
    add(line_layer("before", paths.front_end, view), "before", "before loop closing", false);
  if (!paths.truth.empty()) add(line_layer("truth", paths.truth, view), "truth", "truth", false);
  if (!paths.final.empty())
    add(line_layer("after", paths.final, view), "after", "trajectory", true);
  add(health_layer(site, Health::degraded, "weak", view), "weak", "weakly held", true);
  add(health_layer(site, Health::lost, "lost", view), "lost", "lost", true);
  add(closure_layer(site, Fit::rejected, view, figure), "closure.rejected", "closures rejected",
      false);
  add(closure_layer(site, Fit::good, view, figure), "closure.good", "closures that fit", true);
  add(closure_layer(site, Fit::strained, view, figure), "closure.strained", "closures under strain",
      true);
  add(closure_layer(site, Fit::poor, view, figure), "closure.poor", "closures that fit badly",
      true);
  const std::string ellipses = ellipse_layer(site, view, longer, figure);
  const std::string enlarged =
      figure.ellipse_scale > 1 ? fmt::format(", {} times enlarged", figure.ellipse_scale) : "";
  add(ellipses, "ellipses", "95 % ellipses" + enlarged, false);
  if (!site.scans.empty()) {
    svg += marker("start", view(site.scans.front().estimate.T_map_robot), longer / 150, "start");
    svg += marker("goal", view(site.scans.back().estimate.T_map_robot), longer / 150, "end");
  }
  svg += scale_bar(view, frame.width, frame.height) + "</svg>\n";
  return figure;
}

std::string path_figure(const Paths& paths) {
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  bool any = false;
  for (const auto* path : {&paths.final, &paths.front_end, &paths.odometry, &paths.truth}) {
    for (const Point& p : *path) {
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      x0 = any ? std::min(x0, p.x) : p.x, x1 = any ? std::max(x1, p.x) : p.x;
      y0 = any ? std::min(y0, p.y) : p.y, y1 = any ? std::max(y1, p.y) : p.y;
      any = true;
    }
  }
  constexpr double kWidth = 900, kMargin = 20, kHighest = 700;
  const double unit =
      std::max({(x1 - x0) / (kWidth - 2 * kMargin), (y1 - y0) / (kHighest - 2 * kMargin), 1e-3});
  const double height = (y1 - y0) / unit + 2 * kMargin;
  const double left = x0 - (kWidth - (x1 - x0) / unit) / 2 * unit;  // in the middle
  const View view(left, y0 - kMargin * unit, unit, height);
  std::string svg = fmt::format(
      "<svg class=\"paths\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"trajectories\">\n",
      kWidth, number(height));
  if (!paths.odometry.empty()) svg += line_layer("odometry", paths.odometry, view);
  if (!paths.front_end.empty()) svg += line_layer("before", paths.front_end, view);
  if (!paths.truth.empty()) svg += line_layer("truth", paths.truth, view);
  if (!paths.final.empty()) svg += line_layer("after", paths.final, view);
  return svg + scale_bar(view, kWidth, height) + "</svg>\n";
}

}  // namespace majak::draw
