// SPDX-License-Identifier: Apache-2.0
// Which scans can be drawn into cells at all.
#pragma once

#include <cmath>

#include "majak/core/site.hpp"

namespace majak::map {

/// A scan that is not lost, at a pose and with angles that are numbers, whose returns of up to
/// max_range (m) have cells of that resolution (m) that an int can count.
inline bool drawable(const PosedScan& posed, double resolution, double max_range) {
  constexpr double kFarthestCell = 1e9;
  const Pose2& pose = posed.estimate.T_map_robot;
  const Scan& scan = posed.scan;
  const double reach = (kFarthestCell - 1) * resolution - max_range;
  return posed.estimate.health != Health::lost && pose.finite() && scan.T_robot_laser.finite() &&
         std::isfinite(scan.start_angle) && std::isfinite(scan.angle_step) &&
         (pose * scan.T_robot_laser).translation().cwiseAbs().maxCoeff() < reach;
}

}  // namespace majak::map
