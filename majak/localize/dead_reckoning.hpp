// SPDX-License-Identifier: Apache-2.0
// Dead reckoning (thesis p. 15): the way and the turn that the wheels report are added up from a
// known start. Nothing corrects the sum, so its ellipse only grows.
//
// Needs Odometry (a log without takes the odometry in its scans), or WheelMotion, of which every
// step is an exact arc. Yields an estimate for each such record.
#pragma once

#include "majak/core/options.hpp"
#include "majak/localize/localizer.hpp"
#include "majak/motion/path_uncertainty.hpp"
#include "majak/motion/wheel_noise.hpp"

namespace majak::localize {

struct DeadReckoningOptions {
  double wheelbase = 2.83;      ///< m, of a car that reports speed and steering
  bool never_shrink = true;     ///< keep the ellipse where a way back would make it smaller again
  motion::OdometryNoise noise;  ///< of Odometry
  motion::CarNoise car;         ///< of WheelMotion
};
void describe(OptionFields& fields, DeadReckoningOptions& options);

/// Starts at T_map_robot = `start`, which is taken as certain.
Localizer dead_reckoning(const DeadReckoningOptions& options, const Pose2& start = {});

}  // namespace majak::localize
