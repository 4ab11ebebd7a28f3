// SPDX-License-Identifier: Apache-2.0
// Corners in a scan: where two walls meet, or where one ends and what is behind it shows. Landmarks
// for rooms, as trunks are for parks.
#pragma once

#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/map/segments.hpp"

namespace majak::slam {

struct CornerOptions {
  map::SegmentOptions segments{.max_range = 15, .min_length = 0.4};
  double wall_sigma = 0.02;  ///< m, by which a wall is no straight line
  double behind = 0.4;       ///< m, that a beam beside a wall's end goes farther
};

/// In the robot's frame, with its covariance (m^2): walls are known as well as their returns make
/// them, and not better than wall_sigma; an end lies anywhere between two beams.
struct Corner {
  Vec2 p_robot = Vec2::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

/// Those of a scan, counter-clockwise.
std::vector<Corner> find_corners(const Scan& scan, const CornerOptions& options = {});

}  // namespace majak::slam
