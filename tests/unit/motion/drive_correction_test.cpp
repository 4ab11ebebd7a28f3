// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/drive_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <type_traits>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

const DriveCorrection kWheels{
    .scale = 1.03, .turn_scale = 0.96, .turn_per_metre = 0.02, .way_per_turn = -0.01};

void expect_near(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(angle_diff(a.theta, b.theta), 0, tolerance);
}

std::vector<Vec3> some_twists(int n) {
  RandomStream random(3);
  std::vector<Vec3> out;
  for (int i = 0; i < n; ++i)
    out.emplace_back(random.uniform(-0.1, 0.2), random.uniform(-0.02, 0.02),
                     random.uniform(-0.3, 0.3));
  return out;
}

// The poses of the odometry after each twist, at 10 Hz; the first is not the origin.
std::vector<Odometry> driven(const std::vector<Vec3>& twists) {
  std::vector<Odometry> out{{kSecond, {3, -2, 1}, 0.5, 0.2}};
  for (const Vec3& twist : twists)
    out.push_back({out.back().time + kSecond / 10, out.back().T_odom_robot * exp(twist), 0.5, 0.2});
  return out;
}

std::vector<Odometry> mended(const std::vector<Odometry>& raw, const DriveCorrection& correction) {
  CorrectedDrive drive(correction);
  std::vector<Odometry> out;
  for (const Odometry& odometry : raw) {
    Event event = odometry;
    drive.apply(event);
    out.push_back(std::get<Odometry>(event));
  }
  return out;
}

Scan some_scan(const Pose2& T_odom_robot) {
  Scan scan;
  scan.time = 7;
  scan.ranges = {1.5F, 2.5F};
  scan.T_robot_laser = {0.1, 0.2, 0.3};
  scan.T_odom_robot = T_odom_robot;
  return scan;
}

TEST(DriveCorrection, TheDefaultsChangeNoBit) {
  for (const Odometry& raw : driven(some_twists(50))) {
    CorrectedDrive drive({});
    Event odometry = raw, wheels = WheelMotion{raw.time, 0.3, 0.1},
          scan = some_scan(raw.T_odom_robot);
    for (Event* event : {&odometry, &wheels, &scan}) drive.apply(*event);
    const auto& o = std::get<Odometry>(odometry);
    EXPECT_EQ(o.time, raw.time);
    EXPECT_EQ(o.T_odom_robot, raw.T_odom_robot);
    EXPECT_EQ(o.speed, raw.speed);
    EXPECT_EQ(o.turn_rate, raw.turn_rate);
    const auto& w = std::get<WheelMotion>(wheels);
    EXPECT_EQ(w.time, raw.time);
    EXPECT_EQ(w.speed, 0.3);
    EXPECT_EQ(w.steering, 0.1);
    const auto& s = std::get<Scan>(scan);
    EXPECT_EQ(s.time, 7);
    EXPECT_EQ(s.T_odom_robot, raw.T_odom_robot);
    EXPECT_EQ(s.T_robot_laser, (Pose2{0.1, 0.2, 0.3}));
    EXPECT_EQ(s.ranges, (std::vector{1.5F, 2.5F}));
  }
}

TEST(DriveCorrection, OfATwistIsTheFormula) {
  for (const Vec3& t : some_twists(50)) {
    const Vec3 c = corrected(kWheels, t);
    EXPECT_DOUBLE_EQ(c.x(), 1.03 * t.x() - 0.01 * t.z());
    EXPECT_DOUBLE_EQ(c.y(), 1.03 * t.y());
    EXPECT_DOUBLE_EQ(c.z(), 0.96 * t.z() + 0.02 * t.x());
    EXPECT_EQ(corrected(DriveCorrection{}, t), t);
  }
}

// The turn v tan(s) / wheelbase is turn_scale times that of the mended steering.
TEST(DriveCorrection, OfSpeedAndSteeringIsThatOfTheirTwist) {
  const DriveCorrection c{.scale = 1.05, .turn_scale = 0.9, .steering_offset = 0.03};
  const WheelMotion raw{5, 2, -0.2}, m = corrected(c, raw);
  EXPECT_EQ(m.time, 5);
  EXPECT_DOUBLE_EQ(m.speed, 2.1);
  EXPECT_NEAR(m.speed * std::tan(m.steering), 0.9 * 2 * std::tan(-0.2 + 0.03), 1e-14);
}

TEST(CorrectedDrive, MovesThePathAsTheCorrectedTwistsDo) {
  const auto twists = some_twists(200);
  const auto raw = driven(twists), out = mended(raw, kWheels);
  Pose2 expected = raw.front().T_odom_robot;
  EXPECT_EQ(out[0].T_odom_robot, expected);
  for (std::size_t i = 0; i < twists.size(); ++i) {
    expected = expected * exp(corrected(kWheels, twists[i]));
    expect_near(out[i + 1].T_odom_robot, expected, 1e-11);
    EXPECT_EQ(out[i + 1].time, raw[i + 1].time);
    EXPECT_DOUBLE_EQ(*out[i + 1].speed, 1.03 * 0.5);
    EXPECT_DOUBLE_EQ(*out[i + 1].turn_rate, 0.96 * 0.2 + 0.02 * 0.5);
  }
}

TEST(CorrectedDrive, AScansOwnOdometryIsAPathOfItsOwn) {
  const auto twists = some_twists(50);
  const auto raw = driven(twists), expected = mended(raw, kWheels);
  CorrectedDrive drive(kWheels);
  for (std::size_t i = 0; i < raw.size(); ++i) {
    Event scan = some_scan(raw[i].T_odom_robot), other = Odometry{7, {0, 0, 0.1}, {}, {}};
    std::get<Scan>(scan).time = raw[i].time;
    drive.apply(other);
    EXPECT_FALSE(std::get<Odometry>(other).speed || std::get<Odometry>(other).turn_rate);
    drive.apply(scan);
    EXPECT_EQ(std::get<Scan>(scan).T_odom_robot, expected[i].T_odom_robot);
  }
}

TEST(CorrectedDrive, TheLagMovesTheWheelsStampsOnly) {
  CorrectedDrive drive({.lag = 0.25});
  Event odometry = Odometry{kSecond, {1, 2, 3}, {}, {}}, wheels = WheelMotion{kSecond, 1, 0.1},
        scan = some_scan({1, 2, 3}), gps = GpsFix{kSecond, 1, 2, 3};
  for (Event* event : {&odometry, &wheels, &scan, &gps}) drive.apply(*event);
  EXPECT_EQ(time_of(odometry), kSecond * 3 / 4);
  EXPECT_EQ(time_of(wheels), kSecond * 3 / 4);
  EXPECT_EQ(time_of(scan), 7);
  EXPECT_EQ(time_of(gps), kSecond);
  EXPECT_FALSE(std::get<Scan>(scan).T_odom_robot);  // cannot be moved
  EXPECT_EQ(std::get<Odometry>(odometry).T_odom_robot, (Pose2{1, 2, 3}));
}

TEST(CorrectedDrive, TheMountingIsOfTheFrontLaserOnly) {
  CorrectedDrive drive({.mounting = true, .laser_x = 1, .laser_y = 2, .laser_theta = 0.5});
  Event front = some_scan({}), rear = some_scan({});
  std::get<Scan>(rear).laser = 1;
  drive.apply(front), drive.apply(rear);
  EXPECT_EQ(std::get<Scan>(front).T_robot_laser, (Pose2{1, 2, 0.5}));
  EXPECT_EQ(std::get<Scan>(rear).T_robot_laser, (Pose2{0.1, 0.2, 0.3}));
}

TEST(CorrectedDrive, RecordsThatCountBackingAsAWayAheadAreTurnedRound) {
  std::vector<Odometry> raw{{0, {}, 1.0, 0.0},
                            {kSecond, {1, 0, 0}, 1.0, 0.0},
                            {2 * kSecond, {2, 0, 0}, -1.0, 0.0},
                            {3 * kSecond, {1.5, 0, 0}, -1.0, 0.0},  // this one states it rightly
                            {4 * kSecond, {2.5, 0, 0}, 1.0, 0.0}};
  const auto out = mended(raw, {.reversed = true}), left = mended(raw, {.lag = 0.1});
  const double x[] = {0, 1, 0, -0.5, 0.5};
  for (std::size_t i = 0; i < raw.size(); ++i) {
    EXPECT_NEAR(out[i].T_odom_robot.x, x[i], 1e-15);
    EXPECT_NEAR(left[i].T_odom_robot.x, raw[i].T_odom_robot.x, 1e-15);
  }
  EXPECT_EQ(turned_round({1, 2, 3}, -1), (Pose2{-1, -2, 3}));
  EXPECT_EQ(turned_round({1, 2, 3}, 0), (Pose2{1, 2, 3}));
  EXPECT_EQ(turned_round({-1, 2, 3}, -1), (Pose2{-1, 2, 3}));
}

// The counters begin anew: the leap stays as large as it is, the steps around it are mended.
TEST(CorrectedDrive, ALeapBreaksNothing) {
  const auto twists = some_twists(40);
  auto raw = driven(twists);
  const Pose2 leap{500, -300, 2};
  for (std::size_t i = 20; i < raw.size(); ++i) raw[i].T_odom_robot = leap * raw[i].T_odom_robot;
  const auto out = mended(raw, kWheels);
  for (std::size_t i = 1; i < raw.size(); ++i) {
    const Pose2 step = between(out[i - 1].T_odom_robot, out[i].T_odom_robot);
    expect_near(step,
                i == 20 ? between(raw[19].T_odom_robot, raw[20].T_odom_robot)
                        : exp(corrected(kWheels, twists[i - 1])),
                1e-11);
  }
}

TEST(CorrectedDrive, WhatLeaps) {
  EXPECT_FALSE(leaps({1.9, 0, 0}, 0));
  EXPECT_TRUE(leaps({1.5, 1.5, 0}, 0));
  EXPECT_FALSE(leaps({1.5, 1.5, 0}, 0.01));
  EXPECT_TRUE(leaps({0, 0, -1.6}, 0));
  EXPECT_FALSE(leaps({0, 0, -1.6}, 0.02));
}

TEST(DriveCorrectionOptions, WhatIsReadIsWhatWasWritten) {
  const DriveCorrection written{.lag = 0.1,
                                .scale = 1.1,
                                .turn_scale = 0.9,
                                .turn_per_metre = 0.2,
                                .way_per_turn = 0.3,
                                .steering_offset = 0.4,
                                .wheelbase = 2.5,
                                .reversed = true,
                                .mounting = true,
                                .laser_x = 5,
                                .laser_y = 6,
                                .laser_theta = 0.7};
  DriveCorrection source = written, read;
  OptionFields from, to;
  describe(from, source), describe(to, read);
  ASSERT_EQ(from.list.size(), 12U);
  std::set<std::string> names;
  for (std::size_t i = 0; i < from.list.size(); ++i) {
    const OptionField& f = from.list[i];
    EXPECT_TRUE(names.insert(f.name).second && f.name.starts_with("odometry.")) << f.name;
    std::visit(
        [&](auto* v) {
          const auto wanted = *std::get<std::decay_t<decltype(v)>>(f.value);
          EXPECT_NE(*v, wanted) << f.name;  // each has its own place
          EXPECT_TRUE(f.info.min <= *v && *v <= f.info.max) << f.name;
          *v = wanted;
        },
        to.list[i].value);
  }
  EXPECT_EQ(read, written);
}

}  // namespace
}  // namespace majak::motion
