// SPDX-License-Identifier: Apache-2.0
#include "majak/io/log_summary.hpp"

#include <gtest/gtest.h>

namespace majak::io {
namespace {

TEST(StampSummary, CountsGapsRepeatsAndStepsBack) {
  StampSummary s;
  for (const double t : {10.0, 10.5, 10.5, 10.3, 12.0, 12.9, 16.0}) s.add(from_seconds(t));
  EXPECT_EQ(s.count, 7);
  EXPECT_EQ(s.repeated, 1);
  EXPECT_EQ(s.backwards, 1);
  EXPECT_EQ(s.worst_backwards, from_seconds(0.2));
  EXPECT_EQ(s.gaps, 2);
  EXPECT_EQ(s.longest_gap, from_seconds(3.1));
  EXPECT_EQ(s.longest_gap_after, from_seconds(12.9));
  EXPECT_DOUBLE_EQ(s.rate(), 1.0);
}

TEST(StampSummary, OneRecordHasNoRate) {
  StampSummary s;
  s.add(5);
  EXPECT_EQ(s.rate(), 0.0);
  EXPECT_EQ(s.duration(), 0);
}

TEST(LaserSummary, SharesAndField) {
  LaserSummary l;
  Scan scan;
  scan.start_angle = -kPi / 2;
  scan.angle_step = radians(1);
  scan.ranges.assign(181, 2.0f);
  scan.ranges[3] = kNoReturn;
  scan.ranges[4] = kInvalidRange;
  scan.ranges[5] = 7.5f;
  l.add(scan);
  scan.ranges.resize(90);
  l.add(scan);
  EXPECT_EQ(l.beams, 271);
  EXPECT_EQ(l.no_returns, 2);
  EXPECT_EQ(l.invalid, 2);
  EXPECT_EQ(l.longest_return, 7.5f);
  EXPECT_EQ(l.fewest_beams, 90u);
  EXPECT_NEAR(degrees(l.field_of_view()), 180, 1e-9);
}

TEST(LogSummary, PathOfTheOdometryRecordsOrElseOfTheScans) {
  LogSummary s;
  Scan scan;
  scan.ranges = {1.0f};
  scan.T_odom_robot = Pose2{0, 0, 3.0};
  s.add(scan);
  scan.T_odom_robot = Pose2{3, 4, -3.0};
  s.add(scan);
  EXPECT_DOUBLE_EQ(s.odometry_path.length, 5);
  EXPECT_NEAR(s.odometry_path.turned, 2 * kPi - 6, 1e-12) << "the short way round";
  s.add(Odometry{.time = 1, .T_odom_robot = {0, 0, 0}, .speed = {}, .turn_rate = {}});
  s.add(Odometry{.time = 2, .T_odom_robot = {0, 2, 0}, .speed = 1.0, .turn_rate = {}});
  EXPECT_DOUBLE_EQ(s.odometry_path.length, 2);
  EXPECT_EQ(s.odometry_with_speed, 1);
  EXPECT_EQ(s.events(), 4);
  EXPECT_EQ(s.latest(), 2);
}

TEST(LogSummary, WheelsFixesAndTruth) {
  LogSummary s;
  s.add(WheelMotion{.time = 0, .speed = 2, .steering = 0});
  s.add(WheelMotion{.time = kSecond, .speed = -1, .steering = 0});
  s.add(WheelMotion{.time = 2 * kSecond, .speed = 0, .steering = 0});
  EXPECT_DOUBLE_EQ(s.wheel_path, 3);
  s.add(GpsFix{.time = 0, .east = 5, .north = -1});
  s.add(GpsFix{.time = 1, .east = 8, .north = -3});
  EXPECT_EQ(s.gps_east[1] - s.gps_east[0], 3);
  EXPECT_EQ(s.gps_north[1] - s.gps_north[0], 2);
  s.add(Truth{.time = 7 * kSecond, .T_world_robot = {}});
  EXPECT_EQ(s.truth.count, 1);
  EXPECT_EQ(s.latest(), 7 * kSecond);
  EXPECT_EQ(s.earliest(), 0);
}

}  // namespace
}  // namespace majak::io
