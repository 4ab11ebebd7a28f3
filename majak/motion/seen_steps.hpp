// SPDX-License-Identifier: Apache-2.0
// Steps that wheels and laser both have seen.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/core/time.hpp"
#include "majak/motion/drive_correction.hpp"
#include "majak/motion/wheel_path.hpp"

namespace majak::motion {

/// Where the laser saw the robot, as one that carries the laser at its nominal place.
struct LaserPose {
  Time time = 0;
  Pose2 T_map_robot;
};

/// A step between two laser poses.
struct SeenStep {
  Pose2 wheels;     ///< as the wheels foretell it
  Pose2 laser;      ///< as the laser saw it
  double way = 0;   ///< m rolled during it, either way
  double turn = 0;  ///< rad turned during it, either way
  /// WheelPath::Point's at its begin and its end.
  double split_way_before = 0, split_turn_before = 0, split_way_after = 0, split_turn_after = 0;
  Vec3 doubt_before = Vec3::Zero(), doubt_after = Vec3::Zero();
  /// Of the robot there, per s (or per scan where the stamps tell only the order).
  Vec3 velocity_before = Vec3::Zero(), velocity_after = Vec3::Zero();
  bool broken = false;  ///< does not count: wheels and laser saw different things

  double seconds = 0;
  std::size_t end = 0;  ///< the laser pose that ends it

  Vec3 error() const { return log(between(wheels, laser)); }
};

/// From each laser pose to the next, where the wheels tell. D: the laser's true place against the
/// nominal one.
std::vector<SeenStep> seen_steps(const std::vector<LaserPose>& laser,
                                 const std::vector<WheelSample>& wheels,
                                 const DriveCorrection& correction, const Pose2& D,
                                 double wheelbase);

/// The robot's at the pose between step i - 1 and step i, from these twists of the steps.
Vec3 velocity_between(const std::vector<Vec3>& twists, const std::vector<SeenStep>& steps,
                      std::size_t i);

}  // namespace majak::motion
