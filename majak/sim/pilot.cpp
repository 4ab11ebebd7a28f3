// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/pilot.hpp"

#include <algorithm>
#include <cmath>

namespace majak::sim {

namespace {

constexpr double kLookAhead = 0.5;       // m, or a wheelbase where that is more
constexpr std::size_t kWindow = 10;      // points among which the nearest is sought
constexpr double kSharp = 1.0;           // rad; beyond, the robot turns before it drives on
constexpr double kBack = 2.2;            // rad; beyond, it backs away from what is ahead first
constexpr double kBackOut = 0.5;         // m
constexpr double kShunt = 0.3;           // m in one gear
constexpr double kSlow = 0.25;           // m/s, backwards and to and fro
constexpr double kTurnAcceleration = 2;  // rad/s^2
constexpr double kSteeringRate = 1.5;    // rad/s

}  // namespace

double Pilot::approach(double value, double goal, double step) const {
  return value + std::clamp(goal - value, -step, step);
}

/// The nearest point of the path's next metre, and only ever onwards.
void Pilot::advance(const Vec2& here) {
  const std::size_t last = path_.points.size() - 1;
  std::size_t best = at_;
  double best_distance = (path_.points[at_] - here).squaredNorm();
  for (std::size_t i = at_ + 1; i <= std::min(at_ + kWindow, last); ++i) {
    const double d = (path_.points[i] - here).squaredNorm();
    if (d < best_distance) {
      best = i;
      best_distance = d;
    }
  }
  at_ = best;
  arrived_ = arrived_ || at_ + 1 >= last;
}

double Pilot::speed_allowed() const {
  const double left = kPathStep * static_cast<double>(path_.points.size() - 1 - at_);
  return std::min(options_.speed, std::sqrt(2 * options_.acceleration * left) + 0.02);
}

Vec3 Pilot::next_twist(const Pose2& T_world_robot, double dt) {
  advance(T_world_robot.translation());
  if (arrived_) {
    twist_.x() = approach(twist_.x(), 0, options_.acceleration * dt);
    twist_.y() = approach(twist_.y(), 0, options_.acceleration * dt);
    const bool car = options_.drive == DriveKind::ackermann;
    twist_.z() = car ? twist_.x() * std::tan(steering_) / options_.wheelbase
                     : approach(twist_.z(), 0, kTurnAcceleration * dt);
    return twist_;
  }
  const bool steered = options_.drive == DriveKind::ackermann;
  const double ahead = steered ? std::max(kLookAhead, options_.wheelbase) : kLookAhead;
  const auto points = static_cast<std::size_t>(std::lround(ahead / kPathStep));
  const std::size_t aim = std::min(at_ + points, path_.points.size() - 1);
  const Vec2 to_aim = path_.points[aim] - T_world_robot.translation();
  const double error = angle_diff(std::atan2(to_aim.y(), to_aim.x()), T_world_robot.theta);
  switch (options_.drive) {
    case DriveKind::omnidirectional:
      return twist_ = slide(error, dt);
    case DriveKind::ackermann:
      if (mode_ == Mode::follow && std::abs(error) > kSharp + 0.5) {
        mode_ = Mode::shunt;
        turn_sign_ = error > 0 ? 1 : -1;
        gear_ = -1;
        driven_ = 0;
      }
      return twist_ = mode_ == Mode::shunt ? shunt(error, dt) : pursue(error, to_aim.norm(), dt);
    case DriveKind::differential:
      break;
  }
  if (mode_ == Mode::follow && std::abs(error) > kSharp) {
    mode_ = std::abs(error) > kBack ? Mode::back_out : Mode::spin;
    turn_sign_ = error > 0 ? 1 : -1;
    driven_ = 0;
  }
  return twist_ =
             mode_ == Mode::follow ? pursue(error, to_aim.norm(), dt) : turn_on_the_spot(error, dt);
}

Vec3 Pilot::pursue(double error, double distance, double dt) {
  const double curvature = 2 * std::sin(error) / std::max(distance, 0.1);
  double goal = speed_allowed() / (1 + 0.4 * std::abs(curvature));
  goal = std::min(goal, options_.turn_rate / std::max(std::abs(curvature), 1e-9));
  const double speed = approach(twist_.x(), goal, options_.acceleration * dt);
  if (options_.drive == DriveKind::ackermann) {
    const double steering = std::clamp(std::atan(options_.wheelbase * curvature),
                                       -options_.max_steering, options_.max_steering);
    steering_ = approach(steering_, steering, kSteeringRate * dt);
    return {speed, 0, speed * std::tan(steering_) / options_.wheelbase};
  }
  const double turn = std::clamp(speed * curvature, -options_.turn_rate, options_.turn_rate);
  return {speed, 0, approach(twist_.z(), turn, kTurnAcceleration * dt)};
}

Vec3 Pilot::turn_on_the_spot(double error, double dt) {
  double speed = 0, turn = 0;
  if (mode_ == Mode::back_out) {
    speed = -kSlow;
    driven_ += std::abs(std::min(0.0, twist_.x())) * dt;
    if (driven_ > kBackOut) mode_ = Mode::spin;
  } else {
    // Round the chosen way until the aim is ahead; slower as it comes near.
    turn = turn_sign_ * std::min(options_.turn_rate, 0.1 + 1.5 * std::abs(error));
    if (std::abs(error) < 0.15) mode_ = Mode::follow;
  }
  return {approach(twist_.x(), speed, options_.acceleration * dt), 0,
          approach(twist_.z(), turn, kTurnAcceleration * dt)};
}

/// To and fro at full lock: both gears turn the car the same way round.
Vec3 Pilot::shunt(double error, double dt) {
  if (std::abs(error) < 0.5) mode_ = Mode::follow;
  driven_ += std::max(0.0, gear_ * twist_.x()) * dt;
  if (driven_ > kShunt) {
    gear_ = -gear_;
    driven_ = 0;
  }
  const double speed = approach(twist_.x(), gear_ * kSlow, options_.acceleration * dt);
  // The wheel follows the motion, not the wish: no turning the wrong way while braking.
  const double sense = speed >= 0 ? 1 : -1;
  steering_ =
      approach(steering_, sense * turn_sign_ * options_.max_steering, 4 * kSteeringRate * dt);
  return {speed, 0, speed * std::tan(steering_) / options_.wheelbase};
}

/// An omnidirectional robot goes straight to its aim, whatever way it faces, and turns meanwhile.
Vec3 Pilot::slide(double error, double dt) {
  const Vec2 goal = speed_allowed() * Vec2(std::cos(error), std::sin(error));
  Vec2 change = goal - twist_.head<2>();
  const double most = options_.acceleration * dt;
  if (change.norm() > most) change *= most / change.norm();
  const Vec2 velocity = twist_.head<2>() + change;
  const double turn = std::clamp(1.2 * error, -options_.turn_rate, options_.turn_rate);
  return {velocity.x(), velocity.y(), approach(twist_.z(), turn, kTurnAcceleration * dt)};
}

}  // namespace majak::sim
