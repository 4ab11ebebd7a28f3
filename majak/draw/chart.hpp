// SPDX-License-Identifier: Apache-2.0
// A value over time as inline SVG: thousands of points become the mean and the extent of a few
// hundred columns. Coloured by the page's style sheet.
#pragma once

#include <string>
#include <vector>

#include "majak/draw/svg.hpp"

namespace majak::draw {

/// A stretch of the x axis shown in a style class ("weak", "lost").
struct Band {
  double from = 0, to = 0;
  std::string style;
};

struct Chart {
  std::string title;
  std::string unit;           ///< of y
  std::vector<Point> points;  ///< any order; those that are not finite are left out
  std::vector<Band> bands;
  double y_max = 0;  ///< 0: as the points ask; the axis starts at 0
};

/// Values at round steps (1, 2, 5 times a power of ten) from 0 to at least `max`, about `wanted` of
/// them. A max that is not positive counts as 1.
std::vector<double> ticks(double max, int wanted);

/// One chart; x is in minutes.
std::string chart_svg(const Chart& chart);

}  // namespace majak::draw
