// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/wheel_step.hpp"

#include <cmath>

namespace majak::motion {

WheelStep wheel_step(const WheelMotion& wheels, double seconds, double wheelbase) {
  const double d = wheels.speed * seconds, t = std::tan(wheels.steering), turn = d * t / wheelbase;
  WheelStep step;
  step.twist = {d, 0, turn};
  step.by_numbers(0, WheelStep::kScale) = d;
  step.by_numbers(2, WheelStep::kScale) = turn;
  step.by_numbers(2, WheelStep::kTurnScale) = d * (1 + t * t) / wheelbase * wheels.steering;
  step.by_numbers(2, WheelStep::kTurnOffset) = d;
  step.by_numbers(2, WheelStep::kCurve) = d * std::pow(wheels.steering, 3) / wheelbase;
  step.by_numbers(2, WheelStep::kSquare) = d * wheels.steering * wheels.steering / wheelbase;
  return step;
}

WheelStep wheel_step(const Vec3& twist) {
  WheelStep step;
  step.twist = twist;
  step.by_numbers.block<2, 1>(0, WheelStep::kScale) = twist.head<2>();
  step.by_numbers(2, WheelStep::kTurnScale) = twist.z();
  step.by_numbers(2, WheelStep::kTurnOffset) = twist.x();
  return step;
}

Vec3 step_variance(const Vec3& twist, const WheelRandom& r) {
  const double way = twist.head<2>().norm(), turn = std::abs(twist.z());
  return {r.way_noise * r.way_noise * way, r.side_noise * r.side_noise * way,
          r.turn_noise * r.turn_noise * way + r.spin_noise * r.spin_noise * turn};
}

}  // namespace majak::motion
