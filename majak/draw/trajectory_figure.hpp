// SPDX-License-Identifier: Apache-2.0
// A path with the ellipses of its positions: what `majak localize` shows, and figure 5.
#pragma once

#include <string>
#include <vector>

#include "majak/core/estimate.hpp"
#include "majak/core/event.hpp"
#include "majak/draw/figure.hpp"

namespace majak::draw {

struct PathPicture {
  std::string title{};
  std::vector<Estimate> estimates{};
  std::vector<Pose2> truth{};   ///< in the frame of the estimates; may be empty
  std::vector<GpsFix> fixes{};  ///< likewise
  std::vector<Vec2> walls{};    ///< of the known map, points on them
  int ellipses = 12;            ///< along the way, about equally far apart
  std::string path_name = "estimate";
};

/// Estimates that are not finite are left out. Ellipses hold 95 % of the positions.
Figure path_picture(const PathPicture& picture);

}  // namespace majak::draw
