// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/front_end.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "tests/support/ascii_room.hpp"
#include "tests/unit/slam/simulated.hpp"

namespace majak::slam {
namespace {

using fixture::all_around;
using fixture::AsciiRoom;
using fixture::Laser;

const AsciiRoom& room() {
  static const AsciiRoom r({
      "########################",
      "#........#.............#",
      "#........#.............#",
      "#.................##...#",
      "#.....a...........##...#",
      "#......................#",
      "#......................#",
      "###.......#............#",
      "###.......##.......o...#",
      "########################",
  });
  return r;
}

Scan scan_at(const Pose2& T_map_robot, int number, double noise = 0.005) {
  Laser laser = all_around(181);
  laser.noise = noise;
  laser.seed = number + 1;
  Scan scan = room().scan(T_map_robot, laser);
  scan.time = from_seconds(0.1 * number);
  return scan;
}

double off(const Pose2& a, const Pose2& b) { return between(a, b).translation().norm(); }

/// Worst drift in m along a simulated run, as a share of the way to there from 10 m on.
double drift_of(const std::vector<Event>& events, bool with_odometry) {
  FrontEnd front_end({});
  const auto truth = truth_of(events);
  std::optional<Pose2> T_odom_before, T_world_before, T_world_map;
  double way = 0, worst = 0;
  for (const Event& e : events) {
    const auto* scan = std::get_if<Scan>(&e);
    if (scan == nullptr) continue;
    std::optional<MotionPrior> motion;
    if (with_odometry && T_odom_before)
      motion = MotionPrior{between(*T_odom_before, *scan->T_odom_robot), 0.03, 0.03};
    T_odom_before = scan->T_odom_robot;
    const FrontEndStep step = front_end.add(*scan, motion);
    const Pose2& T_world_robot = truth.at(scan->time);
    if (!T_world_map) T_world_map = T_world_robot * step.T_map_robot.inverse();
    if (T_world_before) way += off(*T_world_before, T_world_robot);
    T_world_before = T_world_robot;
    worst =
        std::max(worst, off(T_world_robot, *T_world_map * step.T_map_robot) / std::max(way, 10.0));
  }
  return worst;
}

TEST(FrontEnd, FollowsASimulatedRunWithOdometry) {
  EXPECT_LT(drift_of(building_run(), true), 0.007);
}

TEST(FrontEnd, FollowsASimulatedRunWithoutOdometry) {
  EXPECT_LT(drift_of(building_run(), false), 0.015);
}

TEST(FrontEnd, AStandingRobotStands) {
  FrontEnd front_end({});
  int keys = 0;
  double worst = 0;
  for (int i = 0; i < 150; ++i) {
    const FrontEndStep step = front_end.add(scan_at(room().pose('a'), i, 0.01), std::nullopt);
    worst = std::max(worst, off(step.T_map_robot, {}));
    keys += step.key;
  }
  EXPECT_LT(worst, 0.015);
  EXPECT_EQ(keys, 1);
}

TEST(FrontEnd, BeginsAtZeroWithAKeyScan) {
  FrontEnd front_end({});
  const FrontEndStep step = front_end.add(scan_at(room().pose('a', 1), 0), std::nullopt);
  EXPECT_EQ(step.T_map_robot, Pose2{});
  EXPECT_TRUE(step.key);
  EXPECT_FALSE(step.searched);
  EXPECT_FALSE(step.broken);
  EXPECT_EQ(step.key_points.size(), 181U);
}

TEST(FrontEnd, KeyScansComeByWayAndByTurn) {
  for (const bool turning : {false, true}) {
    FrontEnd front_end({});
    const Pose2 start = room().pose('a');
    int keys = 0;
    for (int i = 0; i <= 100; ++i) {
      const Pose2 T =
          start * (turning ? Pose2{0, 0, 0.02 * i} : Pose2{0.02 * i, 0, 0});  // 2 m or 2 rad
      const FrontEndStep step = front_end.add(scan_at(T, i, 0), std::nullopt);
      keys += step.key;
      EXPECT_EQ(step.key_points.size() > 0, step.key);
      EXPECT_LT(off(start * step.T_map_robot, T), 0.01);
    }
    EXPECT_NEAR(keys, turning ? 1 + 2 / 0.18 : 1 + 2 / 0.26, 1.01);
  }
}

TEST(FrontEnd, KeyScansSayHowTheRobotMovedSinceTheOneBefore) {
  // Wheels that are right, and a habit that has to guess.
  for (const bool wheels : {true, false}) {
    FrontEnd front_end({});
    const Pose2 start = room().pose('a'), step = exp(Vec3(0.06, 0, 0.02));
    Pose2 T = start, key = start;
    int since = 0, keys = 0;
    for (int i = 0; i <= 60; ++i) {
      if (i > 0) T = T * step, ++since;
      const FrontEndStep s = front_end.add(
          scan_at(T, i),
          i > 0 && wheels ? std::optional(MotionPrior{step, 0.01, 0.02}) : std::nullopt);
      if (!s.key) continue;
      if (++keys > 1 && wheels) {
        EXPECT_LT(between(between(key, T), s.T_key_predicted).vector().norm(), 1e-9) << i;
        EXPECT_NEAR(s.predicted_variance.x(), since * 1e-4, 1e-12);  // errors of their own
        EXPECT_NEAR(s.predicted_variance.z(), since * 4e-4, 1e-12);
      } else if (keys > 3) {
        EXPECT_LT(off(between(key, T), s.T_key_predicted), 0.03) << i;
        EXPECT_GE(s.predicted_variance.x(), std::pow(since * 0.02, 2) - 1e-12);  // of one sign
        EXPECT_LE(s.predicted_variance.x(), std::pow(since * 0.10, 2) + 1e-12);
      }
      key = T, since = 0;
    }
    EXPECT_GT(keys, 8);
  }
}

TEST(FrontEnd, LocalMapsOverlapAndHoldAsManyAsTheyShould) {
  FrontEndOptions options;
  options.local_map_keys = 6;
  options.key_turn = 0.1;
  FrontEnd front_end(options);
  std::vector<std::size_t> begun;  // by key scan: where its local map began
  for (int i = 0; begun.size() < 60; ++i) {
    ASSERT_LT(i, 500);
    const FrontEndStep step = front_end.add(scan_at(room().pose('a', 0.06 * i), i),
                                            MotionPrior{{0, 0, 0.06}, 0.02, 0.02});
    if (step.key) begun.push_back(step.local_map);
  }
  EXPECT_EQ(begun[0], 0U);
  for (std::size_t k = 1; k < begun.size(); ++k) {
    EXPECT_GE(begun[k], begun[k - 1]) << k;
    EXPECT_GE(k - begun[k], k < 6 ? k : 6U) << k;  // matched to so many,
    EXPECT_LE(k - begun[k], 12U) << k;             // and to no more
  }
  EXPECT_GT(std::set(begun.begin(), begun.end()).size(), 7U);
}

TEST(FrontEnd, ABrokenChainBeginsALocalMap) {
  FrontEnd front_end({});
  std::size_t keys = 0;
  for (int i = 0; i < 12; ++i, ++keys)
    ASSERT_TRUE(front_end.add(scan_at(room().pose('a', 0.2 * i), i), std::nullopt).key);
  const AsciiRoom other({"#########", "#..a....#", "##...####", "#######.."}, 0.9);
  Scan scan = other.scan(other.pose('a'), all_around(181));
  scan.time = from_seconds(10);
  const FrontEndStep step = front_end.add(scan, std::nullopt);
  ASSERT_TRUE(step.broken && step.key);
  EXPECT_EQ(step.local_map, keys);
}

TEST(FrontEnd, WithoutWheelsItStopsWhereTheNicheSaysSo) {
  // A corridor whose ends are not seen. The robot brakes at once; its habit says it goes on. Where
  // the few returns from the niches are not looked for, it is metres off at the end.
  const AsciiRoom corridor({
      "................................................................................",
      "#####.###########.#############.############.#############.###########.#########",
      "................................................................................",
      "................................................................................",
      "................................................................................",
      "..a.............................................................................",
      "##############.############.##########.##########.############.#######.#########",
      "................................................................................",
  });
  Laser laser = all_around(361);
  laser.max_range = 5;
  laser.noise = 0.008;
  FrontEnd front_end({});
  const Pose2 start = corridor.pose('a') * Pose2{8, 0.3, 0};
  double way = 0, worst = 0;
  for (int i = 0; i < 80; ++i) {
    // m a scan: on, stop, on, back
    const double speed = i / 10 % 2 == 0 ? 0.12 : i / 20 % 2 == 0 ? 0.0 : -0.06;
    if (i > 0) way += speed;
    laser.seed = i + 1;
    Scan scan = corridor.scan(start * Pose2{way, 0, 0}, laser);
    scan.time = from_seconds(0.2 * i);
    worst = std::max(worst, off(front_end.add(scan, std::nullopt).T_map_robot, {way, 0, 0}));
  }
  EXPECT_LT(worst, 0.04);
}

TEST(FrontEnd, AJumpIsFoundBySearching) {
  for (const Pose2& jump : {Pose2{0.5, 0, 0}, Pose2{-0.2, 0.4, 0.3}, Pose2{0, 0, 0.45}}) {
    FrontEnd front_end({});
    const Pose2 start = room().pose('a');
    for (int i = 0; i < 5; ++i) front_end.add(scan_at(start, i), std::nullopt);
    const FrontEndStep step = front_end.add(scan_at(start * jump, 5), std::nullopt);
    EXPECT_LT(off(step.T_map_robot, jump), 0.02) << jump.vector().transpose();
    EXPECT_LT(std::abs(angle_diff(step.T_map_robot.theta, jump.theta)), 0.01);
    EXPECT_GT(step.match.score, 0.7);
  }
}

TEST(FrontEnd, WrongOdometryIsOverruled) {
  // The wheels claim a metre a scan; the walls know better.
  FrontEnd front_end({});
  const Pose2 start = room().pose('a');
  front_end.add(scan_at(start, 0), std::nullopt);
  for (int i = 1; i < 20; ++i) {
    const Pose2 T = start * Pose2{0.05 * i, 0, 0};
    const FrontEndStep step = front_end.add(scan_at(T, i), MotionPrior{{0.25, 0, 0.1}, 0.1, 0.1});
    EXPECT_LT(off(start * step.T_map_robot, T), 0.02) << i;
  }
}

TEST(FrontEnd, WhatContradictsTheWheelsNeedsWitnesses) {
  // The wheels stand. One or two scans that look like half a metre farther on are a person before
  // the laser; a third one, and the robot was carried.
  const Pose2 start = room().pose('a'), jump{0.5, 0, 0};
  const MotionPrior standing{{}, 0.01, 0.01};
  for (const int lies : {1, 2, 3}) {
    FrontEnd front_end({});
    int i = 0;
    for (; i < 5; ++i) front_end.add(scan_at(start, i), standing);
    for (int lie = 1; lie <= lies; ++lie) {
      const FrontEndStep step = front_end.add(scan_at(start * jump, i++), standing);
      EXPECT_EQ(step.held, lie < 3);
      if (step.held) {
        EXPECT_FALSE(step.key || step.broken);
        EXPECT_LT(off(step.T_map_robot, {}), 0.05);
      } else {
        EXPECT_LT(off(step.T_map_robot, jump), 0.02);
      }
    }
    if (lies == 3) continue;
    const FrontEndStep back = front_end.add(scan_at(start, i++), standing);
    EXPECT_LT(off(back.T_map_robot, {}), 0.01);
    EXPECT_FALSE(back.held);
    // Told anew, it begins to count anew.
    EXPECT_TRUE(front_end.add(scan_at(start * jump, i), standing).held);
  }
}

TEST(FrontEnd, WheelsThatSlipALittleAreOverruledAtOnce) {
  const Pose2 start = room().pose('a');
  for (const Pose2& slip : {Pose2{0.25, 0, 0}, Pose2{0, 0, 0.35}}) {
    FrontEnd front_end({});
    for (int i = 0; i < 5; ++i) front_end.add(scan_at(start, i), MotionPrior{{}, 0.01, 0.01});
    const FrontEndStep step = front_end.add(scan_at(start * slip, 5), MotionPrior{{}, 0.01, 0.01});
    EXPECT_FALSE(step.held);
    EXPECT_LT(off(step.T_map_robot, slip), 0.02);
  }
}

TEST(FrontEnd, BlindScansGoWithTheMotion) {
  FrontEnd front_end({});
  front_end.add(scan_at(room().pose('a'), 0), std::nullopt);
  Scan blind = scan_at(room().pose('a'), 1);
  blind.ranges.assign(181, kNoReturn);
  const Pose2 step{0.3, 0, 0.1};
  Pose2 expected;
  for (int i = 1; i < 5; ++i) {
    blind.time = from_seconds(0.1 * i);
    expected = expected * step;
    const FrontEndStep moved = front_end.add(blind, MotionPrior{step, 0.05, 0.05});
    EXPECT_FALSE(moved.key);
    EXPECT_LT(off(moved.T_map_robot, expected), 1e-9);
    EXPECT_EQ(moved.match.score, 0);
  }
  // Seeing again, it stands where it is.
  const FrontEndStep seeing =
      front_end.add(scan_at(room().pose('a') * expected, 5), MotionPrior{{}, 0.05, 0.05});
  EXPECT_LT(off(seeing.T_map_robot, expected), 0.02);
}

TEST(FrontEnd, AnotherPlaceBreaksTheChain) {
  const AsciiRoom other(
      {
          "##############",
          "##...#...#..##",
          "#..........###",
          "##....a......#",
          "#....###....##",
          "##############",
      },
      0.7);
  for (const double pause : {0.1, 5.0}) {
    FrontEnd front_end({});
    for (int i = 0; i < 10; ++i) front_end.add(scan_at(room().pose('a'), i), std::nullopt);
    Pose2 begun;
    bool told = false;
    for (int i = 0; i < 20; ++i) {
      const double turned = 0.03 * (i - 10);
      Scan scan = other.scan(other.pose('a', turned), all_around(181));
      scan.time = from_seconds(0.9 + pause + 0.1 * i);
      const FrontEndStep step = front_end.add(scan, std::nullopt);
      told = told || step.broken || step.match.score < FrontEndOptions{}.weak_score;
      if (pause > FrontEndOptions{}.gap && i == 0) {
        EXPECT_TRUE(step.broken && step.key);
      }
      if (i == 10) begun = step.T_map_robot;
      if (i > 10) {
        const Pose2 moved = between(begun, step.T_map_robot);  // the new place is followed
        EXPECT_LT(moved.translation().norm(), 0.03);
        EXPECT_NEAR(moved.theta, turned, 0.02);
        EXPECT_FALSE(step.broken);
      }
    }
    EXPECT_TRUE(told) << pause;
  }
}

TEST(FrontEnd, EqualRunsAreEqual) {
  const auto run = [] {
    FrontEnd front_end({});
    std::vector<Pose2> path;
    for (int i = 0; i < 60; ++i)
      path.push_back(
          front_end
              .add(scan_at(room().pose('a', 0.05 * i) * Pose2{0.02 * i, 0, 0}, i), std::nullopt)
              .T_map_robot);
    return path;
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace majak::slam
