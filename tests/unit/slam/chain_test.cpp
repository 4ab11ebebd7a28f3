// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/chain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/graph/marginals.hpp"

namespace majak::slam {
namespace {

Mat3 turned(double theta, const Mat3& m) {
  Mat3 r = Mat3::Identity();
  r.topLeftCorner<2, 2>() << std::cos(theta), -std::sin(theta), std::sin(theta), std::cos(theta);
  return r * m * r.transpose();
}

double least(const Mat3& m) { return Eigen::SelfAdjointEigenSolver<Mat3>(m).eigenvalues()(0); }

/// A step of the front end: pose, what the match says in the map's axes, motion and its variance.
FrontEndStep step_of(const Pose2& T_map_robot, const Mat3& match, const Pose2& moved = {},
                     const Vec3& variance = Vec3(1e-3, 1e-3, 1e-3)) {
  FrontEndStep step;
  step.T_map_robot = T_map_robot;
  step.match.information = match;
  step.key = true;
  step.T_key_predicted = moved;
  step.predicted_variance = variance;
  return step;
}

struct Ground {
  Mat3 match = Vec3(2e5, 3e5, 1e6).asDiagonal();  // axes of the map
  Vec3 variance = Vec3(1e-3, 1e-3, 1e-3);         // of each motion
  double turn = 0.3;                              // rad, largest between key scans
  double heading = 0;                             // rad, of the first key scan
};

/// n key scans of one local map, a quarter metre between them.
KeyScans chain(int n, const Ground& ground = {}, std::size_t weak_key = 0, std::uint64_t seed = 1) {
  RandomStream r(seed);
  KeyScans keys;
  Pose2 at{1, 2, ground.heading};
  for (int i = 0; i < n; ++i) {
    const Pose2 moved = i == 0 ? Pose2{} : exp(Vec3(0.25, 0, ground.turn * r.uniform(-1, 1)));
    at = at * moved;
    const auto k = static_cast<std::size_t>(i);
    keys.push_back(key_scan(step_of(at, ground.match, moved, ground.variance), 10 * k, {},
                            weak_key > 0 && k == weak_key));
  }
  return keys;
}

TEST(KeyScan, TakesOverWhatTheStepSays) {
  FrontEndStep step = step_of({1, 2, 0.5}, Mat3::Identity(), {0.2, 0.1, 0.05});
  step.key_points.x = {1, 2, 3};
  step.local_map = 7;
  const KeyScan key = key_scan(std::move(step), 42, {0.1, 0, 0.3}, true);
  EXPECT_EQ(key.scan, 42U);
  EXPECT_EQ(key.points.x.size(), 3U);
  EXPECT_EQ(key.T_robot_laser, (Pose2{0.1, 0, 0.3}));
  EXPECT_EQ(key.T_front_robot, (Pose2{1, 2, 0.5}));
  EXPECT_EQ(key.local_map, 7U);
  EXPECT_EQ(key.T_previous_predicted, (Pose2{0.2, 0.1, 0.05}));
  EXPECT_TRUE(key.weak_step);
}

TEST(KeyScan, ItsInformationIsInItsOwnAxes) {
  // Strong across the map's x; seen by a robot of any heading.
  const Mat3 match = Vec3(1e3, 1e5, 1e5).asDiagonal();
  const Mat3 straight = key_scan(step_of({}, match), 0, {}, false).match_information;
  EXPECT_GT(straight(1, 1), 20 * straight(0, 0));
  for (const double theta : {0.5, 1.57, -2.5}) {
    // The robot turns and the walls do not; then the walls turn with the robot.
    const Mat3 robot = key_scan(step_of({3, -4, theta}, match), 0, {}, false).match_information;
    EXPECT_LT((turned(theta, robot) - straight).norm(), 1e-6 * straight.norm());
    const Mat3 both =
        key_scan(step_of({3, -4, theta}, turned(theta, match)), 0, {}, false).match_information;
    EXPECT_LT((both - straight).norm(), 1e-6 * straight.norm());
  }
}

TEST(KeyScan, ItsInformationIsSymmetricHoweverLittleOneDirectionTells) {
  RandomStream r(1);
  for (int run = 0; run < 10'000; ++run) {
    Mat3 axes;
    for (double& value : axes.reshaped()) value = r.normal();
    const Vec3 tells(std::pow(10, r.uniform(-2, 8)), std::pow(10, r.uniform(-2, 8)), 1e8);
    const Mat3 match = axes * tells.asDiagonal() * axes.transpose();
    const Mat3 own = key_scan(step_of({0, 0, r.uniform(-3, 3)}, 0.5 * (match + match.transpose())),
                              0, {}, run % 2 == 0)
                         .match_information;
    ASSERT_EQ(own, own.transpose());
    ASSERT_GT(least(own), 0);
  }
}

TEST(KeyScan, AWeakStepIsLessSureInAllDirections) {
  for (const double size : {0.0, 1.0, 1e6}) {
    const auto key = [&](bool weak) {
      return key_scan(step_of({0, 0, 1}, size * Mat3::Identity()), 0, {}, weak);
    };
    const KeyScan sure = key(false), weak = key(true);
    EXPECT_GT(least(sure.match_information - weak.match_information), 0) << size;
    EXPECT_GT(least(sure.motion_information - weak.motion_information), 0) << size;
    EXPECT_GT(least(weak.match_information), 0) << size;
    EXPECT_LT(weak.match_information(0, 0), 26);  // 20 cm
    EXPECT_LT(weak.motion_information(0, 0), 26);
  }
}

TEST(KeyScan, NoReturnsAndAllReturnsStayWithinBounds) {
  const KeyScan none = key_scan(step_of({}, Mat3::Zero(), {}, Vec3::Zero()), 0, {}, false);
  EXPECT_GT(least(none.match_information), 0);
  EXPECT_LT(none.match_information.norm(), 0.01);
  EXPECT_LT(none.motion_information.norm(), 1e7);  // 1 mm
  const KeyScan all = key_scan(step_of({}, 1e12 * Mat3::Identity()), 0, {}, false);
  EXPECT_LT(all.match_information(0, 0), 1 / std::pow(0.0019, 2));
  EXPECT_LT(all.match_information(2, 2), 1 / std::pow(0.0009, 2));
}

TEST(MotionEdge, IsThePredictedMotion) {
  const KeyScans keys = chain(5);
  for (std::size_t k = 1; k < 5; ++k) {
    const graph::Edge edge = motion_edge(keys, k);
    EXPECT_EQ(edge.from + 1, edge.to);
    EXPECT_EQ(edge.to, static_cast<int>(k));
    EXPECT_EQ(edge.T_from_to, keys[k].T_previous_predicted);
    EXPECT_EQ(edge.information, keys[k].motion_information);
    EXPECT_FALSE(edge.robust);
  }
}

TEST(MatchEdges, LeadFromTheFirstKeyScanToWhereItStands) {
  KeyScans keys = chain(12);
  for (std::size_t k = 6; k < 12; ++k) keys[k].local_map = 4;
  for (std::size_t k = 1; k < 12; ++k) {
    const auto edges = match_edges(keys, k);
    ASSERT_EQ(edges.size(), 1U);
    EXPECT_EQ(edges[0].from, k < 6 ? 0 : 4);
    EXPECT_EQ(edges[0].to, static_cast<int>(k));
    EXPECT_FALSE(edges[0].robust);
    EXPECT_EQ(edges[0].information, keys[k].match_information);
    const Pose2 round =
        keys[static_cast<std::size_t>(edges[0].from)].T_front_robot * edges[0].T_from_to;
    EXPECT_LT(between(round, keys[k].T_front_robot).vector().norm(), 1e-12);
  }
}

TEST(MatchEdges, TheFirstHangsOnNothing) {
  KeyScans keys = chain(8);
  keys[5].local_map = 5;
  EXPECT_TRUE(match_edges(keys, 0).empty());
  EXPECT_TRUE(match_edges(keys, 5).empty());
  EXPECT_FALSE(match_edges(keys, 4).empty());
}

TEST(MatchEdges, BeyondAnEmptyCorridorTheWayIsMeasuredFromThere) {
  // Key scan 6 of 12 sees two walls and nothing across; those after it see all again.
  const double heading = 0.7;
  Ground ground;
  ground.heading = heading;
  KeyScans keys = chain(12, ground);
  const Mat3 corridor = turned(heading, Vec3(0, 3e5, 1e6).asDiagonal());
  keys[6].match_information =
      key_scan(step_of(keys[6].T_front_robot, corridor), 0, {}, false).match_information;
  for (std::size_t k = 1; k < 12; ++k) {
    const auto edges = match_edges(keys, k);
    ASSERT_EQ(edges.size(), k > 6 ? 2U : 1U) << k;
    EXPECT_EQ(edges[0].from, 0);
    if (k <= 6) continue;
    EXPECT_EQ(edges[1].from, 6);
    const Pose2 round = keys[6].T_front_robot * edges[1].T_from_to;
    EXPECT_LT(between(round, keys[k].T_front_robot).vector().norm(), 1e-12);
    // Along the corridor all is told from there, across it and of the heading from the beginning.
    const double theta = keys[k].T_front_robot.theta;
    const Vec3 along = turned(heading - theta, Mat3::Identity()) *
                       Vec3(std::cos(heading - theta), std::sin(heading - theta), 0);
    const double told = along.dot(keys[k].match_information * along);
    EXPECT_LT(along.dot(edges[0].information * along), 1e-3 * told);
    EXPECT_NEAR(along.dot(edges[1].information * along), told, 1e-3 * told);
    EXPECT_LT(edges[1].information(2, 2), 1e-6);
    EXPECT_NEAR(edges[0].information(2, 2), keys[k].match_information(2, 2), 1e-6 * told);
  }
}

TEST(ChainGraph, AgreesWithTheFrontEndAndHangsTogether) {
  // Two local maps that take over from each other, and one after a break.
  KeyScans keys = chain(30);
  for (std::size_t k = 0; k < 30; ++k) {
    keys[k].local_map = k < 12 ? 0 : k < 20 ? 6 : 20;
    keys[k].T_map_robot = keys[k].T_front_robot;
  }
  const ChainGraph chain = chain_graph(keys);
  EXPECT_EQ(chain.local_maps, (std::vector<std::size_t>{0, 6, 20}));
  ASSERT_EQ(chain.graph.poses.size(), 33U);
  for (std::size_t m = 0; m < 3; ++m)
    EXPECT_EQ(chain.graph.poses[30 + m], keys[chain.local_maps[m]].T_map_robot);
  EXPECT_NO_THROW(graph::check(chain.graph));
  EXPECT_LT(graph::chi2(chain.graph), 1e-9);
  std::vector<int> edges_of(33, 0);
  for (const graph::Edge& e : chain.graph.edges) {
    ++edges_of[static_cast<std::size_t>(e.from)], ++edges_of[static_cast<std::size_t>(e.to)];
    EXPECT_FALSE(e.robust);
  }
  for (std::size_t k = 1; k < 29; ++k) EXPECT_EQ(edges_of[k], 3) << k;  // two motions and its map
  EXPECT_EQ(edges_of[30], 12 + 1);  // its key scans, and the map that took over
  EXPECT_EQ(edges_of[31], 8 + 1);
  EXPECT_EQ(edges_of[32], 10);
}

// Information of the chain.

/// The slow twin: derivatives of the relative pose by every error on the way, numerically. Without
/// the local map's own drift.
Mat3 slow_information(const KeyScans& keys, std::size_t from, std::size_t to) {
  const auto derivative = [&](auto&& relative) {
    Mat3 j;
    for (int c = 0; c < 3; ++c) {
      const Vec3 e = 1e-6 * Vec3::Unit(c);
      j.col(c) = log(between(relative(Vec3::Zero()), relative(e))) / 1e-6;
    }
    return j;
  };
  Mat3 moved = Mat3::Zero(), matched = Mat3::Zero();
  for (std::size_t k = from + 1; k <= to; ++k) {
    const Mat3 j = derivative([&](const Vec3& e) {
      Pose2 T;
      for (std::size_t i = from + 1; i <= to; ++i) {
        T = T * keys[i].T_previous_predicted;
        if (i == k) T = T * exp(e);
      }
      return T;
    });
    moved += j * keys[k].motion_information.inverse() * j.transpose();
  }
  for (const std::size_t end : {from, to}) {
    const Mat3 j = derivative([&](const Vec3& e) {
      return between(end == from ? keys[from].T_front_robot * exp(e) : keys[from].T_front_robot,
                     end == to ? keys[to].T_front_robot * exp(e) : keys[to].T_front_robot);
    });
    matched += j * keys[end].match_information.inverse() * j.transpose();
  }
  return matched.inverse() + moved.inverse();
}

TEST(ChainGraph, ThroughAnEmptyCorridorOnlyTheMotionCountsTheWay) {
  // Five local maps deep in it: their taking over from each other tells nothing along it.
  Ground ground;
  ground.match = Vec3(0, 3e5, 1e6).asDiagonal();
  ground.turn = 0;
  KeyScans keys = chain(50, ground);
  for (std::size_t k = 0; k < 50; ++k) {
    keys[k].local_map = k < 20 ? 0 : k / 10 * 10 - 10;
    keys[k].T_map_robot = keys[k].T_front_robot;
  }
  const graph::Marginals marginals(chain_graph(keys).graph);
  const double motion = 1 / keys[1].motion_information(0, 0);
  for (const int k : {15, 30, 49}) {
    const Mat3& covariance = marginals.covariance(k);
    EXPECT_NEAR(covariance(0, 0), k * motion, 0.15 * k * motion) << k;
    EXPECT_LT(covariance(1, 1), 0.05 * covariance(0, 0));
  }
}

TEST(ChainInformation, EqualsItsSlowTwin) {
  Ground ground;
  ground.match << 3600, 400, 300, 400, 2400, -200, 300, -200, 8000;  // drift is hardly more
  ground.variance = Vec3(4e-3, 1e-3, 2e-3);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const KeyScans keys = chain(12, ground, 0, seed);
    for (const std::size_t to : {3U, 4U, 8U, 11U}) {
      const Mat3 fast = chain_information(keys, 2, to), slow = slow_information(keys, 2, to);
      EXPECT_LT((fast - slow).norm(), 0.015 * slow.norm()) << fast << "\n against\n" << slow;
    }
  }
}

TEST(ChainInformation, IsSymmetricPositiveDefiniteAndFinite) {
  for (const double match : {0.0, 1.0, 1e4, 1e9})
    for (const double variance : {0.0, 1e-6, 1.0, 1e6}) {
      Ground ground;
      ground.match = match * Mat3::Identity();
      ground.variance = Vec3::Constant(variance);
      const KeyScans keys = chain(40, ground);
      for (const std::size_t to : {1U, 5U, 39U}) {
        const Mat3 information = chain_information(keys, 0, to);
        ASSERT_TRUE(information.allFinite());
        EXPECT_EQ(information, information.transpose());
        EXPECT_GT(least(information), 0) << match << ' ' << variance << ' ' << to;
        EXPECT_LT(information.norm(), 3e7);  // a millimetre twice over
      }
    }
}

TEST(ChainInformation, ShrinksWithTheWay) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const KeyScans keys = chain(60, {}, 0, seed);
    Mat3 before = chain_information(keys, 0, 1);
    for (std::size_t to = 2; to < 60; ++to) {
      const Mat3 now = chain_information(keys, 0, to);
      EXPECT_LT(now.determinant(), before.determinant()) << to;
      before = now;
    }
  }
}

TEST(ChainInformation, AWeakStepWeakensWhatItLiesOn) {
  const KeyScans sure = chain(12), broken = chain(12, {}, 6);
  for (std::size_t from = 0; from < 11; ++from)
    for (std::size_t to = from + 1; to < 12; ++to) {
      const Mat3 before = chain_information(sure, from, to),
                 after = chain_information(broken, from, to);
      const bool on = (from < 6 && to >= 6) || from == 6;
      if (!on) {
        EXPECT_LT((before - after).norm(), 1e-9 * before.norm()) << from << ' ' << to;
      }
      if (on) {
        EXPECT_GT(least(before - after), 0) << from << ' ' << to;
      }
      if (from < 6 && to >= 6) {
        EXPECT_LT(least(after), 50) << from << ' ' << to;
      }
    }
}

TEST(ChainInformation, AlongACorridorOnlyTheMotionHolds) {
  // The walls say where the robot is across and how it is turned, not how far along.
  for (const double heading : {0.0, 0.7, -2.5}) {
    Ground ground;
    ground.match = turned(heading, Vec3(0, 3e5, 1e6).asDiagonal());
    ground.variance = Vec3(4e-4, 4e-4, 1e-4);
    ground.turn = 0;
    ground.heading = heading;
    const KeyScans keys = chain(30, ground);
    for (const std::size_t to : {1U, 10U, 29U}) {
      const Mat3 information = chain_information(keys, 0, to);
      const double along = 1 / (static_cast<double>(to) * (4e-4 + 1e-6));
      EXPECT_NEAR(information(0, 0), along, 0.01 * along) << to;
      EXPECT_GT(information(1, 1), 4 * information(0, 0)) << to;
      EXPECT_LT(std::abs(information(0, 1)), 1e-3 * information(0, 0));
    }
  }
}

}  // namespace
}  // namespace majak::slam
