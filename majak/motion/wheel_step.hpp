// SPDX-License-Identifier: Apache-2.0
// WheelStep: one step as the wheels count it, and what the numbers that they may count wrongly do
// to it. The same numbers for every drive, so that a filter can learn them beside the pose
// (docs/MATH.md "Kalman filter").
#pragma once

#include "majak/core/event.hpp"
#include "majak/core/pose2.hpp"

namespace majak::motion {

struct WheelStep {
  /// The numbers: scale of the way, scale of turns (of a car: of the steering angle), turn per
  /// way (rad/m), cube (1/rad^2) and square (1/rad) of the steering angle in what a car steers.
  enum Number { kScale, kTurnScale, kTurnOffset, kCurve, kSquare, kNumbers };
  using Derivative = Eigen::Matrix<double, 3, kNumbers>;

  Vec3 twist = Vec3::Zero();  ///< m, m, rad in the robot's axes
  Derivative by_numbers = Derivative::Zero();
};

/// A car for some seconds at this speed and steering; `wheelbase` in m.
WheelStep wheel_step(const WheelMotion& wheels, double seconds, double wheelbase);

/// A step that the odometry counted as `twist`.
WheelStep wheel_step(const Vec3& twist);

/// Random errors of the wheels; they add up like a random walk.
struct WheelRandom {
  double way_noise = 0.02;    ///< m per sqrt(m), along
  double side_noise = 0.02;   ///< m per sqrt(m), across
  double turn_noise = 0.003;  ///< rad per sqrt(m)
  double spin_noise = 0.05;   ///< rad per sqrt(rad)
};

/// Variances of a step: m^2, m^2, rad^2 in the robot's axes.
Vec3 step_variance(const Vec3& twist, const WheelRandom& random);

}  // namespace majak::motion
