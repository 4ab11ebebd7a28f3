// SPDX-License-Identifier: Apache-2.0
// Slip and bumps: where the calibrated wheels and the laser disagree by more than their noise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/site.hpp"
#include "majak/motion/calibration.hpp"
#include "majak/motion/drive_log.hpp"

namespace majak::motion {

enum class SlipKind : std::uint8_t {
  slip,  ///< the wheels turned more than the robot moved
  push,  ///< the robot moved more than the wheels turned: a push or a bump
  jump,  ///< the counters began anew
};

inline const char* name_of(SlipKind kind) {
  return kind == SlipKind::slip ? "slip" : kind == SlipKind::push ? "push" : "jump";
}

/// Wheels and laser disagree by more than their noise.
struct SlipEvent {
  Time begin = 0, end = 0;  ///< stamps of the scans before and after
  SlipKind kind = SlipKind::slip;
  double way = 0;   ///< m, of the disagreement
  double turn = 0;  ///< rad, the robot's turn less the wheels'
};

/// The biggest first, a turn weighed as 0.2 m a rad; equals stay in the order of time.
void sort_by_size(std::vector<SlipEvent>& events);

struct SlipOptions {
  double gate = 26;                ///< chi-square of a step, 3 degrees of freedom: 1 in 100 000
  double least_way = 0.03;         ///< m; smaller disagreements are not told
  double least_turn = radians(2);  ///< rad
  std::size_t stride = 3;          ///< laser poses a step, some 0.3 s
};

/// In the order of time. `wheels` and the noise as calibrated.
std::vector<SlipEvent> find_slips(const std::vector<LaserPose>& laser,
                                  const std::vector<WheelSample>& wheels, const Calibration& found,
                                  const Pose2& T_robot_laser, double wheelbase,
                                  const SlipOptions& options = {});

/// Of a whole log, with the stamps of its scans.
std::vector<SlipEvent> find_slips(const DriveLog& log, const Site& site,
                                  const LogCalibration& found, double wheelbase = 0);

/// Of a finished map by its scans' own odometry, calibrated by the way. None where there is too
/// little odometry, or so much contradiction that the map's poses are as much to blame.
std::vector<SlipEvent> find_slips(const Site& site);

}  // namespace majak::motion
