// SPDX-License-Identifier: Apache-2.0
// What maps as inline SVG are made of: ways, ellipses, marks, a bar of scale. Layers carry classes
// that a page switches and its style sheet colours.
#pragma once

#include <string>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/draw/svg.hpp"

namespace majak::draw {

/// Map metres to the figure's units, y down.
class View {
 public:
  /// `x0`, `y0`: m, lower left corner; `unit`: m; `height` of the figure in units.
  View(double x0, double y0, double unit, double height)
      : x0_(x0), y0_(y0), unit_(unit), height_(height) {}
  Point operator()(Point p) const { return {(p.x - x0_) / unit_, height_ - (p.y - y0_) / unit_}; }
  Point operator()(const Pose2& pose) const { return (*this)(Point{pose.x, pose.y}); }
  double length(double metres) const { return metres / unit_; }

 private:
  double x0_, y0_, unit_, height_;
};

/// A layer as the page's switches show it.
struct Layer {
  std::string style, label;
  bool shown = true;
};

/// A path without what the eye cannot see: a quarter of a unit.
std::string thin_path(const std::vector<Point>& metres, const View& view);
std::string line_layer(const char* style, const std::vector<Point>& metres, const View& view);

struct EllipseAxes {
  double major, minor, angle;  ///< m, m, rad: one sigma
};
EllipseAxes axes_of(const Eigen::Matrix2d& covariance);

/// A bar of a round length in the lower left corner.
std::string scale_bar(const View& view, double width, double height);
/// `radius` in units.
std::string marker(const char* style, Point p, double radius, const char* title);

}  // namespace majak::draw
