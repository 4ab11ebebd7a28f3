// SPDX-License-Identifier: Apache-2.0
// Events and their times.
#include "majak/core/event.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "majak/core/random.hpp"
#include "majak/core/time.hpp"

namespace majak {
namespace {

TEST(Time, SecondsAndBack) {
  EXPECT_EQ(from_seconds(0), 0);
  EXPECT_EQ(from_seconds(1), kSecond);
  EXPECT_EQ(from_seconds(-1.5), -3 * kSecond / 2);
  EXPECT_EQ(from_seconds(0.0133), 13'300'000);
  EXPECT_EQ(from_seconds(1e-10), 0);  // rounded to the nearest,
  EXPECT_EQ(from_seconds(6e-10), 1);  // not cut
  EXPECT_EQ(from_seconds(-6e-10), -1);
  EXPECT_DOUBLE_EQ(to_seconds(1'250'000'000), 1.25);
}

TEST(Time, MicrosecondsSurviveTheWayThroughDouble) {
  RandomStream r(1);
  for (int i = 0; i < 1000; ++i) {
    const Time time = 1000 * static_cast<Time>(r.below(2'000'000'000'000'000));  // until 2033
    EXPECT_LT(std::abs(from_seconds(to_seconds(time)) - time), 500) << time;
  }
}

TEST(Scan, AngleOfABeam) {
  Scan scan;
  scan.start_angle = radians(-90);
  scan.angle_step = radians(0.5);
  EXPECT_DOUBLE_EQ(scan.angle(0), -kPi / 2);
  EXPECT_NEAR(scan.angle(180), 0, 1e-15);
  EXPECT_NEAR(scan.angle(360), kPi / 2, 1e-15);
}

TEST(Scan, RangesThatAreNoneAreNotFinite) {
  EXPECT_FALSE(std::isfinite(kNoReturn));
  EXPECT_GT(kNoReturn, 1e30F);
  EXPECT_TRUE(std::isnan(kInvalidRange));
}

TEST(Event, TimeOfWhateverItIs) {
  Scan scan;
  scan.time = 1;
  EXPECT_EQ(time_of(Event(scan)), 1);
  EXPECT_EQ(time_of(Event(Odometry{2, {}, {}, {}})), 2);
  EXPECT_EQ(time_of(Event(WheelMotion{3, 0, 0})), 3);
  EXPECT_EQ(time_of(Event(GpsFix{4, 0, 0})), 4);
  EXPECT_EQ(time_of(Event(Truth{-5, {}})), -5);
}

}  // namespace
}  // namespace majak
