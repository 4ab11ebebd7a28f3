// SPDX-License-Identifier: Apache-2.0
// MotionInput: what the wheels say between two moments at which something is measured, for any
// drive: records of speed and steering, or poses of the odometry, or those in the scans themselves.
#pragma once

#include <optional>

#include "majak/core/event.hpp"
#include "majak/filter/landmark_filter.hpp"
#include "majak/motion/wheel_step.hpp"

namespace majak::slam {

class MotionInput {
 public:
  static constexpr int kExtra = filter::LandmarkFilter::kExtra;
  /// Among the extra numbers: those of the wheels; by how much the robot drives to the left of
  /// where its laser's mounting says ahead is, rad; how late the wheels tell of it, s.
  static constexpr int kCrab = motion::WheelStep::kNumbers, kLag = kCrab + 1;
  static constexpr int kNumbers = kLag + 1;
  using Motion = filter::RelativeInput<kExtra>;

  /// No motion, with scales of one and no offsets.
  static Motion counted_right();

  /// `idle`: m and rad per sqrt(s), until the wheels tell something; `wander`: rad per
  /// sqrt(m), how the direction in which it drives changes with the ground.
  MotionInput(const motion::WheelRandom& random, double wheelbase, double idle, double wander = 0);

  /// Of a log that has both kinds the first to come counts.
  void add(const WheelMotion& wheels);
  void add(const Odometry& odometry);

  /// The motion since the last call up to `time`, with scales of one and no offsets; the wheels go
  /// on as they did last.
  Motion take(Time time);
  /// m/s, m/s, rad/s by the newest record, as the wheels count.
  const Vec3& twist() const { return twist_; }
  double way() const { return way_; }        ///< m driven so far, either way
  double turned() const { return turned_; }  ///< rad
  bool told() const { return wheels_ || odometry_; }
  /// m driven, either way, since a car's steering last read anything else.
  double steering_held() const { return wheels_ ? way_ - steered_at_ : 0; }
  /// The most of that before; infinite until some readings tell how it behaves.
  double steering_held_before() const;

 private:
  void roll(const motion::WheelStep& step);
  void go_on(Time time);

  motion::WheelRandom random_;
  double wheelbase_, idle_, wander_;
  Motion pending_;
  std::optional<WheelMotion> wheels_;
  std::optional<Odometry> odometry_;
  Pose2 T_odom_now_;                                        ///< where the odometry would be by now
  Vec3 twist_ = Vec3::Zero(), taken_twist_ = Vec3::Zero();  ///< now, and when taken last
  Time clock_ = 0;
  bool begun_ = false;
  double way_ = 0, turned_ = 0, steered_at_ = 0, held_ = 0;
  int readings_ = 0;  ///< that differ from the one before
};

}  // namespace majak::slam
