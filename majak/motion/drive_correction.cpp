// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/drive_correction.hpp"

#include <cmath>

namespace majak::motion {
namespace {

// A step that no robot makes, in m and rad: so much at once, and so much a second.
constexpr double kMostStep = 2, kMostSpeed = 40, kMostTurn = 1.5, kMostTurnRate = 10;

}  // namespace

void describe(OptionFields& f, DriveCorrection& o) {
  f.add("odometry.lag", o.lag, {"s", "the odometry is this much later than the laser", -2, 2});
  f.add("odometry.scale", o.scale, {"1", "true way per way of the odometry", 0.01, 100});
  f.add("odometry.turn_scale", o.turn_scale, {"1", "the same of its turns", 0.01, 100});
  f.add("odometry.turn_per_metre", o.turn_per_metre,
        {"rad/m", "added, for unequal wheels; left positive", -1, 1});
  f.add("odometry.way_per_turn", o.way_per_turn, {"m/rad", "added, for unequal wheels", -1, 1});
  f.add("odometry.steering_offset", o.steering_offset,
        {"rad", "added to the steering, Ackermann drive", -0.5, 0.5});
  f.add("odometry.wheelbase", o.wheelbase,
        {"m", "of a car that reports speed and steering; 0: not told", 0, 20});
  f.add("odometry.reversed", o.reversed, {"", "the log counts backing as a way ahead"});
  f.add("odometry.mounting", o.mounting, {"", "true: the laser sits where the next three say"});
  f.add("odometry.laser_x", o.laser_x, {"m", "laser ahead of the robot's point", -100, 100});
  f.add("odometry.laser_y", o.laser_y, {"m", "laser to the left of it", -100, 100});
  f.add("odometry.laser_theta", o.laser_theta, {"rad", "laser's heading", -3.2, 3.2});
}

Vec3 corrected(const DriveCorrection& c, const Vec3& twist) {
  return {c.scale * twist.x() + c.way_per_turn * twist.z(), c.scale * twist.y(),
          c.turn_scale * twist.z() + c.turn_per_metre * twist.x()};
}

WheelMotion corrected(const DriveCorrection& c, const WheelMotion& wheels) {
  const double curvature = std::tan(wheels.steering + c.steering_offset);
  return {wheels.time, c.scale * wheels.speed, std::atan(c.turn_scale / c.scale * curvature)};
}

bool leaps(const Pose2& step, double seconds) {
  return step.translation().norm() > kMostStep + kMostSpeed * seconds ||
         std::abs(step.theta) > kMostTurn + kMostTurnRate * seconds;
}

Pose2 turned_round(const Pose2& step, double speed) {
  return speed < 0 && step.x > 0 ? Pose2{-step.x, -step.y, step.theta} : step;
}

Pose2 CorrectedDrive::next(Chain& chain, Time time, const Pose2& raw) const {
  if (!chain.raw) {
    chain = {raw, raw, time};
    return raw;
  }
  Pose2 step = between(*chain.raw, raw);
  if (correction_.reversed) step = turned_round(step, speed_);
  // A leap is left as it is: whoever uses the odometry knows it by its size.
  if (!leaps(step, std::abs(to_seconds(time - chain.time))))
    step = exp(corrected(correction_, log(step)));
  chain = {raw, *chain.mended * step, time};
  return *chain.mended;
}

void CorrectedDrive::apply(Event& event) {
  const Duration lag = from_seconds(correction_.lag);
  if (correction_ == DriveCorrection{}) return;
  if (auto* odometry = std::get_if<Odometry>(&event)) {
    speed_ = odometry->speed.value_or(0);
    odometry->T_odom_robot = next(stream_, odometry->time, odometry->T_odom_robot);
    odometry->time -= lag;
    if (odometry->speed) *odometry->speed *= correction_.scale;
    if (odometry->turn_rate)
      *odometry->turn_rate = corrected(correction_, Vec3(speed_, 0, *odometry->turn_rate)).z();
  } else if (auto* wheels = std::get_if<WheelMotion>(&event)) {
    *wheels = corrected(correction_, *wheels);
    wheels->time -= lag;
  } else if (auto* scan = std::get_if<Scan>(&event); scan != nullptr && scan->laser == 0) {
    if (correction_.mounting)
      scan->T_robot_laser = {correction_.laser_x, correction_.laser_y, correction_.laser_theta};
    if (scan->T_odom_robot)
      scan->T_odom_robot =
          lag == 0 ? std::optional(next(records_, scan->time, *scan->T_odom_robot)) : std::nullopt;
  }
}

}  // namespace majak::motion
