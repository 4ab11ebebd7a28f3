// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/robot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::sim {
namespace {

constexpr DriveKind kDrives[] = {DriveKind::differential, DriveKind::ackermann,
                                 DriveKind::omnidirectional};
constexpr double kTick = 0.02;  // s

Path straight(double way) {
  Path path;
  for (double x = 0; x <= way; x += kPathStep) path.points.push_back({x, 0});
  return path;
}

/// Into a dead end and back out.
Path there_and_back(double way) {
  Path path = straight(way);
  const std::vector<Vec2> back(path.points.rbegin() + 1, path.points.rend());
  path.points.insert(path.points.end(), back.begin(), back.end());
  return path;
}

Path short_tour() {
  TourOptions options;
  options.short_tour = true;
  static const World world(building());
  return plan_tour(world, options);
}

RobotOptions with(DriveKind drive, RobotOptions options = {}) {
  options.drive = drive;
  return options;
}

TEST(Robot, EveryDriveFollowsThePathToItsEnd) {
  const World world(building());
  const Path path = plan_tour(world);
  for (const DriveKind drive : kDrives) {
    const RobotRun run = drive_path(path, with(drive), 1);
    EXPECT_LT((run.states().back().T_world_robot.translation() - path.points.back()).norm(), 0.3);
    double nearest_wall = 1;
    for (std::size_t i = 0; i < run.states().size(); i += 25) {
      nearest_wall =
          std::min(nearest_wall, world.clearance(run.states()[i].T_world_robot.translation()));
    }
    EXPECT_GT(nearest_wall, 0.15);
    EXPECT_GT(run.path_length(), 0.95 * length(path.points));
    EXPECT_LT(run.path_length(), 1.1 * length(path.points));
  }
}

TEST(Robot, TruthIsContinuousAndItsTwistsLeadFromTickToTick) {
  for (const DriveKind drive : kDrives) {
    const RobotRun run = drive_path(short_tour(), with(drive), 1);
    for (std::size_t i = 1; i < run.states().size(); ++i) {
      const RobotState& a = run.states()[i - 1];
      const Pose2 b = a.T_world_robot * exp(a.twist * kTick);
      EXPECT_LT(log(between(run.states()[i].T_world_robot, b)).norm(), 1e-12);
    }
    for (Duration t = 0; t + 1'000'000 < run.duration(); t += 7'654'321) {
      EXPECT_LT(log(between(run.truth(t), run.truth(t + 1'000'000))).norm(), 0.0013);  // 1 ms
    }
    EXPECT_EQ(run.truth(-5), run.states().front().T_world_robot);  // held beyond the ends
    EXPECT_EQ(run.truth(run.duration() + 5), run.states().back().T_world_robot);
  }
}

TEST(Robot, ObeysItsLimits) {
  for (const DriveKind drive : kDrives) {
    const RobotOptions o = with(drive);
    const RobotRun run = drive_path(short_tour(), o, 1);
    Vec3 last = Vec3::Zero();
    for (const RobotState& s : run.states()) {
      EXPECT_LE(s.twist.head<2>().norm(), o.speed * 1.02);
      EXPECT_LE((s.twist - last).head<2>().norm(), o.acceleration * kTick * 1.5);
      EXPECT_TRUE(drive == DriveKind::omnidirectional || s.twist.y() == 0);
      if (drive == DriveKind::ackermann) {
        const double most = std::abs(s.twist.x()) * std::tan(o.max_steering) / o.wheelbase;
        EXPECT_LE(std::abs(s.twist.z()), most + 1e-9);
      } else {
        EXPECT_LE(std::abs(s.twist.z()), o.turn_rate + 1e-9);
      }
      last = s.twist;
    }
    EXPECT_EQ(run.states().front().twist, Vec3::Zero());  // begins and ends at rest
    EXPECT_LT(run.states().back().twist.norm(), 1e-9);
  }
}

TEST(Robot, DeadEndsAreLeftByEveryDrive) {
  for (const DriveKind drive : kDrives) {
    const RobotRun run = drive_path(there_and_back(5), with(drive), 1);
    EXPECT_LT(run.states().back().T_world_robot.translation().norm(), 0.3);
    const bool backs = std::any_of(run.states().begin(), run.states().end(),
                                   [](const RobotState& s) { return s.twist.x() < -0.1; });
    EXPECT_TRUE(backs);
  }
}

TEST(Robot, PerfectWheelsTellTheTruth) {
  for (const DriveKind drive : kDrives) {
    const RobotRun run = drive_path(short_tour(), perfect_wheels(with(drive)), 1);
    const Pose2 T_world_odom = run.states().front().T_world_robot;
    for (Duration t = 0; t < run.duration(); t += 33'000'000) {
      const Pose2 error = between(T_world_odom * run.odometry(t), run.truth(t));
      ASSERT_LT(log(error).norm(), 1e-7);
    }
  }
}

TEST(Robot, EqualSeedsAreEqualAndOthersAreNot) {
  for (const DriveKind drive : kDrives) {
    const RobotRun a = drive_path(straight(5), with(drive), 7),
                   b = drive_path(straight(5), with(drive), 7);
    const RobotRun c = drive_path(straight(5), with(drive), 8);
    ASSERT_EQ(a.states().size(), b.states().size());
    for (std::size_t i = 0; i < a.states().size(); ++i) {
      ASSERT_EQ(a.states()[i].T_odom_robot, b.states()[i].T_odom_robot);
    }
    EXPECT_NE(a.states().back().T_odom_robot, c.states().back().T_odom_robot);
    EXPECT_EQ(a.states().back().T_world_robot,
              c.states().back().T_world_robot);  // noise is not felt
  }
}

TEST(Odometry, UnequalWheelsBendAStraight) {
  // A straight of length s looks like an arc: turn = (right - left) / track.
  RobotOptions o = perfect_wheels();
  o.left_scale = 1.01;
  const RobotRun run = drive_path(straight(10), o, 1);
  const double way = run.states().back().T_world_robot.x;
  const Pose2 odom = run.states().back().T_odom_robot;
  EXPECT_NEAR(odom.theta, -0.01 * way / o.track, 1e-9);
  const Pose2 arc = exp({1.005 * way, 0, -0.01 * way / o.track});
  EXPECT_NEAR(odom.x, arc.x, 1e-9);
  EXPECT_NEAR(odom.y, arc.y, 1e-9);
}

TEST(Odometry, BelievedTrackScalesTurns) {
  RobotOptions o = perfect_wheels();
  o.track_scale = 1.05;
  const RobotRun run = drive_path(there_and_back(3), o, 1);
  double truth = 0;
  for (const RobotState& s : run.states()) truth += s.twist.z() * kTick;
  EXPECT_NEAR(angle_diff(run.states().back().T_odom_robot.theta, truth / 1.05), 0, 1e-9);
}

TEST(Odometry, SteeringOffsetBendsAStraight) {
  RobotOptions o = perfect_wheels(with(DriveKind::ackermann));
  o.steering_offset = 0.01;
  const RobotRun run = drive_path(straight(10), o, 1);
  const double way = run.states().back().T_world_robot.x;
  EXPECT_NEAR(run.states().back().T_odom_robot.theta, way * std::sin(0.01) / o.wheelbase, 1e-9);
}

TEST(Robot, ACarOfFullSizeDrivesTheYardWithoutShunting) {
  const World world(yard());
  for (const bool short_tour : {true, false}) {
    TourOptions tour;
    tour.short_tour = short_tour;
    const Path path = plan_tour(world, tour);
    SimulationOptions o;
    make_car(o);
    const RobotRun run = drive_path(path, o.robot, 1);
    double sharpest = 0;
    for (const RobotState& s : run.states()) {
      EXPECT_GE(s.twist.x(), 0);
      if (s.twist.x() > 0) sharpest = std::max(sharpest, std::abs(s.twist.z() / s.twist.x()));
      const Vec2 bumper = s.T_world_robot * Vec2(o.mounting_x, 0);
      EXPECT_GT(std::min(world.clearance(s.T_world_robot.translation()), world.clearance(bumper)),
                1);
    }
    EXPECT_LE(sharpest, std::tan(o.robot.max_steering) / o.robot.wheelbase + 1e-9);
    EXPECT_GT(run.path_length(), short_tour ? 100 : 300);
  }
}

TEST(Odometry, CounterAndSteeringAreThoseOfTheAxle) {
  RobotOptions o = perfect_wheels(with(DriveKind::ackermann));
  o.reports_steering = true;
  o.left_scale = 1.1, o.steering_scale = 0.9, o.steering_offset = 0.02;
  const RobotRun run = drive_path(short_tour(), o, 1);
  double way = 0;
  for (std::size_t i = 0; i + 1 < run.states().size(); ++i) {
    const Duration begin = static_cast<Duration>(i) * RobotRun::kTick;
    const Vec2 counted = run.counted(begin + RobotRun::kTick) - run.counted(begin);
    const Vec3& twist = run.states()[i].twist;
    way += twist.x() * kTick;
    EXPECT_NEAR(counted.x(), 1.1 * twist.x() * kTick, 1e-9);
    if (std::abs(twist.x()) < 1e-6) continue;
    const double steering = std::atan(o.wheelbase * twist.z() / twist.x());
    EXPECT_NEAR(counted.y(), (0.9 * steering + 0.02) * kTick, 1e-9);
  }
  EXPECT_NEAR(run.counted(run.duration()).x(), 1.1 * way, 1e-6);
  const Vec2 half = run.counted(10 * RobotRun::kTick + RobotRun::kTick / 2);
  EXPECT_NEAR(half.y(), 10.5 * kTick * 0.02, 1e-9);  // at rest, straight ahead
  o.drive = DriveKind::differential;
  EXPECT_THROW(drive_path(short_tour(), o, 1), Error);
}

// The truth and the way go on as they would; only the steering stays.
TEST(Odometry, AStuckSteeringRepeatsItsValue) {
  RobotOptions o = with(DriveKind::ackermann);
  o.reports_steering = true;
  const RobotRun sound = drive_path(short_tour(), o, 1);
  o.steering_stuck_at = 30, o.steering_stuck_for = 4;
  const RobotRun stuck = drive_path(short_tour(), o, 1);
  ASSERT_EQ(sound.states().size(), stuck.states().size());
  const auto reading = [](const RobotRun& run, std::size_t tick) {
    return run.states()[tick + 1].steered - run.states()[tick].steered;
  };
  const double last = reading(stuck, 1499);
  double most = 0;
  for (std::size_t tick = 0; tick + 1 < stuck.states().size(); ++tick) {
    EXPECT_EQ(sound.states()[tick].T_world_robot, stuck.states()[tick].T_world_robot);
    EXPECT_EQ(sound.states()[tick].rolled, stuck.states()[tick].rolled);
    const bool sticks = tick >= 1500 && tick < 1700;
    EXPECT_NEAR(reading(stuck, tick), sticks ? last : reading(sound, tick), 1e-12) << tick;
    if (sticks) most = std::max(most, std::abs(last - reading(sound, tick)));
  }
  EXPECT_GT(most, 0.05);  // it did steer meanwhile
}

TEST(Odometry, SlipGrowsWithTheRootOfTheWay) {
  // Each wheel errs by slip sqrt(way): heading sigma = slip sqrt(2 way) / track, way sigma =
  // slip sqrt(way / 2). Chi-square over the runs, bounds of four sigma.
  RobotOptions o = perfect_wheels();
  o.slip = 0.005;
  for (const double goal : {5.0, 20.0}) {
    constexpr int runs = 150;
    double heading = 0, along = 0;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      const RobotRun run = drive_path(straight(goal), o, seed);
      const double way = run.states().back().T_world_robot.x;
      double believed = 0;
      for (std::size_t i = 1; i < run.states().size(); ++i) {
        believed +=
            log(between(run.states()[i - 1].T_odom_robot, run.states()[i].T_odom_robot)).x();
      }
      heading += std::pow(run.states().back().T_odom_robot.theta * o.track / o.slip, 2) / (2 * way);
      along += std::pow((believed - way) / o.slip, 2) * 2 / way;
    }
    EXPECT_NEAR(heading, runs, 4 * std::sqrt(2.0 * runs));
    EXPECT_NEAR(along, runs, 4 * std::sqrt(2.0 * runs));
  }
}

TEST(Odometry, SystematicErrorsHaveTheirSigma) {
  RobotOptions o = perfect_wheels();
  o.scale_sigma = 0.01;
  o.unequal_sigma = 0.002;
  constexpr int runs = 300;
  double scale = 0, turn = 0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const RobotRun run = drive_path(straight(1), o, seed);
    const RobotState& end = run.states().back();
    const double way = end.T_world_robot.x;
    const double believed = log(end.T_odom_robot).x();
    scale += std::pow(believed / way - 1, 2) / (0.01 * 0.01 + 0.002 * 0.002 / 2);
    turn += std::pow(end.T_odom_robot.theta * o.track / way / 0.002, 2) / 2;
  }
  EXPECT_NEAR(scale, runs, 4 * std::sqrt(2.0 * runs));
  EXPECT_NEAR(turn, runs, 4 * std::sqrt(2.0 * runs));
}

TEST(Odometry, EncoderCountsWholeSteps) {
  RobotOptions o = perfect_wheels();
  o.encoder_step = 0.01;
  const RobotRun run = drive_path(straight(5), o, 1);
  for (const RobotState& s : run.states()) {
    EXPECT_NEAR(std::remainder(s.T_odom_robot.x, 0.01), 0, 1e-9);
    EXPECT_LE(std::abs(s.T_odom_robot.x - s.T_world_robot.x), 0.01 + 1e-9);  // nothing is lost
  }
}

TEST(Odometry, WrongDirectionCountsBackingAsAhead) {
  RobotOptions o = perfect_wheels();
  const RobotRun right = drive_path(there_and_back(4), o, 1);
  o.wrong_direction = true;
  const RobotRun wrong = drive_path(there_and_back(4), o, 1);
  double backed = 0, difference = 0;
  for (std::size_t i = 1; i < right.states().size(); ++i) {
    const auto step = [i](const RobotRun& run) {
      return log(between(run.states()[i - 1].T_odom_robot, run.states()[i].T_odom_robot)).x();
    };
    backed += std::max(0.0, -step(right));
    difference += step(wrong) - step(right);
    EXPECT_GE(step(wrong), -1e-12);
  }
  EXPECT_GT(backed, 0.3);
  EXPECT_NEAR(difference, 2 * backed, 1e-9);
  // The speed still says which way the wheels turned.
  const auto backs = [](const RobotState& s) { return s.speed < -0.1; };
  EXPECT_TRUE(std::any_of(wrong.states().begin(), wrong.states().end(), backs));
}

TEST(Odometry, DefaultErrorIsAFewPercent) {
  double squares = 0;
  constexpr int runs = 40;
  const Path path = short_tour();
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const RobotRun run = drive_path(path, {}, seed);
    const Pose2 end = path.start * run.states().back().T_odom_robot;
    squares += (end.translation() - run.states().back().T_world_robot.translation()).squaredNorm();
  }
  const double error = std::sqrt(squares / runs) / length(path.points);
  EXPECT_TRUE(error > 0.005 && error < 0.05) << error;
}

TEST(Robot, NonsenseIsAnError) {
  EXPECT_THROW(drive_path({}, {}, 1), Error);
  RobotOptions o;
  o.speed = 0;
  EXPECT_THROW(drive_path(straight(2), o, 1), Error);
  o = {};
  o.track = -1;
  EXPECT_THROW(drive_path(straight(2), o, 1), Error);
}

}  // namespace
}  // namespace majak::sim
