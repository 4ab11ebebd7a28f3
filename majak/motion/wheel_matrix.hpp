// SPDX-License-Identifier: Apache-2.0
// WheelMatrix: any number of wheels that roll freely in some direction (omnidirectional, mecanum).
// One row of a matrix a wheel says how far it rolls under a twist; the twist under which they
// rolled as they did is the one of least squares, and what then remains is slip.
//
// The robot's frame and twists are those of motion/drive.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::motion {

/// A wheel with rollers on its rim.
struct RollerWheel {
  Vec2 place = Vec2::Zero();  ///< m, where it stands on the robot
  double heading = 0;         ///< rad, whither it rolls
  double rollers = 0;  ///< rad, axis of the rollers against the heading: 0 omni, +-pi/4 mecanum
};

class WheelMatrix {
 public:
  /// Throws Error when rollers stand across the heading (nothing drives then), or when the wheels
  /// leave some motion undetermined (fewer than three, say).
  explicit WheelMatrix(const std::vector<RollerWheel>& wheels);

  /// How far each wheel rolls, m.
  Eigen::VectorXd inverse(const Vec3& twist) const { return matrix_ * twist; }

  struct Motion {
    Vec3 twist = Vec3::Zero();
    Eigen::VectorXd slip;  ///< m, of each wheel: rolled, less what the twist explains
  };
  Motion forward(const Eigen::VectorXd& rolled) const;

  /// Derivative of the twist by what the wheels rolled: the pseudo-inverse, 3 x N.
  const Eigen::Matrix3Xd& by_wheels() const { return inverse_; }
  /// By the scale of each wheel's radius.
  Eigen::Matrix3Xd by_scales(const Eigen::VectorXd& rolled) const {
    return inverse_ * rolled.asDiagonal();
  }

 private:
  Eigen::MatrixX3d matrix_;
  Eigen::Matrix3Xd inverse_;
};

/// `count` wheels on a circle, equally apart, each rolling along it counter-clockwise; the first
/// one stands to the right and rolls ahead, as wheel 1 of Omnidirectional does.
std::vector<RollerWheel> omni_wheels(int count, double arm);

/// Front left, front right, rear left, rear right, `length` apart along and `width` across; the
/// rollers on the ground form a diamond's sides seen from above, an X seen from below.
std::vector<RollerWheel> mecanum_wheels(double length, double width);

}  // namespace majak::motion
