// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/wheel_step.hpp"

#include <gtest/gtest.h>

#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

// Scale, turn scale, turn offset, cube and square of the steering.
using Numbers = Eigen::Matrix<double, 5, 1>;
const Numbers kRight = (Numbers() << 1, 1, 0, 0, 0).finished();

// The car once more: what it does if its wheels count wrongly by these numbers.
Vec3 car(const WheelMotion& wheels, double seconds, double wheelbase, const Numbers& n) {
  const double way = n(0) * wheels.speed * seconds;
  const double steered = n(1) * wheels.steering;
  const double curve =
      n(3) * std::pow(wheels.steering, 3) + n(4) * wheels.steering * wheels.steering;
  return {way, 0, way * (std::tan(steered) / wheelbase + n(2) + curve / wheelbase)};
}

Vec3 odometry(const Vec3& counted, const Numbers& n) {
  return {n(0) * counted.x(), n(0) * counted.y(), n(1) * counted.z() + n(2) * counted.x()};
}

template <class Drive>
WheelStep::Derivative slope(const Drive& drive) {
  constexpr double kStep = 1e-5;
  WheelStep::Derivative d;
  for (int k = 0; k < 5; ++k) {
    Numbers ahead = kRight, back = ahead;
    ahead(k) += kStep, back(k) -= kStep;
    d.col(k) = (drive(ahead) - drive(back)) / (2 * kStep);
  }
  return d;
}

TEST(WheelStep, OfACarIsItsTwistAndItsDerivatives) {
  RandomStream random(1);
  for (int i = 0; i < 500; ++i) {
    const WheelMotion wheels{0, random.uniform(-5, 8), random.uniform(-0.7, 0.7)};
    const double seconds = random.uniform(0, 0.5), base = random.uniform(0.3, 4);
    const WheelStep step = wheel_step(wheels, seconds, base);
    const auto drive = [&](const Numbers& n) { return car(wheels, seconds, base, n); };
    EXPECT_LT((step.twist - drive(kRight)).norm(), 1e-15);
    EXPECT_LT((step.by_numbers - slope(drive)).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(WheelStep, OfOdometryIsItsTwistAndItsDerivatives) {
  RandomStream random(2);
  for (int i = 0; i < 500; ++i) {
    const Vec3 counted(random.normal(), random.normal(), random.normal());
    const WheelStep step = wheel_step(counted);
    EXPECT_EQ(step.twist, counted);
    const auto drive = [&](const Numbers& n) { return odometry(counted, n); };
    EXPECT_LT((step.by_numbers - slope(drive)).cwiseAbs().maxCoeff(), 1e-9);
  }
}

// A car that drives straight, and odometry that says the same, are the same step.
TEST(WheelStep, OnAStraightBothDrivesAgree) {
  const WheelStep car = wheel_step({0, 3, 0}, 0.2, 2.7), counted = wheel_step(Vec3(0.6, 0, 0));
  EXPECT_LT((car.twist - counted.twist).norm(), 1e-15);
  EXPECT_LT((car.by_numbers - counted.by_numbers).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(WheelStep, StandingStillTellsNothing) {
  for (const WheelStep& step :
       {wheel_step({0, 0, 0.3}, 1, 2), wheel_step({0, 2, 0.3}, 0, 2), wheel_step(Vec3::Zero())}) {
    EXPECT_EQ(step.twist, Vec3::Zero());
    EXPECT_EQ(step.by_numbers, WheelStep::Derivative::Zero());
    EXPECT_EQ(step_variance(step.twist, {}), Vec3::Zero());
  }
}

TEST(WheelStep, TheCircleIsThatOfTheAckermannDrive) {
  const double base = 2.7, steering = 0.3;
  const WheelStep step = wheel_step({0, 2, steering}, 0.5, base);
  EXPECT_NEAR(step.twist.x() / step.twist.z(), base / std::tan(steering), 1e-12);
}

// A random walk: two halves of a step err by as much as the whole; backward is as bad as ahead.
TEST(WheelStep, VariancesOfPartsAddUp) {
  const WheelRandom r{0.03, 0.02, 0.01, 0.05};
  RandomStream random(3);
  for (int i = 0; i < 100; ++i) {
    const Vec3 twist(random.normal(), random.normal(), random.normal());
    const Vec3 whole = step_variance(twist, r);
    const Vec3 parts = step_variance(0.3 * twist, r) + step_variance(0.7 * twist, r);
    EXPECT_LT((whole - parts).norm(), 1e-15);
    EXPECT_EQ(step_variance(-twist, r), whole);
    EXPECT_GE(whole.minCoeff(), 0);
  }
}

TEST(WheelStep, VarianceOfTheWayAndOfTheTurn) {
  const WheelRandom r{0.03, 0.02, 0.01, 0.05};
  EXPECT_LT((step_variance({4, 0, 0}, r) - Vec3(0.0036, 0.0016, 0.0004)).norm(), 1e-15);
  EXPECT_LT((step_variance({0, 0, -2}, r) - Vec3(0, 0, 0.005)).norm(), 1e-15);
  EXPECT_LT((step_variance({3, 4, 2}, r) - Vec3(0.0045, 0.002, 0.0055)).norm(), 1e-15);
}

}  // namespace
}  // namespace majak::motion
