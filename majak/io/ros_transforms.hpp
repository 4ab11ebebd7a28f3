// SPDX-License-Identifier: Apache-2.0
// FrameTree: which frame stands where in which other one, as tf tells it; and what of it matters in
// the plane.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/io/ros_messages.hpp"

namespace majak::io {

inline constexpr const char* kEarthFrame = "earth";  ///< Earth-centred, Earth-fixed (REP 105)

/// A rigid motion in space.
struct Motion3 {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Motion3 inverse() const;
};
Motion3 operator*(const Motion3& a, const Motion3& b);

/// A quaternion of any length but zero, which counts as no rotation.
Motion3 motion_of(const ros::Transform& transform);

/// Seen from above: the x axis gives the heading. Exact for a rotation about z.
Pose2 planar_pose(const ros::Transform& transform);

/// How a laser stands on its robot.
struct Mounting {
  Pose2 T_robot_laser;
  bool upside_down = false;  ///< its beams then turn the other way round
  bool tilted = false;       ///< by more than 15 degrees out of the level
};
Mounting mounting_of(const Motion3& T_robot_laser);

class FrameTree {
 public:
  /// The last word about a frame counts, its parent included.
  void set(const ros::StampedTransform& transform);
  /// The first word about it counts.
  void set_if_new(const ros::StampedTransform& transform);

  /// Where `child` stands in `parent`, whichever way the tree leads; nothing when it does not.
  std::optional<Motion3> find(const std::string& parent, const std::string& child) const;
  /// The frame that this one was placed in; empty at a root.
  std::string parent_of(const std::string& child) const;

 private:
  struct Link {
    std::string parent;
    Motion3 T_parent_child;
  };
  static constexpr std::size_t kMostFrames = 10000;
  static constexpr int kDeepest = 100;  ///< what is deeper runs in a circle

  std::vector<std::string> up_from(std::string frame) const;

  std::map<std::string, Link> links_;  ///< by child
};

}  // namespace majak::io
