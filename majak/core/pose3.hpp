// SPDX-License-Identifier: Apache-2.0
// Pose3: a pose in space, an element of SE(3). Frames are in the names, as for Pose2; z is up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "majak/core/pose2.hpp"

namespace majak {

struct Pose3 {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  ///< m

  Pose3 inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

inline Pose3 operator*(const Pose3& a, const Pose3& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}
inline Vec3 operator*(const Pose3& a, const Vec3& p) { return a.rotation * p + a.translation; }

/// A pose in the plane z = 0.
inline Pose3 in_space(const Pose2& pose) {
  return {Eigen::AngleAxisd(pose.theta, Vec3::UnitZ()).toRotationMatrix(), {pose.x, pose.y, 0}};
}

/// Turned by roll about x, then by pitch about y (up: negative), then by yaw about z; all rad, axes
/// of the frame that it is turned in.
inline Mat3 rotation_of(double roll, double pitch, double yaw) {
  return (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch, Vec3::UnitY()) *
          Eigen::AngleAxisd(roll, Vec3::UnitX()))
      .toRotationMatrix();
}

}  // namespace majak
