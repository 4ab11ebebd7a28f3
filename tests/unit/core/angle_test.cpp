// SPDX-License-Identifier: Apache-2.0
#include "majak/core/angle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "majak/core/random.hpp"

namespace majak {
namespace {

TEST(Angle, WrapLandsInItsIntervalOnTheSameDirection) {
  RandomStream r(1);
  for (int i = 0; i < 2000; ++i) {
    const double angle = i % 2 == 0 ? r.uniform(-4, 4) : r.uniform(-1e4, 1e4);
    const double wrapped = wrap_angle(angle);
    EXPECT_GT(wrapped, -kPi);
    EXPECT_LE(wrapped, kPi);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-11);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-11);
    EXPECT_EQ(wrap_angle(wrapped), wrapped);
  }
}

TEST(Angle, HalfATurnIsPlusPi) {
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
  EXPECT_EQ(wrap_angle(3 * kPi), kPi);
  EXPECT_EQ(wrap_angle(-3 * kPi), kPi);
  const double beyond = std::nextafter(kPi, 4.0);
  EXPECT_LT(wrap_angle(beyond), -3);
  EXPECT_GT(wrap_angle(beyond), -kPi);
}

TEST(Angle, SmallAnglesAreNotTouched) {
  for (const double angle : {0.0, 1e-12, -1e-12, 1e-300, 3.0, -3.0}) {
    EXPECT_EQ(wrap_angle(angle), angle);
    EXPECT_EQ(angle_diff(angle, 0), angle);
  }
  EXPECT_FALSE(std::signbit(wrap_angle(0.0)));
}

TEST(Angle, DifferenceGoesTheShortWayAcrossTheSeam) {
  EXPECT_NEAR(angle_diff(radians(-179), radians(179)), radians(2), 1e-14);
  EXPECT_NEAR(angle_diff(radians(179), radians(-179)), radians(-2), 1e-14);
  EXPECT_EQ(angle_diff(kPi, -kPi), 0.0);
  EXPECT_NEAR(angle_diff(-kPi + 1e-12, kPi), 1e-12, 1e-15);
  RandomStream r(2);
  for (int i = 0; i < 500; ++i) {
    const double a = r.uniform(-kPi, kPi), b = r.uniform(-kPi, kPi), turns = 2 * kPi * i;
    const double d = angle_diff(a, b);
    EXPECT_NEAR(angle_diff(b + d, a), 0, 1e-14);
    EXPECT_NEAR(angle_diff(b, a), -d, 1e-14);
    EXPECT_NEAR(angle_diff(angle_diff(a + turns, b), d), 0, 1e-10);
  }
}

TEST(Angle, WhatIsNoAngleStaysNone) {
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::infinity())));
}

TEST(Angle, DegreesAndBack) {
  EXPECT_DOUBLE_EQ(radians(180), kPi);
  EXPECT_DOUBLE_EQ(degrees(kPi / 4), 45);
  EXPECT_DOUBLE_EQ(degrees(radians(0.36)), 0.36);
}

}  // namespace
}  // namespace majak
