// SPDX-License-Identifier: Apache-2.0
// By how much does a laser read too long against a map? Walls that face each other lie too far
// apart then. What is common to laser and map is no error here.
#pragma once

#include "majak/core/pose2.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::match {

struct RangeOffset {
  double offset = 0;       ///< m, to be taken off the ranges
  double information = 0;  ///< 1/m^2, with the pose unknown
};

/// Of the returns that lie on surfaces within final_gate at T_map_robot, where they were aligned.
/// `laser`: where the beams begin, robot frame.
RangeOffset range_offset(const ScanPoints& points, const map::SurfelMap& map,
                         const Pose2& T_map_robot, const Vec2& laser, const AlignOptions& options);

}  // namespace majak::match
