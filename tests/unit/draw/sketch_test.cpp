// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/sketch.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace majak::draw {
namespace {

TEST(Sketch, ArcsBeginAndEndWhereTheyShould) {
  const auto points = arc({1, 2}, 3, 0, kPi / 2);
  EXPECT_NEAR(points.front().x, 4, 1e-12);
  EXPECT_NEAR(points.back().y, 5, 1e-12);
  for (const Point& p : points) EXPECT_NEAR(std::hypot(p.x - 1, p.y - 2), 3, 1e-12);
}

TEST(Sketch, AWheelsWayIsItsArc) {
  // A point 0.2 m to the left on a circle of 1 m to the left keeps 0.8 m from the centre.
  for (const Point& p : way_of({0, 0.2}, {}, {2, 0, 2}))
    EXPECT_NEAR(std::hypot(p.x, p.y - 1), 0.8, 1e-12);
}

TEST(Sketch, LooksUp) {
  const Vec2 ahead = kLooksUp * Vec2(1, 0);
  EXPECT_NEAR(ahead.x(), 0, 1e-15);
  EXPECT_NEAR(ahead.y(), 1, 1e-15);
}

TEST(BentEllipse, IsPlainWhereTheHeadingIsSure) {
  const Mat3 P = Vec3(0.04, 0.01, 0).asDiagonal();
  for (const Point& p : bent_ellipse({1, 1, 0}, P, 1))
    EXPECT_NEAR(std::pow((p.x - 1) / 0.2, 2) + std::pow((p.y - 1) / 0.1, 2), 1, 1e-9);
}

TEST(BentEllipse, ItsPointsLieOnTheBorder) {
  Mat3 P;
  P << 0.02, 0.01, 0.002, 0.01, 0.3, 0.06, 0.002, 0.06, 0.02;
  const Pose2 pose{3, -1, 0.7};
  const Eigen::Matrix2d information = Eigen::Matrix2d(P.topLeftCorner<2, 2>()).inverse();
  const Eigen::RowVector2d slope = P.block<1, 2>(2, 0) * information;
  for (const Point& p : bent_ellipse(pose, P, 4)) {
    // The error of place whose expected heading leads there: by fixed-point iteration.
    const Vec2 q = pose.inverse() * Vec2(p.x, p.y);
    Vec2 e = q;
    for (int i = 0; i < 100; ++i) e = log({q.x(), q.y(), slope * e}).head<2>();
    EXPECT_NEAR(e.dot(information * e), 4, 1e-6);
  }
}

TEST(BentEllipse, OfNoErrorIsNothing) { EXPECT_TRUE(bent_ellipse({}, Mat3::Zero()).empty()); }

}  // namespace
}  // namespace majak::draw
