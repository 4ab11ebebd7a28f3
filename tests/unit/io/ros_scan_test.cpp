// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "majak/core/random.hpp"

namespace majak::io {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
const float kNan = std::numeric_limits<float>::quiet_NaN();

ros::LaserScan message(std::size_t beams, double from_degrees, double step_degrees) {
  ros::LaserScan m;
  m.header = {0, 5 * kSecond, "laser"};
  m.angle_min = static_cast<float>(radians(from_degrees));
  m.angle_increment = static_cast<float>(radians(step_degrees));
  m.angle_max =
      static_cast<float>(radians(from_degrees + step_degrees * static_cast<double>(beams - 1)));
  m.range_min = 0.1F;
  m.range_max = 30;
  for (std::size_t i = 0; i < beams; ++i) m.ranges.push_back(1.0F + static_cast<float>(i));
  return m;
}

struct Read {
  std::optional<Scan> scan;
  Report report;
  std::int64_t noticed(const std::string& words) const {
    std::int64_t sum = 0;
    for (const auto& [what, entry] : report.entries())
      sum += what.find(words) != std::string::npos ? entry.count : 0;
    return sum;
  }
};
Read read(const ros::LaserScan& m, const Mounting& mounting = {},
          const RosScanOptions& options = {}) {
  Read r;
  r.scan = scan_of(m, mounting, options, 1, r.report);
  return r;
}

bool same_floats(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

TEST(RosScan, ComesBackToTheBit) {
  RandomStream random(3);
  for (const double step : {0.25, 0.5, 1.0, 0.3333, 0.1}) {
    for (const double start : {-kPi / 2, radians(-45), radians(-135), radians(-47.5), -kPi, 0.0}) {
      Scan scan;
      scan.time = 1'234'567'890'123'456'789;
      scan.start_angle = start;
      scan.angle_step = radians(step);
      scan.max_range = 81.83F;
      for (int i = 0; i < 50; ++i)
        scan.ranges.push_back(static_cast<float>(random.uniform(0.001, 81.8)));
      scan.ranges[3] = kNoReturn, scan.ranges[7] = kInvalidRange;
      scan.intensities.assign(50, 2.5F);
      const Read r = read(message_of(scan, "laser"));
      ASSERT_TRUE(r.scan);
      EXPECT_EQ(r.scan->time, scan.time);
      EXPECT_EQ(r.scan->start_angle, scan.start_angle) << start;
      EXPECT_EQ(r.scan->angle_step, scan.angle_step) << step;
      EXPECT_EQ(r.scan->max_range, scan.max_range);
      EXPECT_TRUE(same_floats(r.scan->ranges, scan.ranges));
      EXPECT_TRUE(same_floats(r.scan->intensities, scan.intensities));
      EXPECT_TRUE(r.report.empty());
    }
  }
}

TEST(RosScan, OddAnglesKeepTheirBits) {
  ros::LaserScan m = message(3, 0, 1);
  m.angle_increment = 0.006135923322290182F;  // 360 / 1024 degrees
  m.angle_max = m.angle_min + 2 * m.angle_increment;
  EXPECT_EQ(read(m).scan->angle_step, static_cast<double>(m.angle_increment));
}

TEST(RosScan, SaysOfEveryRangeWhatItMeans) {
  ros::LaserScan m = message(9, 0, 1);
  m.ranges = {0.0F, 0.05F, 0.1F, 29.9F, 30.0F, 81.0F, kInf, kNan, -kInf};
  const auto scan = read(m).scan;
  EXPECT_TRUE(same_floats(scan->ranges, {kInvalidRange, kInvalidRange, 0.1F, 29.9F, kNoReturn,
                                         kNoReturn, kNoReturn, kInvalidRange, kInvalidRange}));
  EXPECT_EQ(scan->max_range, 30);
  m.range_min = 40;  // beyond range_max: says nothing
  EXPECT_EQ(read(m).scan->ranges[1], 0.05F);
  m.range_min = kNan;
  EXPECT_EQ(read(m).scan->ranges[1], 0.05F);
  for (const float none : {0.0F, -1.0F, kNan, kInf}) {
    m.range_max = none;
    const Read r = read(m);
    EXPECT_EQ(r.scan->max_range, 100);
    EXPECT_EQ(r.scan->ranges[5], 81);
    EXPECT_EQ(r.noticed("without a range_max"), 1);
  }
  m.range_max = 82;
  const Read coded = read(m, {}, {.angle_step = {}, .code = 81.0F});
  EXPECT_EQ(coded.scan->ranges[5], kNoReturn);
  EXPECT_EQ(coded.scan->ranges[4], 30);
}

TEST(RosScan, BeamsRunCounterClockwiseWhateverTheLaserDoes) {
  // Where beam i of the message points, seen from the robot, has to be where its range is found.
  const auto expect_points = [](const ros::LaserScan& m, const Mounting& mounting) {
    const auto scan = read(m, mounting).scan;
    ASSERT_TRUE(scan);
    EXPECT_GT(scan->angle_step, 0);
    for (std::size_t i = 0; i < m.ranges.size(); ++i) {
      const double a = m.angle_min + static_cast<double>(i) * m.angle_increment;
      const double seen = mounting.upside_down ? -a : a;
      const auto at = std::find(scan->ranges.begin(), scan->ranges.end(), m.ranges[i]);
      ASSERT_NE(at, scan->ranges.end());
      const auto beam = static_cast<std::size_t>(at - scan->ranges.begin());
      EXPECT_NEAR(angle_diff(scan->angle(beam), seen), 0, 1e-6) << i;
      EXPECT_EQ(scan->intensities[beam], m.intensities[i]);
    }
  };
  const Mounting level{{0.1, 0.2, 0.3}, false, false}, down{{0.1, 0.2, 0.3}, true, false};
  for (const double step : {1.0, -1.0, 7.5}) {
    ros::LaserScan m = message(12, -20, step);
    m.intensities = m.ranges;
    expect_points(m, level);
    expect_points(m, down);
    EXPECT_EQ(read(m, down).scan->T_robot_laser, (Pose2{0.1, 0.2, 0.3}));
  }
}

TEST(RosScan, AnglesThatContradictThemselvesAreNoticed) {
  ros::LaserScan m = message(181, -90, 1);
  EXPECT_TRUE(read(m).report.empty());
  m.angle_max += static_cast<float>(radians(1));  // one too many: the frequent slip
  const Read slip = read(m);
  EXPECT_EQ(slip.noticed("disagrees"), 1);
  EXPECT_EQ(slip.noticed("--angle-step"), 1);
  EXPECT_EQ(slip.scan->angle_step, radians(1));
  m.angle_increment = 0;
  const Read none = read(m);
  EXPECT_EQ(none.noticed("without an angle_increment"), 1);
  EXPECT_NEAR(none.scan->angle_step, radians(181.0 / 180), 1e-6);
}

TEST(RosScan, AHalfCircleOfTooManyBeamsIsNoticedAndCorrected) {
  for (const auto& [beams, step] : {std::pair{180, 1.0}, std::pair{360, 0.5}}) {
    const auto n = static_cast<std::size_t>(beams);
    const ros::LaserScan spread = message(n, -90, 180.0 / (beams - 1));
    const Read r = read(spread);
    EXPECT_EQ(r.noticed("end at +90"), 1);
    EXPECT_EQ(r.noticed(beams == 180 ? "--angle-step 1 " : "--angle-step 0.5 "), 1);
    const Read corrected = read(spread, {}, {.angle_step = radians(step), .code = {}});
    EXPECT_TRUE(corrected.report.empty());
    EXPECT_EQ(corrected.scan->angle_step, radians(step));
    EXPECT_EQ(corrected.scan->start_angle, -kPi / 2);
    EXPECT_TRUE(read(message(n, -90, step)).report.empty());
    // A laser that turns the other way is corrected, too.
    const auto clockwise =
        read(message(n, 90, -180.0 / (beams - 1)), {}, {.angle_step = radians(step), .code = {}});
    EXPECT_NEAR(clockwise.scan->angle(n - 1), kPi / 2, 1e-6);
  }
  EXPECT_TRUE(read(message(361, -90, 0.5)).report.empty());
}

TEST(RosScan, WhatIsNoScanIsLeftOut) {
  ros::LaserScan m = message(3, 0, 1);
  m.angle_min = kNan;
  EXPECT_FALSE(read(m).scan);
  m = message(3, 0, 1);
  m.angle_increment = kInf, m.angle_max = kNan;
  EXPECT_FALSE(read(m).scan);
  m.ranges.clear();
  EXPECT_EQ(read(m).noticed("without beams"), 1);
  m = message(3, 0, 1);
  m.intensities = {1, 2};
  EXPECT_TRUE(read(m).scan->intensities.empty());
  EXPECT_EQ(read(m).noticed("intensities"), 1);
  Mounting tilted;
  tilted.tilted = true;
  EXPECT_EQ(read(message(3, 0, 1), tilted).noticed("tilted"), 1);
}

}  // namespace
}  // namespace majak::io
