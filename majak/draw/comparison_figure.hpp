// SPDX-License-Identifier: Apache-2.0
// Methods of localization side by side: their paths on the map, and bars of what they cost and how
// well they do.
#pragma once

#include <string>
#include <vector>

#include "majak/draw/figure.hpp"
#include "majak/eval/compare.hpp"

namespace majak::draw {

struct ComparisonPicture {
  std::string title;
  const eval::Comparison& comparison;
  eval::Trajectory truth;   ///< map frame; may be empty
  std::vector<Vec2> walls;  ///< points on the map's surfaces
};

/// Bars are logarithmic, with the value beside them; poses said to be lost are not in the paths.
Figure comparison_picture(const ComparisonPicture& picture);

}  // namespace majak::draw
