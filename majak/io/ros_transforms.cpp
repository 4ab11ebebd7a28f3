// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_transforms.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace majak::io {

Motion3 Motion3::inverse() const {
  return {rotation.transpose(), -(rotation.transpose() * translation)};
}

Motion3 operator*(const Motion3& a, const Motion3& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

Motion3 motion_of(const ros::Transform& transform) {
  const auto& [x, y, z, w] = transform.rotation;
  const double norm = x * x + y * y + z * z + w * w;
  Motion3 motion;
  motion.translation =
      Vec3(transform.translation[0], transform.translation[1], transform.translation[2]);
  if (!(norm > 1e-12) || !std::isfinite(norm)) return motion;
  const double s = 2.0 / norm;
  motion.rotation << 1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),
      s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w), s * (x * z - y * w),
      s * (y * z + x * w), 1 - s * (x * x + y * y);
  return motion;
}

Pose2 planar_pose(const ros::Transform& transform) {
  const auto& [x, y, z, w] = transform.rotation;
  Pose2 pose{transform.translation[0], transform.translation[1], 0};
  if (x == 0 && y == 0) {
    if (z != 0 || w != 0) pose.theta = wrap_angle(2.0 * std::atan2(z, w));
  } else {
    const Mat3 rotation = motion_of(transform).rotation;
    pose.theta = std::atan2(rotation(1, 0), rotation(0, 0));
  }
  return pose;
}

Mounting mounting_of(const Motion3& T_robot_laser) {
  const Mat3& rotation = T_robot_laser.rotation;
  Mounting mounting;
  mounting.T_robot_laser = {T_robot_laser.translation.x(), T_robot_laser.translation.y(),
                            wrap_angle(std::atan2(rotation(1, 0), rotation(0, 0)))};
  mounting.upside_down = rotation(2, 2) < 0;
  mounting.tilted = std::abs(rotation(2, 2)) < std::cos(radians(15));
  return mounting;
}

void FrameTree::set(const ros::StampedTransform& transform) {
  const auto& child = transform.child_frame;
  const auto& numbers = transform.transform;
  double sum = 0;
  for (const double value : numbers.translation) sum += value;
  for (const double value : numbers.rotation) sum += value;
  if (!std::isfinite(sum) || child.empty() || child == transform.header.frame) return;
  if (links_.size() >= kMostFrames && !links_.contains(child)) return;
  links_[child] = {transform.header.frame, motion_of(numbers)};
}

void FrameTree::set_if_new(const ros::StampedTransform& transform) {
  if (!links_.contains(transform.child_frame)) set(transform);
}

/// The frame, its parent, and so on up to the root.
std::vector<std::string> FrameTree::up_from(std::string frame) const {
  std::vector<std::string> path;
  for (int i = 0; i < kDeepest; ++i) {
    path.push_back(frame);
    const auto link = links_.find(frame);
    if (link == links_.end()) return path;
    frame = link->second.parent;
  }
  return {};
}

std::optional<Motion3> FrameTree::find(const std::string& parent, const std::string& child) const {
  const std::vector<std::string> from_parent = up_from(parent), from_child = up_from(child);
  const auto common = std::find_first_of(from_parent.begin(), from_parent.end(), from_child.begin(),
                                         from_child.end());
  if (common == from_parent.end()) return std::nullopt;
  const auto down_to = [&](const std::vector<std::string>& path) {
    Motion3 T_common_last;
    for (const std::string& frame : path) {
      if (frame == *common) break;
      T_common_last = links_.at(frame).T_parent_child * T_common_last;
    }
    return T_common_last;
  };
  return down_to(from_parent).inverse() * down_to(from_child);
}

std::string FrameTree::parent_of(const std::string& child) const {
  const auto link = links_.find(child);
  return link == links_.end() ? std::string() : link->second.parent;
}

}  // namespace majak::io
