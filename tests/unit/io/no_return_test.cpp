// SPDX-License-Identifier: Apache-2.0
// A laser in a rectangular hall. Beams that would go beyond the sensor's reach give its code.
#include "majak/io/no_return.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "majak/core/random.hpp"

namespace majak::io {
namespace {

struct Hall {
  double length = 60, width = 12;  // m, lower left corner in the origin
  double reach = 1e9;              // m
  double code = 0;                 // what is written beyond the reach
  double noise = 0.01;             // m
};

double distance_to_wall(const Hall& hall, const Pose2& pose, double angle) {
  const double c = std::cos(pose.theta + angle), s = std::sin(pose.theta + angle);
  const double along = c > 0 ? (hall.length - pose.x) / c : c < 0 ? -pose.x / c : 1e9;
  const double across = s > 0 ? (hall.width - pose.y) / s : s < 0 ? -pose.y / s : 1e9;
  return std::min(along, across);
}

Scan measure(const Hall& hall, const Pose2& pose, RandomStream& random, bool with_odometry) {
  Scan scan;
  scan.start_angle = -kPi / 2;
  scan.angle_step = radians(1);
  scan.max_range = 79.9f;
  for (int i = 0; i < 180; ++i) {
    const double r = distance_to_wall(hall, pose, scan.angle(static_cast<std::size_t>(i)));
    const double written = r >= hall.reach ? hall.code : r + hall.noise * random.normal();
    scan.ranges.push_back(static_cast<float>(std::round(written * 100) / 100));
  }
  if (with_odometry) scan.T_odom_robot = pose;
  return scan;
}

std::optional<float> find(const Hall& hall, const std::function<Pose2(int)>& path, int scans,
                          bool with_odometry = true) {
  SaturationFinder finder;
  RandomStream random(3);
  for (int i = 0; i < scans; ++i) finder.add(measure(hall, path(i), random, with_odometry));
  return finder.code();
}

Pose2 drive(int i) { return {10 + 0.08 * i, 6 + std::sin(0.02 * i), 0.3 * std::sin(0.03 * i)}; }
Pose2 turn(int i) { return {30, 6, 0.05 * i}; }
Pose2 stand(int) { return {30, 6, 0.2}; }

TEST(SaturationFinder, FindsTheCodeWhateverItIs) {
  for (const double code : {8.19, 16.38, 20.0, 25.0, 29.99}) {
    const auto found = find({.reach = code - 0.3, .code = code}, drive, 300);
    ASSERT_TRUE(found.has_value()) << code;
    EXPECT_NEAR(*found, code, 0.006);
  }
}

TEST(SaturationFinder, FindsItWithoutOdometry) {
  const auto found = find({.reach = 20, .code = 20}, drive, 600, false);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(*found, 20, 0.006);
}

TEST(SaturationFinder, FindsItWhenTheOdometryIsAllZero) {
  SaturationFinder finder;
  RandomStream random(3);
  for (int i = 0; i < 600; ++i) {
    Scan scan = measure({.reach = 20, .code = 20}, drive(i), random, false);
    scan.T_odom_robot = Pose2{};
    finder.add(scan);
  }
  EXPECT_TRUE(finder.code().has_value());
}

TEST(SaturationFinder, WallsAreNoCode) {
  for (const double noise : {0.0, 0.005, 0.01}) {
    EXPECT_FALSE(find({.noise = noise}, drive, 500).has_value()) << noise;
    EXPECT_FALSE(find({.noise = noise}, turn, 500).has_value()) << noise;
    EXPECT_FALSE(find(
        {.length = 20, .width = 2.5, .noise = noise},
        [](int i) {
          return Pose2{1 + 0.03 * i, 1.2, 0};
        },
        500))
        << noise;
    EXPECT_FALSE(find({.length = 30, .width = 30, .noise = noise}, drive, 200).has_value())
        << noise;
  }
}

TEST(SaturationFinder, AStandingRobotProvesNothing) {
  EXPECT_FALSE(find({.reach = 20, .code = 20}, stand, 2000).has_value());
  EXPECT_FALSE(find({.reach = 20, .code = 20, .noise = 0}, stand, 2000, false).has_value());
}

TEST(SaturationFinder, DrivingAlongAWallAtOneDistanceIsNoCode) {
  const auto path = [](int i) { return Pose2{5 + 0.1 * i, 2, 0}; };
  EXPECT_FALSE(find({.length = 200, .noise = 0}, path, 500).has_value());
}

TEST(SaturationFinder, AFewGlitchesAboveTheCodeDoNotHideIt) {
  SaturationFinder finder;
  RandomStream random(4);
  for (int i = 0; i < 300; ++i) {
    Scan scan = measure({.reach = 20, .code = 20}, drive(i), random, true);
    if (i % 40 == 0) scan.ranges[20] = 65.5f;
    finder.add(scan);
  }
  ASSERT_TRUE(finder.code().has_value());
  EXPECT_NEAR(*finder.code(), 20, 0.006);
}

TEST(SaturationFinder, OddValuesDoNoHarm) {
  SaturationFinder finder;
  for (int i = 0; i < 100; ++i) {
    Scan scan;
    scan.max_range = 1e30f;
    scan.ranges = {kInvalidRange, kNoReturn, -1.0f,
                   0.0f,          1e20f,     99.999f - static_cast<float>(i) * 0.1f,
                   0.001f};
    scan.T_odom_robot = i % 2 ? Pose2{1e300, 0, 0} : Pose2{};
    finder.add(scan);
  }
  EXPECT_FALSE(finder.code().has_value());
}

}  // namespace
}  // namespace majak::io
