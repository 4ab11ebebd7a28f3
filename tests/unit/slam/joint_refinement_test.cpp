// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/joint_refinement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "majak/slam/chain.hpp"
#include "majak/slam/range_bias.hpp"
#include "tests/support/ascii_room.hpp"

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

/// n key scans along an arc from 'a', at poses that are off by up to `error` m and rad * 3 m.
struct Walk {
  KeyScans keys;
  std::vector<Pose2> truth;
};
// Of a chain that is off by centimetres, and says so.
constexpr double kUnsure = 10;
Walk walk(int n, double error, double noise = 0, double step = 0.3, double sure = 1e4) {
  Walk w;
  RandomStream r(5);
  for (int i = 0; i < n; ++i) {
    w.truth.push_back(room().pose('a', 0.2) * exp(Vec3(step * i, 0, -0.06 * i)));
    Laser laser = all_around(361);
    laser.noise = noise;
    laser.seed = i + 1;
    KeyScan key;
    key.scan = static_cast<std::size_t>(i);
    key.points = match::scan_points(room().scan(w.truth.back(), laser), {}, true);
    key.match_information = key.motion_information = Vec3::Constant(sure).asDiagonal();
    const Pose2 off{r.uniform(-error, error), r.uniform(-error, error),
                    r.uniform(-error, error) / 3};
    key.T_map_robot = i == 0 ? w.truth.back() : w.truth.back() * off;
    key.T_front_robot = key.T_map_robot;
    if (i > 0) key.T_previous_predicted = between(w.keys.back().T_front_robot, key.T_front_robot);
    w.keys.push_back(key);
  }
  return w;
}

using Partners = std::vector<std::vector<std::size_t>>;

/// Each with up to `count` key scans right before it.
Partners neighbours(const KeyScans& keys, std::size_t count = 5) {
  Partners partners(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (std::size_t j = i > count ? i - count : 0; j < i; ++j) partners[i].push_back(j);
  return partners;
}

/// m, and rad at 3 m.
double worst_error(const KeyScans& keys, const std::vector<Pose2>& truth) {
  double worst = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Pose2 off =
        between(between(truth[0], truth[i]), between(keys[0].T_map_robot, keys[i].T_map_robot));
    worst = std::max(worst, off.translation().norm() + 3 * std::abs(off.theta));
  }
  return worst;
}

TEST(JointRefinement, PerturbedPosesReturnToTheTruth) {
  Walk w = walk(10, 0.04, 0, 0.3, kUnsure);
  ASSERT_GT(worst_error(w.keys, w.truth), 0.03);
  JointRefinementOptions options;
  options.rounds = 4;
  refine_jointly(w.keys, neighbours(w.keys), {}, options, {});
  EXPECT_LT(worst_error(w.keys, w.truth), 0.002);
}

TEST(JointRefinement, ThroughNoise) {
  Walk w = walk(10, 0.04, 0.01, 0.3, kUnsure);
  refine_jointly(w.keys, neighbours(w.keys), {}, {}, {});
  EXPECT_LT(worst_error(w.keys, w.truth), 0.008);
}

TEST(JointRefinement, TheTruthStays) {
  Walk w = walk(10, 0);
  refine_jointly(w.keys, neighbours(w.keys), {}, {}, {});
  EXPECT_LT(worst_error(w.keys, w.truth), 0.002);
}

TEST(JointRefinement, RepeatedItDoesNotMove) {
  Walk w = walk(8, 0.04, 0.005);
  JointRefinementOptions options;
  options.rounds = 6;
  refine_jointly(w.keys, neighbours(w.keys), {}, options, {});
  const KeyScans before = w.keys;
  options.rounds = 2;
  refine_jointly(w.keys, neighbours(w.keys), {}, options, {});
  for (std::size_t i = 0; i < w.keys.size(); ++i)
    EXPECT_LT(between(before[i].T_map_robot, w.keys[i].T_map_robot).translation().norm(), 5e-4)
        << i;
}

TEST(JointRefinement, ResidualsShrinkFromRoundToRound) {
  Walk w = walk(10, 0.04);
  JointRefinementOptions options;
  options.rounds = 4;
  const JointRefinement result = refine_jointly(w.keys, neighbours(w.keys), {}, options, {});
  ASSERT_EQ(result.rms.size(), 4U);
  EXPECT_LT(result.rms[1], 0.5 * result.rms[0]);
  EXPECT_LE(result.rms[3], result.rms[1]);
  EXPECT_LT(result.rms[3], 0.004);
}

// The twin: a dense Gauss-Newton with numeric derivatives over all poses but the first.
std::vector<Pose2> dense_solve(std::vector<Pose2> poses, const std::vector<graph::Edge>& edges) {
  const auto residual = [](const std::vector<Pose2>& p, const graph::Edge& e) {
    return Vec3(log(between(e.T_from_to, between(p[static_cast<std::size_t>(e.from)],
                                                 p[static_cast<std::size_t>(e.to)]))));
  };
  const auto n = static_cast<Eigen::Index>(3 * poses.size());
  for (int round = 0; round < 15; ++round) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (const graph::Edge& e : edges) {
      const Vec3 r = residual(poses, e);
      Eigen::MatrixXd j = Eigen::MatrixXd::Zero(3, n);
      for (const int pose : {e.from, e.to})
        for (int k = 0; k < 3; ++k) {
          std::vector<Pose2> moved = poses;
          Pose2& p = moved[static_cast<std::size_t>(pose)];
          (k == 0 ? p.x : k == 1 ? p.y : p.theta) += 1e-6;
          j.col(3 * pose + k) = (residual(moved, e) - r) / 1e-6;
        }
      h += j.transpose() * e.information * j;
      b += j.transpose() * e.information * r;
    }
    h.diagonal().head<3>().array() += 1e15;  // the first pose is the map's
    const Eigen::VectorXd step = -h.ldlt().solve(b);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      poses[i] = {poses[i].x + step[at], poses[i].y + step[at + 1],
                  wrap_angle(poses[i].theta + step[at + 2])};
    }
  }
  return poses;
}

TEST(JointRefinement, SixScansEqualADenseSolve) {
  Walk w = walk(6, 0.04, 0.005);
  const JointRefinement result = refine_jointly(w.keys, neighbours(w.keys), {}, {}, {});
  const graph::PoseGraph& graph = result.chain.graph;
  const auto poses = dense_solve(graph.poses, graph.edges);
  for (std::size_t i = 0; i < w.keys.size(); ++i) {
    const Pose2 off = between(poses[i], w.keys[i].T_map_robot);
    EXPECT_LT(off.translation().norm(), 1e-4) << i;
    EXPECT_LT(std::abs(off.theta), 1e-4) << i;
  }
}

TEST(JointRefinement, SameBytesForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    Walk w = walk(14, 0.04, 0.01);
    refine_jointly(w.keys, neighbours(w.keys), {}, {}, {threads});
    std::vector<Pose2> poses;
    for (const KeyScan& key : w.keys) poses.push_back(key.T_map_robot);
    return poses;
  };
  const auto one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(8), one);
}

TEST(JointRefinement, PairsThePartnersAndNoOthers) {
  // There and back again: the second half sees what the first half saw.
  Walk out = walk(24, 0.01, 0, 0.1);
  for (std::size_t i = 24; i-- > 0;) {
    out.keys.push_back(out.keys[i]);
    out.truth.push_back(out.truth[i]);
    if (i < 23)
      out.keys.back().T_previous_predicted = out.keys[i + 1].T_previous_predicted.inverse();
  }
  Partners partners(48);
  for (std::size_t i = 30; i < 48; ++i) partners[i] = {47 - i, 50 - i};
  for (const bool paired : {false, true}) {
    KeyScans keys = out.keys;
    const JointRefinement result =
        refine_jointly(keys, paired ? partners : Partners(48), {}, {}, {});
    std::set<std::pair<int, int>> expected, found;
    if (paired)
      for (int k = 30; k < 48; ++k) expected.insert({47 - k, k}), expected.insert({50 - k, k});
    for (const graph::Edge& edge : result.pairs) {
      EXPECT_TRUE(found.insert({edge.from, edge.to}).second) << edge.from << " - " << edge.to;
      const Pose2 truly = between(out.truth[static_cast<std::size_t>(edge.from)],
                                  out.truth[static_cast<std::size_t>(edge.to)]);
      EXPECT_LT(between(truly, edge.T_from_to).translation().norm(), 0.005);
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(result.chain.graph.edges.size(),
              chain_graph(keys).graph.edges.size() + expected.size());
  }
}

TEST(JointRefinement, PairsTellNoMoreThanOneOfWhatTheLasersErrorShifts) {
  // However many returns: a hundred pairs together know such a direction as well as one shift does.
  const Walk w = walk(12, 0);
  KeyScans keys = w.keys;
  const JointRefinement result = refine_jointly(keys, neighbours(keys), {}, {}, {});
  ASSERT_GT(result.pairs.size(), 30U);
  double most = 0;
  for (const graph::Edge& edge : result.pairs) {
    const KeyScan &target = w.keys[static_cast<std::size_t>(edge.from)],
                  &source = w.keys[static_cast<std::size_t>(edge.to)];
    const auto shift = RangeBias::shift(target, laser_view(target), source, 0.075);
    for (int c = 0; c < RangeBias::kCount; ++c)
      most = std::max(most, shift.col(c).dot(edge.information * shift.col(c)));
  }
  EXPECT_LT(most, 0.011);  // poses and gate are not quite those of the last round
  EXPECT_GT(most, 0.005);
}

TEST(JointRefinement, TheTwoSidesOfAThinWallAreNotPaired) {
  // Both see the same three walls; between them a partition of 8 cm, each its own side of it.
  const auto look = [](double partition, float facing) {
    match::ScanPoints points;
    const auto add = [&](double x, double y, float nx, float ny) {
      points.x.push_back(static_cast<float>(x)), points.y.push_back(static_cast<float>(y));
      points.nx.push_back(nx), points.ny.push_back(ny), points.target.push_back(1);
    };
    for (double t = -2; t <= 2; t += 0.06) {
      add(-4, t, 1, 0), add(4, t, -1, 0), add(t, -4, 0, 1);
      for (const double x : {3 * t / 2, 3 * t / 2 + 0.03}) add(x, partition, 0, facing);
    }
    return points;
  };
  KeyScans keys(2);
  keys[0].points = look(2.00, -1), keys[1].points = look(2.08, 1);
  for (KeyScan& key : keys)
    key.match_information = key.motion_information = 1e-3 * Mat3::Identity();
  const JointRefinement result = refine_jointly(keys, {{}, {0}}, {}, {}, {});
  EXPECT_LT(log(keys[1].T_map_robot).norm(), 1e-3);
  EXPECT_LT(result.rms.back(), 1e-3);
}

TEST(JointRefinement, EveryKeyScanHangsOnTheOneBefore) {
  Walk w = walk(5, 0.02);
  w.keys[4].points = {};  // sees nothing: only the front end's step holds it
  w.keys[4].match_information = 1e-3 * Mat3::Identity();
  const JointRefinement result = refine_jointly(w.keys, neighbours(w.keys), {}, {}, {});
  const auto& edges = result.chain.graph.edges;
  const Pose2 step = between(w.keys[3].T_map_robot, w.keys[4].T_map_robot);
  EXPECT_LT(between(w.keys[4].T_previous_predicted, step).translation().norm(), 1e-3);
  for (int i = 1; i < 5; ++i)
    EXPECT_TRUE(std::any_of(edges.begin(), edges.end(), [i](const graph::Edge& e) {
      return e.from == i - 1 && e.to == i;
    })) << i;
}

// What the front end found, with nothing to hold it against.

/// A way without points: the front end's poses, and motions that are off them by `wheels` m and
/// rad. Local maps as the front end has them: of 20 to 40 key scans.
KeyScans open_chain(std::uint64_t seed, int n, double wheels) {
  RandomStream r(seed);
  KeyScans keys(static_cast<std::size_t>(n));
  for (std::size_t k = 0; k < keys.size(); ++k) {
    KeyScan& key = keys[k];
    key.local_map = k <= 40 ? 0 : (k - 1) / 20 * 20 - 20;
    key.match_information = Vec3(1e5, 1e5, 5e5).asDiagonal();
    key.motion_information = Vec3(1e3, 1e3, 1e3).asDiagonal();
    if (k > 0) {
      const Pose2 step = exp(Vec3(0.25, r.uniform(-0.05, 0.05), r.uniform(-0.3, 0.3)));
      key.T_front_robot = keys[k - 1].T_front_robot * step;
      key.T_previous_predicted =
          step * Pose2{wheels * r.normal(), wheels * r.normal(), wheels * r.normal()};
    }
    key.T_map_robot = key.T_front_robot;
  }
  return keys;
}

/// Worst distance in m off the front end's poses.
double worst_off_front(const KeyScans& keys) {
  double worst = 0;
  for (const KeyScan& key : keys) {
    const Pose2 front = between(keys[0].T_front_robot, key.T_front_robot);
    const Pose2 map = between(keys[0].T_map_robot, key.T_map_robot);
    worst = std::max(worst, between(front, map).translation().norm());
  }
  return worst;
}

TEST(JointRefinement, AnOpenChainThatAgreesIsTheFrontEnds) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    KeyScans keys = open_chain(seed, 200, 0);
    RandomStream r(seed, 1);
    for (std::size_t k = 1; k < keys.size(); ++k)  // wherever it starts
      keys[k].T_map_robot = keys[k].T_map_robot * Pose2{r.uniform(-0.1, 0.1), r.uniform(-0.1, 0.1),
                                                        r.uniform(-0.02, 0.02)};
    ASSERT_GT(worst_off_front(keys), 0.1);
    const JointRefinement result = refine_jointly(keys, Partners(keys.size()), {}, {}, {});
    EXPECT_LT(worst_off_front(keys), 1e-3) << seed;
    EXPECT_TRUE(result.pairs.empty());
    EXPECT_EQ(result.rms.back(), 0);
  }
}

TEST(JointRefinement, AClosureHoldsWhereNoPairMeets) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    KeyScans keys = open_chain(seed, 200, 0);
    const Pose2 T_first_last = between(keys[0].T_front_robot, keys[199].T_front_robot);
    const Pose2 closed = T_first_last * Pose2{0.04, -0.03, 0};
    const graph::Edge closure{0, 199, closed, Vec3(1e5, 1e5, 1e6).asDiagonal(), true};
    refine_jointly(keys, Partners(keys.size()), {closure}, {}, {});
    const Pose2 now = between(keys[0].T_map_robot, keys[199].T_map_robot);
    EXPECT_LT(between(closed, now).translation().norm(), 0.01) << seed;
  }
}

TEST(JointRefinement, WheelsDoNotBendAnOpenChain) {
  // Each motion is off by 3 cm and 2 degrees; 50 m of them alone would lead metres astray.
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    KeyScans keys = open_chain(seed, 200, 0.03);
    KeyScans wheels = keys;
    for (std::size_t k = 1; k < keys.size(); ++k)
      wheels[k].T_map_robot = wheels[k - 1].T_map_robot * keys[k].T_previous_predicted;
    ASSERT_GT(worst_off_front(wheels), 1.0) << seed;
    refine_jointly(keys, Partners(keys.size()), {}, {}, {});
    EXPECT_LT(worst_off_front(keys), 0.10) << seed;
  }
}

TEST(JointRefinement, OneOrNoneIsLeftAlone) {
  KeyScans none;
  EXPECT_EQ(refine_jointly(none, {}, {}, {}, {}).rms.back(), 0);
  Walk w = walk(1, 0);
  EXPECT_EQ(refine_jointly(w.keys, neighbours(w.keys), {}, {}, {}).rms.back(), 0);
  EXPECT_EQ(w.keys[0].T_map_robot, w.truth[0]);
  Walk two = walk(3, 0.02);
  const KeyScans before = two.keys;
  refine_jointly(two.keys, neighbours(two.keys), {}, {.rounds = 0}, {});
  EXPECT_EQ(two.keys[1].T_map_robot, before[1].T_map_robot);
}

}  // namespace
}  // namespace majak::slam
