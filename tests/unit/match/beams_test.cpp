// SPDX-License-Identifier: Apache-2.0
#include "majak/match/beams.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace majak::match {
namespace {

Scan scan_of(std::vector<float> ranges) {
  Scan scan;
  scan.start_angle = -kPi / 2;
  scan.angle_step = kPi / 2;
  scan.max_range = 30;
  scan.T_robot_laser = {0.5, 0.1, 0};
  scan.ranges = std::move(ranges);
  return scan;
}

TEST(Beams, EndWhereTheyMetSomething) {
  const Beams b = beams(scan_of({1, 2, 3}));
  ASSERT_EQ(b.returns, 3U);
  EXPECT_NEAR(b.x[0], 0.5, 1e-6);
  EXPECT_NEAR(b.y[0], -0.9, 1e-6);
  EXPECT_NEAR(b.x[1], 2.5, 1e-6);
  EXPECT_NEAR(b.y[1], 0.1, 1e-6);
  EXPECT_NEAR(b.y[2], 3.1, 1e-6);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(b.laser.x() + b.range[i] * b.cos[i], b.x[i], 1e-6);
    EXPECT_NEAR(b.laser.y() + b.range[i] * b.sin[i], b.y[i], 1e-6);
  }
}

TEST(Beams, ReturnsComeFirstAndInvalidOnesAreLeftOut) {
  const Beams b = beams(scan_of({kNoReturn, 2, kInvalidRange, 0.01F, 40}));
  EXPECT_EQ(b.returns, 1U);
  ASSERT_EQ(b.size(), 3U);
  EXPECT_EQ(b.range[0], 2.0F);
  EXPECT_TRUE(std::isinf(b.range[1]));
  EXPECT_TRUE(std::isinf(b.range[2]));
  EXPECT_EQ(b.max_range, 30);
}

TEST(Beams, FewerAreSpreadEvenly) {
  Scan scan = scan_of({});
  scan.angle_step = radians(1);
  for (int i = 0; i < 181; ++i) scan.ranges.push_back(1.0F + 0.01F * static_cast<float>(i));
  const Beams b = beams(scan, {.most = 20});
  ASSERT_EQ(b.returns, 20U);
  for (std::size_t i = 1; i < 20; ++i) EXPECT_NEAR(b.range[i] - b.range[i - 1], 0.09, 0.0101);
  EXPECT_LT(b.range.front(), 1.05F);
  EXPECT_GT(b.range.back(), 2.75F);
  EXPECT_EQ(beams(scan, {.most = 0}).size(), 181U);
}

TEST(Beams, OfAScanWithoutAny) {
  EXPECT_EQ(beams(scan_of({})).size(), 0U);
  EXPECT_EQ(beams(scan_of({kInvalidRange})).size(), 0U);
}

}  // namespace
}  // namespace majak::match
