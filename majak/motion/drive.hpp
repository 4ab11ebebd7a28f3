// SPDX-License-Identifier: Apache-2.0
// Drives: how far the wheels roll, and how far the robot moves. Each drive is a small value type
// with forward() from what its wheels report to the robot's twist, and inverse() back.
//
// A twist is (x ahead in m, y to the left in m, turn in rad) of one step during which the wheels
// turn at constant rates; exp(twist) is then the pose at its end, exactly: an arc. by_wheels() and
// by_parameters() are the twist's derivatives (docs/MATH.md "Drives and dead reckoning").
#pragma once

#include <Eigen/Core>
#include <array>

#include "majak/core/pose2.hpp"

namespace majak::motion {

/// Derivatives of a twist by some parameters, a column each; at most six, kept without the heap.
using ByParameters = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 6>;

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
  Eigen::Matrix<double, 3, 2> by_wheels() const;
  /// By the scales of the left and the right wheel's radius, and by the track (per m).
  ByParameters by_parameters(const Wheels& wheels) const;
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
  Eigen::Matrix<double, 3, 2> by_wheels(const Wheels& wheels) const;
  /// By the scale of the steered wheel's radius, the offset of the steering (per rad), and the
  /// wheelbase (per m).
  ByParameters by_parameters(const Wheels& wheels) const;
  /// Signed radius of the axle centre's circle, left positive; infinite on a straight.
  double radius(double steering) const;
};

/// Two steered wheels side by side, seen as the one wheel between them.
struct SteeredPair {
  double steering = 0;      ///< rad, of that wheel: its cotangent is the mean of the two
  double disagreement = 0;  ///< rad, between what the left and the right wheel alone say of it
  bool consistent = true;   ///< they agree, so that the inner wheel does follow the smaller circle
};

/// The middle wheel of a car whose front wheels, `track` apart, are turned by `left` and `right`
/// (rad, left positive, within +-pi/2). Wheels that disagree by more than `tolerance` (rad) roll
/// about two centres and slip: no tricycle's formula holds then.
SteeredPair steered_pair(double left, double right, double wheelbase, double track,
                         double tolerance = 0.02);

/// Three wheels at 120 degrees that roll sidewards freely; the robot's point is their centre.
/// d1 = dx + b turn; d2 = -dx/2 + sqrt(3)/2 dy + b turn; d3 = -dx/2 - sqrt(3)/2 dy + b turn.
struct Omnidirectional {
  double arm = 0.25;  ///< m from the centre to each wheel

  using Wheels = std::array<double, 3>;  ///< m rolled
  Vec3 forward(const Wheels& wheels) const;
  Wheels inverse(const Vec3& twist) const;
  Mat3 by_wheels() const;
  /// By the scale of each wheel's radius, and by the arm (per m).
  ByParameters by_parameters(const Wheels& wheels) const;
};

}  // namespace majak::motion
