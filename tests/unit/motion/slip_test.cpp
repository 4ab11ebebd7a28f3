// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/slip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

/// For half a second from `at` on the robot moves so much more than its wheels say.
struct Disturbance {
  double at;  ///< s
  Vec3 extra;
};

struct SlipLog {
  std::vector<LaserPose> laser;
  std::vector<WheelSample> wheels;
};

// Wheels at 20 Hz, laser at 10 Hz, with the usual noise. Around a disturbance the wheels roll as
// told: 0.6 m/s ahead in a slip, not at all in a push.
SlipLog drive(std::uint64_t seed, double seconds,
              const std::vector<Disturbance>& disturbances = {}) {
  const StepNoise usual;
  RandomStream random(seed);
  SlipLog log;
  Pose2 truth;
  const double dt = 0.05;
  for (int i = 0; i * dt < seconds; ++i) {
    const double t = i * dt;
    if (i % 2 == 0)
      log.laser.push_back(
          {from_seconds(t), truth * exp(Vec3(usual.laser_translation * random.normal(),
                                             usual.laser_translation * random.normal(),
                                             usual.laser_rotation * random.normal()))});
    Vec3 counted = dt * Vec3(0.4 + 0.2 * std::sin(0.3 * t), 0, 0.3 * std::sin(0.2 * t));
    Vec3 moved = Vec3::Zero();
    for (const Disturbance& d : disturbances) {
      if (t < d.at - 1e-9 || t > d.at + 0.5 - 1e-9) continue;
      counted = d.extra.x() < 0 ? Vec3(0.6 * dt, 0, 0) : Vec3(0, 0, 0);
      moved = d.extra * dt / 0.5;
    }
    truth = truth * exp(counted + moved);
    const double way = std::abs(counted.x()), turn = std::abs(counted.z());
    counted.x() += usual.ahead * std::sqrt(way) * random.normal();
    counted.z() +=
        std::hypot(usual.turn_of_way * std::sqrt(way), usual.turn_of_turn * std::sqrt(turn)) *
        random.normal();
    log.wheels.push_back({from_seconds(t + dt), counted, 0, false});
  }
  return log;
}

std::vector<SlipEvent> found(const SlipLog& log) {
  return find_slips(log.laser, log.wheels, {}, {0.1, 0, 0}, 0);
}

// Wheels roll 0.3 m and the robot 0.1 m; a push; a turn.
const std::vector<Disturbance> kThree{{20, {-0.2, 0, 0}}, {40, {0.1, 0.173, 0}}, {60, {0, 0, 0.2}}};

TEST(FindSlips, ASlipAPushAndATurnAreFoundAsTheyWere) {
  const auto events = found(drive(1, 80, kThree));
  ASSERT_EQ(events.size(), 3U);
  const SlipKind kinds[] = {SlipKind::slip, SlipKind::push, SlipKind::push};
  for (std::size_t i = 0; i < 3; ++i) {
    const SlipEvent& e = events[i];
    const Vec3& extra = kThree[i].extra;
    EXPECT_EQ(e.kind, kinds[i]) << i;
    EXPECT_NEAR(e.way, extra.head<2>().norm(), 0.03) << i;
    EXPECT_NEAR(e.turn, extra.z(), 0.03) << i;
    // To a step of 0.3 s, and one quiet step.
    EXPECT_NEAR(to_seconds(e.begin), kThree[i].at, 0.31) << i;
    EXPECT_NEAR(to_seconds(e.end), kThree[i].at + 0.5, 0.31) << i;
  }
}

// None seen in 100 minutes, 20 000 steps; the gate alone would let 1 step in 100 000 through.
TEST(FindSlips, ACleanRunHasNone) {
  std::size_t alarms = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) alarms += found(drive(100 + seed, 300)).size();
  EXPECT_EQ(alarms, 0U);
}

TEST(FindSlips, PrecisionAndRecall) {
  std::size_t hits = 0, told = 0, wanted = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomStream random(seed, 1);
    std::vector<Disturbance> all;
    for (double t = 10; t < 110; t += 10) {
      const double size = random.uniform(0.06, 0.3);
      const auto kind = all.size() % 3;
      all.push_back({t + random.uniform(0, 5), kind == 0   ? Vec3(-size, 0, 0)
                                               : kind == 1 ? Vec3(0, size, 0)
                                                           : Vec3(0, 0, size)});
    }
    const auto events = found(drive(200 + seed, 120, all));
    wanted += all.size(), told += events.size();
    for (const Disturbance& d : all)
      hits += std::any_of(events.begin(), events.end(), [&](const SlipEvent& e) {
        return to_seconds(e.begin) < d.at + 0.5 && to_seconds(e.end) > d.at;
      });
  }
  EXPECT_EQ(wanted, 200U);
  EXPECT_EQ(hits, wanted);
  EXPECT_EQ(told, hits);
}

TEST(FindSlips, AJumpOfTheCountersIsOne) {
  SlipLog log = drive(2, 60);
  log.wheels[600].twist.setZero(), log.wheels[600].jump = true;
  const auto events = found(log);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, SlipKind::jump);
  EXPECT_NEAR(to_seconds(events[0].begin), 30, 0.31);
}

// One pose that came late errs to one side and back: nothing is left of that.
TEST(FindSlips, OneWrongPoseIsNone) {
  SlipLog log = drive(3, 60);
  log.laser[300].T_map_robot = log.laser[300].T_map_robot * Pose2{0.1, 0, 0};
  EXPECT_TRUE(found(log).empty());
}

// A whole log.

// What a mapping of the log would leave.
Site site_of(const SlipLog& log) {
  Site site;
  for (const LaserPose& pose : log.laser) {
    PosedScan s;
    s.scan.time = pose.time;
    s.estimate.T_map_robot = pose.T_map_robot;
    s.estimate.health = Health::ok;
    s.match_score = 1;
    site.scans.push_back(s);
  }
  return site;
}

// The same with the odometry at each scan, as the mapping leaves it.
Site site_with_odometry(const SlipLog& log) {
  Site site = site_of(log);
  Pose2 pose;
  for (std::size_t i = 0; i < log.wheels.size(); ++i) {
    if (i % 2 == 0) site.scans[i / 2].T_odom_robot = pose;
    pose = pose * exp(log.wheels[i].twist);
  }
  return site;
}

// The odometry as a stream, or in the scans' own records.
DriveLog drive_log(const SlipLog& log, bool in_scans) {
  DriveLog out;
  Pose2 pose;
  for (const WheelSample& s : log.wheels) {
    if (in_scans && s.time % (kSecond / 10) == kSecond / 20) {
      Scan scan;
      scan.time = s.time - kSecond / 20, scan.T_odom_robot = pose;
      out.add(scan);
    }
    pose = pose * exp(s.twist);
    if (!in_scans) out.add(Odometry{s.time, pose, {}, {}});
  }
  return out;
}

TEST(DriveLog, KeepsWhatTellsOfTheWheels) {
  DriveLog log;
  Scan front, rear, bare;
  front.T_odom_robot = Pose2{1, 2, 3}, rear.laser = 1, front.time = 4;
  for (const Event& event : {Event(Odometry{3, {5, 0, 0}, -0.5, {}}), Event(front), Event(rear),
                             Event(WheelMotion{6, 1, 0.1}), Event(GpsFix{})})
    log.add(event);
  ASSERT_TRUE(log.stream.size() == 1 && log.wheels.size() == 1 && log.records.size() == 1);
  EXPECT_EQ(log.records[0].time, 4);
  EXPECT_EQ(log.records[0].T_odom_robot, (Pose2{1, 2, 3}));
  EXPECT_EQ(log.records[0].speed, -0.5);  // as last stated
  EXPECT_TRUE(log.all_scans_have_records);
  log.add(bare);
  EXPECT_FALSE(log.all_scans_have_records);
}

TEST(DriveLog, ScansThatAreNotPlacedWellTellNothing) {
  Site site = site_of(drive(4, 1));
  site.scans[2].match_score = 0.4F, site.scans[5].estimate.health = Health::lost;
  const auto all = laser_poses(site, WheelSource::stream);
  EXPECT_EQ(all.size(), site.scans.size() - 2);
  const auto ordered = laser_poses(site, WheelSource::ordered, 1, 5);
  ASSERT_EQ(ordered.size(), 3U);
  EXPECT_EQ(ordered[0].time, kSecond);  // the scan's number
  EXPECT_EQ(ordered[1].time, 3 * kSecond);
}

TEST(DriveLog, WithoutOdometryThereIsNoCalibration) {
  EXPECT_THROW(calibrate_log({}, {}), Error);
  EXPECT_THROW(calibrate_log({}, site_of(drive(4, 30))), Error);
  EXPECT_TRUE(find_slips(DriveLog{}, Site{}, LogCalibration{}).empty());
}

TEST(DriveLog, SlipsAreFoundWhoeverTellsOfTheWheels) {
  const SlipLog log = drive(5, 80, kThree);
  const Site site = site_of(log);
  for (const WheelSource source :
       {WheelSource::stream, WheelSource::records, WheelSource::ordered}) {
    const auto events =
        find_slips(drive_log(log, source != WheelSource::stream), site, {{}, source});
    ASSERT_EQ(events.size(), 3U) << name_of(source);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(to_seconds(events[i].begin), kThree[i].at, 0.31) << name_of(source);
  }
}

TEST(FindSlipsOfASite, AreThoseThatWereDriven) {
  const auto events = find_slips(site_with_odometry(drive(6, 300, kThree)));
  ASSERT_EQ(events.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(to_seconds(events[i].begin), kThree[i].at, 0.31) << i;
    EXPECT_NEAR(events[i].way, kThree[i].extra.head<2>().norm(), 0.03) << i;
    EXPECT_NEAR(events[i].turn, kThree[i].extra.z(), 0.03) << i;
  }
}

// Wheels that are wrong all the time, by 3 % and 3 degrees a metre, are no slip.
TEST(FindSlipsOfASite, ConstantFaultsAreNone) {
  SlipLog log = drive(7, 300);
  for (WheelSample& s : log.wheels)
    s.twist = Vec3(1.03 * s.twist.x(), 0, s.twist.z() + 0.05 * s.twist.x());
  EXPECT_TRUE(find_slips(site_with_odometry(log)).empty());
}

// Then its stamps have to serve.
TEST(FindSlipsOfASite, AScanMayLackItsOdometry) {
  Site site = site_with_odometry(drive(6, 300, kThree));
  for (std::size_t i = 5; i < site.scans.size(); i += 50) site.scans[i].T_odom_robot.reset();
  EXPECT_EQ(find_slips(site).size(), 3U);
}

TEST(FindSlipsOfASite, ASiteThatTellsTooLittleHasNone) {
  EXPECT_TRUE(find_slips(Site{}).empty());
  EXPECT_TRUE(find_slips(site_of(drive(8, 300))).empty());            // no odometry
  EXPECT_TRUE(find_slips(site_with_odometry(drive(8, 10))).empty());  // no way
}

// A map whose poses are wrong everywhere says nothing of the wheels.
TEST(FindSlipsOfASite, ContradictionIsNoSlip) {
  Site site = site_with_odometry(drive(9, 300));
  RandomStream random(9, 1);
  Pose2 off;
  for (PosedScan& s : site.scans) {
    if (random.uniform(0, 1) < 0.1) off = off * Pose2{0.3, 0.3, 0.3};
    s.estimate.T_map_robot = s.estimate.T_map_robot * off;
  }
  EXPECT_TRUE(find_slips(site).empty());
}

TEST(SortBySize, TheBiggestComesFirstAndEqualsStayInOrder) {
  std::vector<SlipEvent> events{{1, 2, SlipKind::slip, 0.1, 0},
                                {3, 4, SlipKind::push, 0, -1},
                                {5, 6, SlipKind::push, 0.1, 0},
                                {7, 8, SlipKind::slip, 0.05, 0.6}};
  sort_by_size(events);
  const Time order[] = {3, 7, 1, 5};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(events[i].begin, order[i]);
}

}  // namespace
}  // namespace majak::motion
