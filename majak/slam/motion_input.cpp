// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/motion_input.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace majak::slam {
namespace {

constexpr double kLongest = 0.5;  // s that the odometry's last velocity is taken to hold
constexpr int kReadings = 30;     // of the steering that tell how often it stays the same
constexpr double kSame = 1e-7;    // rad, between readings that are the same

}  // namespace

MotionInput::Motion MotionInput::counted_right() {
  MotionInput::Motion motion;
  motion.at(motion::WheelStep::kScale) = motion.at(motion::WheelStep::kTurnScale) = 1;
  return motion;
}

MotionInput::MotionInput(const motion::WheelRandom& random, double wheelbase, double idle,
                         double wander)
    : random_(random),
      wheelbase_(wheelbase),
      idle_(idle),
      wander_(wander),
      pending_(counted_right()) {}

void MotionInput::roll(const motion::WheelStep& wheels) {
  Motion step;
  step.at = pending_.at;
  step.T_from_to = exp(wheels.twist);
  Eigen::Matrix<double, 3, kNumbers> by_numbers;
  by_numbers << wheels.by_numbers, Vec3(-wheels.twist.y(), wheels.twist.x(), 0), Vec3::Zero();
  step.by_extra.leftCols<kNumbers>() = right_jacobian(wheels.twist) * by_numbers;
  step.noise.diagonal() = motion::step_variance(wheels.twist, random_);
  step.extra_noise(kCrab) = wander_ * wander_ * wheels.twist.head<2>().norm();
  pending_.then(step);
  way_ += wheels.twist.head<2>().norm();
  turned_ += std::abs(wheels.twist.z());
}

// Up to a time that no record speaks of yet.
void MotionInput::go_on(Time time) {
  const double seconds = begun_ ? std::max(0.0, to_seconds(time - clock_)) : 0;
  if (wheels_) {
    roll(motion::wheel_step(*wheels_, seconds, wheelbase_));
  } else if (odometry_) {
    const double known = to_seconds(clock_ - odometry_->time);
    const Vec3 step = std::clamp(kLongest - known, 0.0, seconds) * twist_;
    T_odom_now_ = T_odom_now_ * exp(step);
    roll(motion::wheel_step(step));
  } else {
    pending_.noise.diagonal().array() += idle_ * idle_ * seconds;
  }
  clock_ = begun_ ? std::max(clock_, time) : time;
  begun_ = true;
}

void MotionInput::add(const WheelMotion& wheels) {
  if (odometry_) return;
  go_on(wheels.time);
  if (!wheels_ || std::abs(wheels.steering - wheels_->steering) > kSame) {
    held_ = std::max(held_, way_ - steered_at_);
    steered_at_ = way_;
    ++readings_;
  }
  wheels_ = wheels;
  const double turn = wheels.speed * std::tan(wheels.steering) / wheelbase_;
  twist_ = {wheels.speed, 0, turn};
}

void MotionInput::add(const Odometry& odometry) {
  if (wheels_ || (odometry_ && odometry.time <= odometry_->time)) return;
  if (odometry_) {
    roll(motion::wheel_step(log(between(T_odom_now_, odometry.T_odom_robot))));
    twist_ = log(between(odometry_->T_odom_robot, odometry.T_odom_robot)) /
             to_seconds(odometry.time - odometry_->time);
  }
  odometry_ = odometry;
  T_odom_now_ = odometry.T_odom_robot;
  clock_ = odometry.time;  // back from where it was guessed to be, if it comes late
  begun_ = true;
}

double MotionInput::steering_held_before() const {
  return readings_ < kReadings ? std::numeric_limits<double>::infinity() : held_;
}

MotionInput::Motion MotionInput::take(Time time) {
  go_on(time);
  // Of wheels that are late: exp(-lag v) T exp(lag v'), what they told of too late at either end.
  pending_.by_extra.col(kLag) = twist_ - adjoint(pending_.T_from_to.inverse()) * taken_twist_;
  taken_twist_ = twist_;
  return std::exchange(pending_, counted_right());
}

}  // namespace majak::slam
