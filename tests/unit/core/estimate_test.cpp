// SPDX-License-Identifier: Apache-2.0
#include "majak/core/estimate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace majak {
namespace {

Mat3 turned(const Vec3& variances, double angle) {
  Mat3 turn = Mat3::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(angle).toRotationMatrix();
  return turn * variances.asDiagonal() * turn.transpose();
}

TEST(LeastKnown, IsTheLargerAxisHoweverItIsTurned) {
  for (const double angle : {-2.0, -0.7, 0.0, 0.3, 1.5, 3.0}) {
    const LeastKnown least = least_known(turned({9, 4, 100}, angle));
    EXPECT_NEAR(least.sigma, 3, 1e-12);
    const Vec2 axis(std::cos(angle), std::sin(angle));
    EXPECT_NEAR(std::abs(least.direction.dot(axis)), 1, 1e-12) << angle;
    EXPECT_NEAR(least_known(turned({4, 9, 100}, angle)).direction.dot(axis), 0, 1e-12) << angle;
  }
}

TEST(LeastKnown, OfNothingAndOfNoNumberIsNone) {
  EXPECT_EQ(least_known(Mat3::Zero()).sigma, 0);
  Mat3 covariance = Mat3::Identity();
  covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(least_known(covariance).sigma, 0);
}

TEST(Degrade, TellsTheWeakDirection) {
  Estimate e;
  e.covariance = turned({9, 4, 1}, 0.5);
  degrade(e);
  EXPECT_EQ(e.health, Health::degraded);
  EXPECT_EQ(e.weak_direction, least_known(e.covariance).direction);
}

}  // namespace
}  // namespace majak
