// SPDX-License-Identifier: Apache-2.0
#include "majak/match/scan_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/core/random.hpp"
#include "tests/support/ascii_room.hpp"

namespace majak::match {
namespace {

using fixture::all_around;
using fixture::AsciiRoom;
using fixture::Laser;

/// A fan of beams with random returns at random mountings.
Scan random_scan(RandomStream& r) {
  Scan scan;
  scan.start_angle = r.uniform(-kPi, kPi);
  scan.angle_step = r.uniform(0.001, 0.02);
  scan.T_robot_laser = {r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-kPi, kPi)};
  for (std::size_t n = 50 + r.below(300); n > 0; --n)
    scan.ranges.push_back(static_cast<float>(r.uniform(0.1, 50)));
  return scan;
}

TEST(ScanPoints, AreWhereTrigonometryPutsThem) {
  RandomStream r(1);
  for (int run = 0; run < 20; ++run) {
    const Scan scan = random_scan(r);
    const ScanPoints points = scan_points(scan, {}, false);
    ASSERT_EQ(points.size(), scan.ranges.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double angle = scan.start_angle + static_cast<double>(i) * scan.angle_step;
      const Vec2 in_laser = scan.ranges[i] * Vec2(std::cos(angle), std::sin(angle));
      const Vec2 p = scan.T_robot_laser * in_laser;
      EXPECT_NEAR(points.x[i], p.x(), 1e-5);  // half a unit of the last place of 50 m
      EXPECT_NEAR(points.y[i], p.y(), 1e-5);
    }
  }
}

TEST(ScanPoints, WithoutNormalsThereAreNone) {
  RandomStream r(2);
  const ScanPoints points = scan_points(random_scan(r), {}, false);
  EXPECT_TRUE(points.nx.empty());
  EXPECT_TRUE(points.ny.empty());
  EXPECT_TRUE(points.target.empty());
}

TEST(ScanPoints, NormalsDoNotMovePoints) {
  RandomStream r(3);
  const Scan scan = random_scan(r);
  const ScanPoints bare = scan_points(scan, {}, false), full = scan_points(scan, {}, true);
  EXPECT_EQ(bare.x, full.x);
  EXPECT_EQ(bare.y, full.y);
  EXPECT_EQ(full.nx.size(), full.size());
  EXPECT_EQ(full.ny.size(), full.size());
  EXPECT_EQ(full.target.size(), full.size());
}

TEST(ScanPoints, KeptDirectionsEqualFreshOnes) {
  // Scans of changing geometry through one cache, as a log with two kinds of scans has them.
  RandomStream r(4);
  std::vector<Scan> scans{random_scan(r), random_scan(r), random_scan(r)};
  scans.push_back(scans[0]);
  scans.back().T_robot_laser.theta += 0.5;
  scans.push_back(scans[1]);
  scans.back().ranges.resize(20);
  scans.push_back(scans[1]);  // more beams than the one before
  scans.back().ranges.resize(400, 5.0F);
  BeamDirections directions;
  for (int pass = 0; pass < 2; ++pass)
    for (const Scan& scan : scans) {
      const ScanPoints kept = scan_points(scan, {}, false, directions),
                       fresh = scan_points(scan, {}, false);
      EXPECT_EQ(kept.x, fresh.x);
      EXPECT_EQ(kept.y, fresh.y);
    }
}

TEST(ScanPoints, OnlyReturnsWithinTheLimitsCount) {
  Scan scan;
  scan.angle_step = 0.01;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scan.ranges = {1.0F,  kNoReturn,  2.0F,  kInvalidRange, nan,   0.0F,
                 -3.0F, -kNoReturn, 0.04F, 3.0F,          60.5F, 59.5F};
  for (const bool with_normals : {false, true}) {
    const ScanPoints points = scan_points(scan, {.max_range = 60, .min_range = 0.05}, with_normals);
    ASSERT_EQ(points.size(), 4U);
    EXPECT_FLOAT_EQ(points.x[0], 1.0F);
    EXPECT_FLOAT_EQ(points.x[1], 2.0F * std::cos(0.02F));
    EXPECT_FLOAT_EQ(points.x[2], 3.0F * std::cos(0.09F));
    EXPECT_FLOAT_EQ(points.x[3], 59.5F * std::cos(0.11F));
  }
  EXPECT_EQ(scan_points(scan, {.max_range = 2.5}, false).size(), 2U);
  EXPECT_EQ(scan_points(scan, {.min_range = 2.5}, false).size(), 2U);
}

TEST(ScanPoints, NothingFromNothing) {
  Scan scan;
  for (const bool with_normals : {false, true}) {
    EXPECT_EQ(scan_points(scan, {}, with_normals).size(), 0U);
    scan.ranges.assign(181, kNoReturn);
    EXPECT_EQ(scan_points(scan, {}, with_normals).size(), 0U);
  }
}

// Normals.

const AsciiRoom& room() {
  static const AsciiRoom r({
      "################",
      "#..............#",
      "#..............#",
      "#.....a........#",
      "#..............#",
      "#..............#",
      "################",
  });
  return r;
}

TEST(ScanPoints, AWallHasItsNormalTowardsTheLaser) {
  const Pose2 T_map_robot = room().pose('a', 0.4);
  const Laser laser = all_around(720);
  const ScanPoints points = scan_points(room().scan(T_map_robot, laser), {}, true);
  int walls[4] = {};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 p = T_map_robot * Vec2(points.x[i], points.y[i]);
    const Vec2 n = Pose2{0, 0, T_map_robot.theta} * Vec2(points.nx[i], points.ny[i]);
    // The inner faces, half a metre inside; more than the window from the next corner.
    const double to_wall[4] = {p.x() - 0.5, 7.5 - p.x(), p.y() - 0.5, 3.0 - p.y()};
    const Vec2 inwards[4] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (int k = 0; k < 4; ++k) {
      const double to_corner = std::min(to_wall[(k < 2 ? 2 : 0)], to_wall[(k < 2 ? 3 : 1)]);
      if (to_wall[k] > 1e-4 || to_corner < 0.4) continue;
      ++walls[k];
      EXPECT_LT((n - inwards[k]).norm(), 1e-3) << p.transpose();
      EXPECT_EQ(points.target[i], 1);
    }
  }
  for (const int seen : walls) EXPECT_GT(seen, 40);
}

TEST(ScanPoints, NormalsAreUnitOrNone) {
  RandomStream r(5);
  for (int seed = 1; seed <= 5; ++seed) {
    Laser laser = all_around(361);
    laser.noise = 0.01;
    laser.seed = seed;
    const ScanPoints points =
        scan_points(room().scan(room().pose('a', r.uniform(-3, 3)), laser), {}, true);
    int flat = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double norm = std::hypot(points.nx[i], points.ny[i]);
      if (norm != 0) {
        EXPECT_NEAR(norm, 1, 1e-5);
      }
      flat += norm != 0;
    }
    EXPECT_GT(flat, 300);  // with 10 mm of noise a wall is still a wall
  }
}

TEST(ScanPoints, NoisyWallsKeepTheirDirection) {
  Laser laser = all_around(720);
  laser.noise = 0.01;
  const Pose2 T_map_robot = room().pose('a');
  const ScanPoints points = scan_points(room().scan(T_map_robot, laser), {}, true);
  double squares = 0;
  int n = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 p = T_map_robot * Vec2(points.x[i], points.y[i]);
    if (p.y() < 2.9 || p.x() < 1.2 || p.x() > 6.8 || points.ny[i] == 0) continue;
    squares += std::pow(std::atan2(points.nx[i], -points.ny[i]), 2);
    ++n;
  }
  ASSERT_GT(n, 100);
  EXPECT_LT(std::sqrt(squares / n), radians(6));
}

TEST(ScanPoints, ACornerTurnsFromOneWallToTheNext) {
  const Pose2 T_map_robot = room().pose('a');
  const ScanPoints points = scan_points(room().scan(T_map_robot, all_around(1440)), {}, true);
  int in_corner = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 p = T_map_robot * Vec2(points.x[i], points.y[i]);
    if ((p - Vec2(0.5, 0.5)).norm() > 0.3) continue;
    ++in_corner;
    // Between (1, 0) and (0, 1), or none in the corner itself, which then is no target either.
    EXPECT_GT(points.nx[i], -1e-3);
    EXPECT_GT(points.ny[i], -1e-3);
    EXPECT_EQ(points.target[i], points.nx[i] != 0 || points.ny[i] != 0);
  }
  EXPECT_GT(in_corner, 10);
}

TEST(ScanPoints, TheNormalLooksAtTheLaserNotAtTheRobot) {
  // The laser sits 3 m ahead and looks back: the wall between it and the robot faces the laser.
  const AsciiRoom wall({
      "....#....",
      "....#....",
      "a...#..l.",
      "....#....",
      "....#....",
  });
  Laser laser;
  laser.T_robot_laser = between(wall.pose('a'), wall.pose('l', kPi));
  laser.field_of_view = radians(60);
  const ScanPoints points = scan_points(wall.scan(wall.pose('a'), laser), {}, true);
  ASSERT_GT(points.size(), 100U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(points.x[i], 2.25, 1e-5);  // the wall's right face, from the robot
    EXPECT_NEAR(points.nx[i], 1, 1e-3);
  }
}

TEST(ScanPoints, APoleIsATargetWithoutANormal) {
  const AsciiRoom field({
      ".......",
      "...o...",
      ".......",
      ".......",
      "...a...",
  });
  const ScanPoints points =
      scan_points(field.scan(field.pose('a', kPi / 2), all_around(1440)), {}, true);
  ASSERT_GT(points.size(), 5U);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(std::hypot(points.x[i], points.y[i]), 1.47, 0.03);
    EXPECT_EQ(points.target[i], 1);
  }
}

TEST(ScanPoints, AStrayReturnIsNoTarget) {
  Scan scan;
  scan.angle_step = radians(1);
  scan.ranges.assign(90, kNoReturn);
  scan.ranges[20] = 4.0F;                          // alone
  scan.ranges[50] = 4.0F, scan.ranges[51] = 9.0F;  // neighbours far apart
  const ScanPoints points = scan_points(scan, {}, true);
  ASSERT_EQ(points.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(points.target[i], 0);
    EXPECT_EQ(points.nx[i], 0);
    EXPECT_EQ(points.ny[i], 0);
  }
}

TEST(ScanPoints, AWallSeenTooFlatIsNoTarget) {
  // Along a wall 0.3 m to the left, returns of a 1 degree scan lie a metre apart from 7 m on.
  const AsciiRoom wall({std::string(60, '#'), "a"});
  Pose2 T_map_robot = wall.pose('a');
  T_map_robot.y = 0.2;
  const ScanPoints points = scan_points(wall.scan(T_map_robot, {}), {}, true);
  int near = 0, far = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.x[i] < 1) {
      ++near;
      EXPECT_EQ(points.target[i], 1) << points.x[i];
      EXPECT_NEAR(points.ny[i], -1, 1e-3);
    } else if (points.x[i] > 8) {
      ++far;
      EXPECT_EQ(points.target[i], 0) << points.x[i];
    }
  }
  EXPECT_GT(near, 50);
  EXPECT_GE(far, 1);
}

TEST(ScanPoints, AddToMovesTargetsAndTheirNormals) {
  ScanPoints points;
  points.x = {1, 3, 5}, points.y = {0, 0, 0};
  points.nx = {-1, 0, 0}, points.ny = {0, 1, 0};
  points.target = {1, 0, 1};
  map::SurfelMap map;
  add_to(map, points, {10, 20, kPi / 2});
  ASSERT_EQ(map.surfels().size(), 2U);  // the stray one stays out
  EXPECT_NEAR(map.surfel(0).x, 10, 1e-5);
  EXPECT_NEAR(map.surfel(0).y, 21, 1e-5);
  EXPECT_NEAR(map.surfel(0).nx, 0, 1e-5);
  EXPECT_NEAR(map.surfel(0).ny, -1, 1e-5);
  EXPECT_NEAR(map.surfel(1).y, 25, 1e-5);
  EXPECT_EQ(map.surfel(1).nx, 0);
  EXPECT_EQ(map.surfel(1).ny, 0);
}

// ---- De-skew ---------------------------------------------------------------------------------

TEST(BeamTime, OneTurnForBeamsOfADegreeSeveralForFiner) {
  constexpr double kTurn = 1.0 / 75;
  Scan scan;
  scan.angle_step = radians(1.0);
  EXPECT_EQ(beam_time(scan, 0, kTurn), 0);
  EXPECT_NEAR(beam_time(scan, 180, kTurn), kTurn / 2, 1e-12);
  scan.angle_step = -radians(1.0);
  EXPECT_NEAR(beam_time(scan, 180, kTurn), kTurn / 2, 1e-12) << "turning the other way";
  scan.angle_step = radians(0.25);
  EXPECT_NEAR(beam_time(scan, 1, kTurn), kTurn * (1 + 0.25 / 360), 1e-12);
  EXPECT_NEAR(beam_time(scan, 4, kTurn), kTurn * 1.0 / 360, 1e-12) << "again in the first turn";
}

TEST(Deskew, AStandingRobotOrAMirrorWithoutTimeChangesNothing) {
  RandomStream r(21);
  const Scan scan = random_scan(r);
  const ScanPoints plain = scan_points(scan, {}, false);
  ScanPointsOptions standing, at_once;
  standing.mirror_turn = 0.1;
  at_once.twist = {1, -2, 3}, at_once.mirror_turn = 0;
  for (const auto& options : {standing, at_once}) {
    const ScanPoints same = scan_points(scan, options, false);
    EXPECT_EQ(same.x, plain.x);
    EXPECT_EQ(same.y, plain.y);
  }
}

TEST(Deskew, MovesEachBeamByWhereTheRobotWasThen) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomStream r(22, seed);
    const Scan scan = random_scan(r);
    ScanPointsOptions options;
    options.twist = {r.uniform(-1, 1), r.uniform(-0.2, 0.2), r.uniform(-1, 1)};
    const ScanPoints fast = scan_points(scan, options, false);
    std::size_t at = 0;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const float range = scan.ranges[i];
      if (!(range > options.min_range && range < options.max_range)) continue;
      const double t = beam_time(scan, i, options.mirror_turn), angle = scan.angle(i);
      const Vec2 laser =
          scan.T_robot_laser * Vec2(range * std::cos(angle), range * std::sin(angle));
      const Vec2 slow = exp(t * options.twist) * laser;
      // To first order: half the square of the turn, and of turn and way, is left.
      const double turned = t * std::abs(options.twist.z()), moved = 1.1 * t;
      const double left = 0.5 * turned * (turned * laser.norm() + moved) + 1e-5;
      EXPECT_NEAR(fast.x[at], slow.x(), left);
      EXPECT_NEAR(fast.y[at], slow.y(), left);
      ++at;
    }
    EXPECT_EQ(at, fast.size());
  }
}

TEST(WithoutLoneThings, LeavesOutAPersonAndNothingElse) {
  // 180 beams, a degree apart, in a room of 10 x 6 m: walls as rows of x(angle), a person before
  // one.
  Scan scan;
  scan.start_angle = -kPi / 2, scan.angle_step = radians(1);
  for (int i = 0; i < 181; ++i) {
    const double a = scan.angle(static_cast<std::size_t>(i));
    const double wall = std::min(std::cos(a) > 1e-6 ? 5 / std::cos(a) : 1e9,
                                 std::abs(std::sin(a)) > 1e-6 ? 3 / std::abs(std::sin(a)) : 1e9);
    scan.ranges.push_back(static_cast<float>(i >= 95 && i < 103 ? 2.0 : wall));
  }
  for (const bool normals : {false, true}) {
    const ScanPoints all = scan_points(scan, {}, normals), rest = without_lone_things(all);
    ASSERT_EQ(rest.size() + 8, all.size());
    EXPECT_EQ(rest.nx.size(), normals ? rest.size() : 0);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const std::size_t from = i < 95 ? i : i + 8;
      EXPECT_EQ(rest.x[i], all.x[from]);
      EXPECT_EQ(rest.y[i], all.y[from]);
      if (normals) {
        EXPECT_EQ(rest.nx[i], all.nx[from]);
        EXPECT_EQ(rest.ny[i], all.ny[from]);
        EXPECT_EQ(rest.target[i], all.target[from]);
      }
    }
  }
}

TEST(WithoutLoneThings, WhatReachesAWallOrIsWideStays) {
  Scan scan;
  scan.start_angle = -0.5, scan.angle_step = 0.01;
  for (int i = 0; i < 100; ++i) {
    const bool wide = i >= 20 && i < 80;  // 1.2 m at 2 m
    scan.ranges.push_back(wide ? 2.0F : 6.0F);
  }
  const ScanPoints all = scan_points(scan, {}, false);
  EXPECT_EQ(without_lone_things(all).size(), all.size());
  EXPECT_EQ(without_lone_things(all, 1.5).size() + 60, all.size());
  for (std::size_t i = 80; i < 100; ++i) scan.ranges[i] = 2.2F;  // a wall beside it
  EXPECT_EQ(without_lone_things(scan_points(scan, {}, false), 1.5).size(), 100U);
  EXPECT_EQ(without_lone_things(ScanPoints{}).size(), 0U);
}

}  // namespace
}  // namespace majak::match
