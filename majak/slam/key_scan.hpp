// SPDX-License-Identifier: Apache-2.0
// Key scans: the nodes of graph SLAM, with the points they are matched by and what the front end
// knows of them.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::slam {

struct KeyScan {
  std::size_t scan = 0;       ///< index into the run's scans
  match::ScanPoints points;   ///< robot frame, with normals
  Pose2 T_robot_laser;        ///< mounting of the laser that saw them
  Pose2 T_map_robot;          ///< current estimate
  Pose2 T_front_robot;        ///< pose in the front end's drifting frame
  std::size_t local_map = 0;  ///< key scan that began the local map it was matched to, or itself
  Mat3 match_information =
      Mat3::Zero();            ///< of its pose in that local map, by the laser alone; own axes
  Pose2 T_previous_predicted;  ///< motion since the key scan before, without the laser
  Mat3 motion_information = Mat3::Zero();  ///< of that; own axes
  bool weak_step = false;  ///< the way from the key scan before is not to be trusted
};

using KeyScans = std::vector<KeyScan>;

/// Of one, with its points.
inline std::size_t bytes(const KeyScan& key) {
  return sizeof(key) + key.points.size() * (4 * sizeof(float) + 1);
}

}  // namespace majak::slam
