// SPDX-License-Identifier: Apache-2.0
// Drives: how far the wheels roll, and how far the robot moves. Each drive is a small value type
// with forward() from what its wheels report to the robot's twist, and inverse() back.
//
// A twist is (x ahead in m, y to the left in m, turn in rad) of one step during which the wheels
// turn at constant rates; exp(twist) is then the pose at its end, exactly: an arc.
#pragma once

#include <array>

#include "majak/core/pose2.hpp"

namespace majak::motion {

/// Two driven wheels on one axle; the robot's point is the axle's centre.
/// d = (left + right) / 2, turn = (right - left) / track; centre of the circle at
/// R = track / 2 (right + left) / (right - left) to the left of the axle's centre.
struct Differential {
  double track = 0.4;  ///< m between the wheels

  struct Wheels {
    double left = 0, right = 0;  ///< m rolled
  };
  Vec3 forward(const Wheels& wheels) const;
  /// The twist's y cannot be driven and is left out.
  Wheels inverse(const Vec3& twist) const;
};

/// A steered wheel ahead of a fixed axle (tricycle, car); the robot's point is that axle's centre.
/// turn = way sin(steering) / wheelbase: no division by zero on a straight, unlike R = l / tan.
struct Ackermann {
  double wheelbase = 0.5;  ///< m

  struct Wheels {
    double way = 0;       ///< m rolled by the steered wheel
    double steering = 0;  ///< rad, left positive
  };
  Vec3 forward(const Wheels& wheels) const;
  /// For |twist.x| > 0; standing still gives way 0, steering 0. Steering in (-pi/2, pi/2).
  Wheels inverse(const Vec3& twist) const;
  /// Signed radius of the axle centre's circle, left positive; infinite on a straight.
  double radius(double steering) const;
};

/// Three wheels at 120 degrees that roll sidewards freely; the robot's point is their centre.
/// d1 = dx + b turn; d2 = -dx/2 + sqrt(3)/2 dy + b turn; d3 = -dx/2 - sqrt(3)/2 dy + b turn.
struct Omnidirectional {
  double arm = 0.25;  ///< m from the centre to each wheel

  using Wheels = std::array<double, 3>;  ///< m rolled
  Vec3 forward(const Wheels& wheels) const;
  Wheels inverse(const Vec3& twist) const;
};

}  // namespace majak::motion
