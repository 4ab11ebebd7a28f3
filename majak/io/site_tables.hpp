// SPDX-License-Identifier: Apache-2.0
// What the writer and the reader of the site file share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "majak/core/site.hpp"

namespace majak::io {

inline constexpr std::int64_t kSiteApplication = 0x6d616a6b;  // "majk"
inline constexpr std::int64_t kSiteVersion = 2;  ///< 1 knew neither key links nor edits
inline constexpr std::int64_t kEditsApplication = 0x6d616a65;  // "maje"

/// Of the edits, in the site file and in the file of newer edits beside it.
inline constexpr const char* kEditSchema = R"(
CREATE TABLE edit(id INTEGER PRIMARY KEY, kind INT, radians REAL, from_scan INT, to_scan INT);
CREATE TABLE edit_point(id INTEGER PRIMARY KEY, edit INT, scan INT, x REAL, y REAL);
)";

struct NamedLearnt {
  const char* name;
  Learnt OdometryFindings::*field;
};
inline constexpr std::array<NamedLearnt, 6> kLearnt = {
    {{"lag_s", &OdometryFindings::lag_s},
     {"laser_theta_rad", &OdometryFindings::laser_theta_rad},
     {"laser_x_m", &OdometryFindings::laser_x_m},
     {"laser_y_m", &OdometryFindings::laser_y_m},
     {"rotation_scale", &OdometryFindings::rotation_scale},
     {"translation_scale", &OdometryFindings::translation_scale}}};

/// What most scans of a log share.
struct Laser {
  int number;
  std::size_t beams;
  double start_angle, angle_step;
  float max_range;
  Pose2 T_robot_laser;
  bool operator==(const Laser&) const = default;
};

}  // namespace majak::io
