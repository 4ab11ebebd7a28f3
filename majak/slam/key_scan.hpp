// SPDX-License-Identifier: Apache-2.0
// Key scans: the nodes of graph SLAM, with the points they are matched by.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::slam {

struct KeyScan {
  std::size_t scan = 0;         ///< index into the run's scans
  match::ScanPoints points;     ///< robot frame, with normals
  Pose2 T_robot_laser;          ///< mounting of the laser that saw them
  Pose2 T_map_robot;            ///< current estimate
  Pose2 T_front_robot;          ///< pose in the front end's drifting frame
  Mat3 step_information = Mat3::Zero();  ///< of T_previous_this, axes of this key scan
  bool weak_step = false;       ///< the way from the key scan before is not to be trusted
};

using KeyScans = std::vector<KeyScan>;

}  // namespace majak::slam
