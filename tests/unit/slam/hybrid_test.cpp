// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/hybrid.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/chi_square.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/graph/optimize.hpp"
#include "majak/slam/incremental_ml.hpp"
#include "tests/unit/slam/simulated.hpp"

namespace majak::slam {
namespace {

sim::SimulationOptions worn_robot(int seed) {
  sim::SimulationOptions o;
  o.seed = seed;
  o.laser.max_range = 8;
  o.robot.left_scale = 1.02;
  o.robot.slip = 0.02;
  return o;
}

/// A lap and a quarter of a bare ring.
std::vector<Event> ring_run(double length, double width, int seed) {
  const sim::World world(sim::bare_ring(length, width));
  return sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), worn_robot(seed));
}

/// 120 m round; matching alone leaves a gap of 0.2 m.
const std::vector<Event>& the_ring() {
  static const std::vector<Event> events = ring_run(40, 24, 6);
  return events;
}

Mapping hybrid(const std::vector<Event>& events, const HybridOptions& options = {}, int threads = 1,
               bool odometry = true) {
  ScanChainOptions chain;
  chain.use_odometry = odometry;
  Hybrid hybrid(chain, options, {threads});
  for (const Event& event : events) hybrid.add(event);
  return hybrid.finish();
}

/// The gap where the robot comes back to its start.
double gap(const Site& site) {
  std::map<Time, Pose2> truth;
  for (const Truth& t : site.truth) truth[t.time] = t.T_world_robot;
  const auto at = [&](std::size_t i) { return truth.at(site.scans[i].scan.time); };
  const auto away = [&](std::size_t i) {
    return (at(i).translation() - at(0).translation()).norm();
  };
  std::size_t lap = site.scans.size() / 2;
  for (std::size_t i = lap; i < site.scans.size(); ++i)
    if (away(i) < away(lap)) lap = i;
  const auto pose = [&](std::size_t i) { return site.scans[i].estimate.T_map_robot; };
  return between(between(at(0), at(lap)), between(pose(0), pose(lap))).translation().norm();
}

struct Chain {
  std::vector<Pose2> poses{Pose2{}};
  std::vector<Mat3> covariances{Mat3::Zero()};
};
Chain random_chain(std::uint64_t seed, int steps) {
  RandomStream r(seed);
  Chain chain;
  for (int k = 0; k < steps; ++k) {
    chain.poses.push_back(chain.poses.back() *
                          Pose2{r.uniform(0.1, 0.5), 0.1 * r.normal(), 0.3 * r.normal()});
    Mat3 root;
    for (int i = 0; i < 9; ++i) root(i / 3, i % 3) = 0.01 * r.normal();
    chain.covariances.push_back(root * root.transpose() + 1e-6 * Mat3::Identity());
  }
  return chain;
}

TEST(ShareOut, HoldsTheFirstAndMovesTheLast) {
  const Chain chain = random_chain(1, 30);
  const Pose2 end = chain.poses.back() * Pose2{0.7, -0.4, 0.2};
  const auto moved = share_out(chain.poses, chain.covariances, end);
  ASSERT_EQ(moved.size(), chain.poses.size());
  EXPECT_LT(between(moved.front(), chain.poses.front()).vector().norm(), 1e-12);
  EXPECT_EQ(moved.back(), end);
  const auto still = share_out(chain.poses, chain.covariances, chain.poses.back());
  for (std::size_t k = 0; k < still.size(); ++k)
    EXPECT_LT(between(still[k], chain.poses[k]).vector().norm(), 1e-12);
}

TEST(ShareOut, IsTheOptimumOfTheChainsGraph) {
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    const Chain chain = random_chain(seed, 20);
    const Pose2 end = chain.poses.back() * Pose2{2e-4, -1e-4, 1e-4};
    const auto moved = share_out(chain.poses, chain.covariances, end);
    graph::PoseGraph graph;
    graph.poses = chain.poses;
    const int n = static_cast<int>(chain.poses.size());
    for (int k = 1; k < n; ++k) {
      const Mat3 information = chain.covariances[k].inverse();
      graph.edges.push_back({k - 1, k, between(chain.poses[k - 1], chain.poses[k]),
                             0.5 * (information + information.transpose()), false});
    }
    graph.edges.push_back({0, n - 1, between(chain.poses[0], end), 1e12 * Mat3::Identity(), false});
    graph::Optimizer({.start = graph::Start::given}).optimize(graph);
    for (int k = 0; k < n; ++k)
      EXPECT_LT(between(graph.poses[k], moved[k]).vector().norm(), 1e-6) << seed << " " << k;
  }
}

TEST(ShareOut, CertainStepsMoveAsAWhole) {
  Chain chain = random_chain(3, 20);
  for (int k = 6; k <= 12; ++k) chain.covariances[k].setZero();
  const auto moved =
      share_out(chain.poses, chain.covariances, chain.poses.back() * Pose2{0.3, 0.2, 0.05});
  for (int k = 6; k <= 12; ++k)
    EXPECT_LT(between(between(moved[k - 1], moved[k]), between(chain.poses[k - 1], chain.poses[k]))
                  .vector()
                  .norm(),
              1e-12);
  EXPECT_GT(between(moved[5], chain.poses[5]).vector().norm(), 1e-3);
}

TEST(Drift, WheelsTellWhatTheMatchLeavesOpen) {
  KeyScan key;
  key.match_information.diagonal() << 1e-3, 2.5e5, 1e6;  // a bare corridor along x
  key.motion_information.diagonal() << 1e4, 1e4, 1e4;
  const Drift drift = drift_to(key, {.match_share = 0.25});
  EXPECT_NEAR(drift.covariance(0, 0), 1e-4, 1e-9);
  EXPECT_NEAR(drift.covariance(1, 1), 1 / (1e4 + 1e6), 1e-12);
  EXPECT_NEAR(drift.by_motion(0, 0), 1, 1e-5);
  EXPECT_NEAR(drift.by_motion(1, 1), 1e4 / (1e4 + 1e6), 1e-9);
  key.weak_step = true;
  EXPECT_NEAR(drift_to(key, {.weak_way = 0.1}).covariance(1, 1), 0.01 + 1 / 1.01e6, 1e-9);
}

// Up to the first closure: the true pose in the ellipse that the particles fill.
TEST(Hybrid, ParticlesCoverTheError) {
  int inside = 0, all = 0;
  double last = 0;
  for (const int seed : {6, 7}) {
    const auto events = ring_run(40, 24, seed);
    const auto truth = truth_of(events);
    Hybrid hybrid({}, {}, {1});
    std::optional<Pose2> T_map_world;
    for (const Event& event : events) {
      const auto estimate = hybrid.add(event);
      if (!estimate || !hybrid.corrections().empty()) continue;
      const Pose2 world = truth.at(estimate->time);
      if (!T_map_world) T_map_world = estimate->T_map_robot * world.inverse();
      const auto& particles = hybrid.particles();
      Vec2 mean = Vec2::Zero();
      for (const Pose2& p : particles) mean += p.translation() / double(particles.size());
      Eigen::Matrix2d spread = 1e-4 * Eigen::Matrix2d::Identity();  // key scans lie 0.25 m apart
      for (const Pose2& p : particles) {
        const Vec2 d = p.translation() - mean;
        spread += d * d.transpose() / double(particles.size());
      }
      // The error of the estimate, which is of the newest scan, against the spread at its key scan.
      const Vec2 off = estimate->T_map_robot.translation() - (*T_map_world * world).translation();
      inside += off.dot(spread.inverse() * off) < chi_square_quantile(0.95, 2);
      ++all;
      last = std::sqrt(spread.trace());
    }
  }
  EXPECT_GT(inside, 0.9 * all);
  EXPECT_GT(last, 0.2);
  EXPECT_LT(last, 2);
}

TEST(Hybrid, ClosesTheRingThatMatchingAloneLeavesOpen) {
  IncrementalMl alone({}, {}, {1});
  for (const Event& event : the_ring()) alone.add(event);
  EXPECT_GT(gap(alone.finish().site), 0.1);
  const Mapping mapping = hybrid(the_ring());
  EXPECT_LT(gap(mapping.site), 0.02);
  ASSERT_FALSE(mapping.corrections.empty());
  const LoopCorrection& c = mapping.corrections.front();
  EXPECT_NEAR(c.way, 119, 6);
  EXPECT_GT(c.moved, 0.1);
  EXPECT_GT(c.touched, 350U);
  EXPECT_LT(c.since, 200U);
  for (const LoopCorrection& each : mapping.corrections) EXPECT_FALSE(each.undone);
  EXPECT_FALSE(mapping.posterior);
  EXPECT_GT(mapping.belief_bytes, 0U);
  EXPECT_EQ(mapping.site.report.entries().at("loops corrected").count,
            static_cast<std::int64_t>(mapping.corrections.size()));
}

// On the second lap, half way along a bare side: it looks the same 2.5 m ahead, until the corner
// comes.
TEST(Hybrid, TakesAWrongClosureBack) {
  const Mapping right = hybrid(the_ring());
  HybridOptions options;
  options.forced = {.at = 438, .onto = 52};
  const Mapping mapping = hybrid(the_ring(), options);
  const auto wrong = std::find_if(mapping.corrections.begin(), mapping.corrections.end(),
                                  [](const LoopCorrection& c) { return c.undone.has_value(); });
  ASSERT_NE(wrong, mapping.corrections.end());
  EXPECT_GT(wrong->moved, 1);
  EXPECT_GT(*wrong->undone, wrong->scan);
  for (const LoopCorrection& c : mapping.corrections)
    EXPECT_EQ(c.undone.has_value(), &c == &*wrong);
  EXPECT_LT(gap(mapping.site), 0.02);
  EXPECT_LT(error_of(mapping.site).rms, error_of(right.site).rms + 0.05);
}

// As much as may be done per scan: the rest follows, and the map is the same in the end.
TEST(Hybrid, BoundedLatencyEndsWithTheSameMap) {
  const Mapping at_once = hybrid(the_ring());
  HybridOptions options;
  options.latency_keys = 10;
  Hybrid bounded({}, options, {1});
  std::size_t most = 0;
  for (const Event& event : the_ring()) {
    bounded.add(event);
    most = std::max(most, bounded.touched());
  }
  EXPECT_EQ(most, 10U);
  const Mapping mapping = bounded.finish();
  ASSERT_EQ(mapping.corrections.size(), at_once.corrections.size());
  EXPECT_EQ(mapping.corrections[0].scan, at_once.corrections[0].scan);
  EXPECT_LT(gap(mapping.site), 0.02);
  for (std::size_t i = 0; i < mapping.site.scans.size(); ++i)
    ASSERT_LT(between(mapping.site.scans[i].estimate.T_map_robot,
                      at_once.site.scans[i].estimate.T_map_robot)
                  .translation()
                  .norm(),
              0.03)
        << i;
}

TEST(Hybrid, SameSeedSameBytesWhateverTheThreads) {
  const Mapping a = hybrid(the_ring()), b = hybrid(the_ring(), {}, 2);
  for (std::size_t i = 0; i < a.site.scans.size(); ++i)
    ASSERT_EQ(a.site.scans[i].estimate.T_map_robot, b.site.scans[i].estimate.T_map_robot);
  HybridOptions other;
  other.seed = 2;
  const Mapping c = hybrid(the_ring(), other);
  EXPECT_NE(a.site.scans.back().estimate.T_map_robot, c.site.scans.back().estimate.T_map_robot);
  EXPECT_LT(gap(c.site), 0.02);
}

TEST(Hybrid, WithoutALoopItSaysSo) {
  std::vector<Event> events = the_ring();
  events.resize(events.size() / 3);
  const Mapping mapping = hybrid(events);
  EXPECT_TRUE(mapping.corrections.empty());
  EXPECT_EQ(mapping.site.report.entries().count(
                "no loop found: hybrid is incremental maximum likelihood here"),
            1U);
}

TEST(Hybrid, OneScanIsAMap) {
  std::vector<Event> events;
  for (const Event& event : the_ring()) {
    events.push_back(event);
    if (std::holds_alternative<Scan>(event)) break;
  }
  EXPECT_EQ(hybrid(events).site.scans.size(), 1U);
  EXPECT_THROW(hybrid({}), Error);
}

TEST(Hybrid, WorksWithoutOdometry) {
  const Mapping mapping = hybrid(building_run(), {}, 1, false);
  EXPECT_FALSE(mapping.site.used_odometry);
  EXPECT_LT(error_of(mapping.site).rms, 0.1);
}

}  // namespace
}  // namespace majak::slam
