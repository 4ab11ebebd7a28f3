// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/drive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

Vec3 random_twist(RandomStream& r) {
  return {r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-2, 2)};
}

void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  EXPECT_LT((a - b).norm(), tolerance) << a.transpose() << " against " << b.transpose();
}

// Ackermann, A002 ... A005.

TEST(Ackermann, CentreOfTheCircleLiesOnTheAxle) {
  const Ackermann drive{1.2};
  for (const double steering : {-1.2, -0.4, -1e-3, 1e-3, 0.4, 1.2}) {
    const double radius = drive.radius(steering);
    EXPECT_NEAR(radius, 1.2 / std::tan(steering), 1e-12 * std::abs(radius));
    const Pose2 T = exp(drive.forward({0.5, steering}));
    // The point of the axle's line at R stays where it is.
    const Vec2 centre(0, radius);
    EXPECT_LT((T * centre - centre).norm(), 1e-9 * std::abs(radius));
  }
}

TEST(Ackermann, SteeredWheelRollsItsWayAndPointsAlongIt) {
  const Ackermann drive{1.2};
  for (const double steering : {-0.7, 0.2, 1.0}) {
    const double radius = drive.radius(steering);
    const double wheel_radius = std::hypot(radius, 1.2);
    const Vec3 twist = drive.forward({0.5, steering});
    EXPECT_NEAR(std::abs(twist.z()) * wheel_radius, 0.5, 1e-12);
    // Velocity of the wheel's point (l, 0).
    EXPECT_NEAR(std::atan2(twist.z() * 1.2, twist.x()), steering, 1e-12);
  }
}

TEST(Ackermann, ClosedForms) {
  const Ackermann drive{1.2};
  const Vec3 twist = drive.forward({0.5, 0.4});
  const double radius = 1.2 / std::tan(0.4), turn = 0.5 * std::cos(0.4) / radius;
  EXPECT_NEAR(turn, 0.16226, 5e-6);
  EXPECT_NEAR(twist.z(), turn, 1e-12);
  const Pose2 T = exp(twist);
  EXPECT_NEAR(T.x, radius * std::sin(turn), 1e-12);           // ahead
  EXPECT_NEAR(T.y, radius - radius * std::cos(turn), 1e-12);  // towards the centre
  EXPECT_NEAR(T.theta, turn, 1e-12);
}

TEST(Ackermann, StraightIsTheLimit) {
  const Ackermann drive{1.2};
  expect_near(drive.forward({0.5, 0}), {0.5, 0, 0}, 1e-300);
  EXPECT_TRUE(std::isinf(drive.radius(0)));
  for (const double steering : {1e-12, -1e-12, 1e-6}) {
    const Pose2 T = exp(drive.forward({0.5, steering}));
    EXPECT_NEAR(T.x, 0.5, 1e-11);
    EXPECT_NEAR(T.y, 0.5 * 0.5 * steering / 2.4, 1e-15);  // half of d^2 / R
  }
}

TEST(Ackermann, LeftAndRightMirrorEachOther) {
  const Ackermann drive{0.8};
  const Pose2 left = exp(drive.forward({0.7, 0.5})), right = exp(drive.forward({0.7, -0.5}));
  EXPECT_DOUBLE_EQ(left.x, right.x);
  EXPECT_DOUBLE_EQ(left.y, -right.y);
  EXPECT_DOUBLE_EQ(left.theta, -right.theta);
}

TEST(Ackermann, InverseUndoesForward) {
  RandomStream r(1);
  const Ackermann drive{0.8};
  for (int i = 0; i < 1000; ++i) {
    const Ackermann::Wheels w{r.uniform(-1, 1), r.uniform(-1.4, 1.4)};
    const auto back = drive.inverse(drive.forward(w));
    EXPECT_NEAR(back.way, w.way, 1e-12);
    EXPECT_NEAR(back.steering, w.steering, 1e-9);
  }
  EXPECT_EQ(drive.inverse(Vec3::Zero()).way, 0);
}

// Differential, A007 ... A010.

TEST(Differential, StraightAndSpinAreExact) {
  const Differential drive{0.4};
  EXPECT_EQ(drive.forward({0.3, 0.3}), Vec3(0.3, 0, 0));
  const Vec3 spin = drive.forward({-0.2, 0.2});
  EXPECT_EQ(spin.x(), 0);
  EXPECT_DOUBLE_EQ(spin.z(), 1.0);
  const Pose2 T = exp(spin);
  EXPECT_EQ(T.x, 0);
  EXPECT_EQ(T.y, 0);
}

TEST(Differential, CircleFromTheWheelsRatio) {
  const double track = 0.5;
  const Differential drive{track};
  for (const auto& w :
       {Differential::Wheels{0.2, 0.5}, {0.5, 0.2}, {-0.1, 0.4}, {0.3, 0.3000001}}) {
    const Vec3 twist = drive.forward(w);
    const double radius = track / 2 * (w.right + w.left) / (w.right - w.left);
    EXPECT_NEAR(twist.z(), (w.right - w.left) / track, 1e-15);
    EXPECT_NEAR(twist.x(), (w.left + w.right) / 2, 1e-15);
    const Vec2 centre(0, radius);
    EXPECT_LT((exp(twist) * centre - centre).norm(), 1e-9 * (1 + std::abs(radius)));
    // Each wheel rolls its own arc; measured from the left wheel the circle is track
    // left/(right-left).
    EXPECT_NEAR((radius - track / 2) * twist.z(), w.left, 1e-9);
    EXPECT_NEAR((radius + track / 2) * twist.z(), w.right, 1e-9);
    EXPECT_NEAR(radius - track / 2, track * w.left / (w.right - w.left), 1e-6);
  }
}

TEST(Differential, ArcEqualsManySmallSteps) {
  const Differential drive{0.4};
  const Pose2 arc = exp(drive.forward({0.5, 0.9}));
  Pose2 steps;
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {  // Euler, the slow twin
    const double ds = 0.7 / n, turn = 1.0 / n;
    steps = {steps.x + ds * std::cos(steps.theta), steps.y + ds * std::sin(steps.theta),
             steps.theta + turn};
  }
  EXPECT_NEAR(arc.x, steps.x, 1e-5);
  EXPECT_NEAR(arc.y, steps.y, 1e-5);
  EXPECT_NEAR(arc.theta, steps.theta, 1e-9);
}

TEST(Differential, InverseUndoesForward) {
  RandomStream r(2);
  const Differential drive{0.37};
  for (int i = 0; i < 1000; ++i) {
    const Differential::Wheels w{r.uniform(-1, 1), r.uniform(-1, 1)};
    const auto back = drive.inverse(drive.forward(w));
    EXPECT_NEAR(back.left, w.left, 1e-14);
    EXPECT_NEAR(back.right, w.right, 1e-14);
  }
}

// Omnidirectional, A011.

TEST(Omnidirectional, BothWaysRound) {
  RandomStream r(3);
  const Omnidirectional drive{0.3};
  for (int i = 0; i < 1000; ++i) {
    const Vec3 twist = random_twist(r);
    expect_near(drive.forward(drive.inverse(twist)), twist);
    const Omnidirectional::Wheels w{r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1)};
    const auto back = drive.inverse(drive.forward(w));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(back[k], w[k], 1e-12);
  }
}

TEST(Omnidirectional, WheelsAgreeWithTheirGeometry) {
  // Slow twin: a wheel rolls the part of its own point's velocity that lies along it.
  RandomStream r(4);
  const double arm = 0.3;
  const Omnidirectional drive{arm};
  for (int i = 0; i < 100; ++i) {
    const Vec3 twist = random_twist(r);
    const auto wheels = drive.inverse(twist);
    for (int k = 0; k < 3; ++k) {
      const double heading = 2 * std::numbers::pi / 3 * k;
      const Vec2 along(std::cos(heading), std::sin(heading));
      const Vec2 point = arm * Vec2(along.y(), -along.x());
      const Vec2 velocity = twist.head<2>() + twist.z() * Vec2(-point.y(), point.x());
      EXPECT_NEAR(wheels[k], along.dot(velocity), 1e-12);
    }
  }
}

TEST(Omnidirectional, SidewaysUsesTheRootOfThree) {
  const auto wheels = Omnidirectional{0.3}.inverse({0, 1, 0});
  EXPECT_EQ(wheels[0], 0);
  EXPECT_NEAR(wheels[1], std::sqrt(3.0) / 2, 1e-15);
  EXPECT_NEAR(wheels[2], -std::sqrt(3.0) / 2, 1e-15);
}

}  // namespace
}  // namespace majak::motion
