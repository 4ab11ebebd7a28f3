// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/expectation_maximization.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <variant>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/slam/hidden_poses.hpp"
#include "tests/unit/slam/simulated.hpp"

namespace majak::slam {
namespace {

/// Four pieces of an L-shaped wall with few hypotheses each.
struct Tiny {
  std::vector<Piece> pieces;
  HiddenPoses hidden;
};
Tiny tiny(std::uint64_t seed) {
  RandomStream r(seed);
  Tiny t;
  for (std::size_t p = 0; p < 4; ++p) {
    Piece piece;
    for (int i = 0; i < 12; ++i) {
      piece.x.push_back(static_cast<float>(r.uniform(0, 2)));
      piece.y.push_back(i % 3 == 0 ? static_cast<float>(r.uniform(0, 1)) : 1.0F);
    }
    piece.hits = 8, piece.miss_weight = 1.5;
    t.pieces.push_back(piece);
    std::vector<Pose2> support;
    for (std::size_t s = 0; s < (p == 0 ? 1 : 4); ++s)
      support.push_back({0.3 * r.normal(), 0.3 * r.normal(), 0.2 * r.normal()});
    t.hidden.supports.push_back(support);
  }
  for (std::size_t p = 0; p < 3; ++p)
    t.hidden.steps.push_back(transitions(t.hidden.supports[p], t.hidden.supports[p + 1], {},
                                         Vec3(0.1, 0.1, 0.05).asDiagonal()));
  return t;
}

double probability(const Transitions& step, std::size_t s, std::size_t t) {
  for (std::uint32_t k = step.row[s]; k < step.row[s + 1]; ++k)
    if (step.to[k] == t) return static_cast<double>(step.probability[k]);
  return 0;
}

/// The same by adding up all paths one by one.
HiddenPosterior all_paths(const HiddenPoses& hidden, const PerHypothesis& log_likelihood) {
  HiddenPosterior posterior;
  for (const auto& support : hidden.supports)
    posterior.probability.emplace_back(support.size(), 0.0);
  std::vector<std::size_t> path(hidden.supports.size(), 0);
  double evidence = 0;
  for (;;) {
    double p =
        std::exp(log_likelihood[0][path[0]]) / static_cast<double>(hidden.supports[0].size());
    for (std::size_t i = 1; i < path.size(); ++i)
      p *= probability(hidden.steps[i - 1], path[i - 1], path[i]) *
           std::exp(log_likelihood[i][path[i]]);
    for (std::size_t i = 0; i < path.size(); ++i) posterior.probability[i][path[i]] += p;
    evidence += p;
    std::size_t i = 0;
    while (i < path.size() && ++path[i] == hidden.supports[i].size()) path[i++] = 0;
    if (i == path.size()) break;
  }
  for (auto& of_pose : posterior.probability)
    for (double& p : of_pose) p /= evidence;
  posterior.log_evidence = std::log(evidence);
  return posterior;
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

constexpr HitMapOptions kCells{.cell = 0.25};

TEST(HiddenPoses, RowsOfTransitionsSumToOne) {
  const Tiny t = tiny(1);
  for (const Transitions& step : t.hidden.steps)
    for (std::size_t s = 0; s + 1 < step.row.size(); ++s) {
      double row = 0;
      for (std::uint32_t k = step.row[s]; k < step.row[s + 1]; ++k)
        row += static_cast<double>(step.probability[k]);
      EXPECT_NEAR(row, 1, 1e-6);
    }
}

// Two hypotheses, one and two standard deviations away.
TEST(HiddenPoses, TransitionsAreGaussian) {
  const Pose2 T{1, 2, 0.5};
  const std::vector<Pose2> to{T * Pose2{0.1, 0, 0}, T * Pose2{0, 0.4, 0}, T * Pose2{5, 0, 0}};
  const Transitions step = transitions({Pose2{}}, to, T, Vec3(0.01, 0.04, 1).asDiagonal());
  ASSERT_EQ(step.to.size(), 2U);  // the third is out of reach
  EXPECT_NEAR(std::log(step.probability[0] / step.probability[1]), 0.5 * (4 - 1), 1e-6);
}

TEST(HiddenPoses, PosteriorEqualsTheSumOverAllPathsAndSumsToOne) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Tiny t = tiny(seed);
    RandomStream r(seed, 1);
    PerHypothesis log_likelihood;
    for (const auto& support : t.hidden.supports) {
      log_likelihood.emplace_back();
      for (std::size_t s = 0; s < support.size(); ++s)
        log_likelihood.back().push_back(3 * r.normal() - 5);
    }
    const HiddenPosterior fast = forward_backward(t.hidden, log_likelihood);
    const HiddenPosterior slow = all_paths(t.hidden, log_likelihood);
    EXPECT_NEAR(fast.log_evidence, slow.log_evidence, 1e-10);
    for (std::size_t p = 0; p < t.pieces.size(); ++p) {
      EXPECT_NEAR(sum(fast.probability[p]), 1, 1e-12);
      for (std::size_t s = 0; s < fast.probability[p].size(); ++s)
        EXPECT_NEAR(fast.probability[p][s], slow.probability[p][s], 1e-10);
    }
  }
}

TEST(HiddenPoses, UnlikelyByThousandsStillSumsToOne) {
  const Tiny t = tiny(3);
  PerHypothesis log_likelihood;
  for (const auto& support : t.hidden.supports) {
    log_likelihood.emplace_back();
    for (std::size_t s = 0; s < support.size(); ++s)
      log_likelihood.back().push_back(-5000.0 * static_cast<double>(s + log_likelihood.size()));
  }
  for (const auto& of_pose : forward_backward(t.hidden, log_likelihood).probability)
    EXPECT_NEAR(sum(of_pose), 1, 1e-12);
}

/// log likelihood and log prior, by all paths.
double penalised(const Tiny& t, const HitMap& map) {
  return all_paths(t.hidden, log_likelihoods(t.pieces, t.hidden, map, kCells, {})).log_evidence +
         map.log_prior;
}

TEST(HiddenPoses, LikelihoodNeverFalls) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Tiny t = tiny(seed);
    PerHypothesis probability;
    for (const auto& support : t.hidden.supports)
      probability.emplace_back(support.size(), 1.0 / static_cast<double>(support.size()));
    double before = -1e300, first = 0;
    for (int round = 0; round < 12; ++round) {
      const HitMap map = maximise(t.pieces, t.hidden, probability, kCells);
      const double now = penalised(t, map);
      EXPECT_GE(now, before - 2e-5) << seed << " round " << round;  // cells are floats
      before = now;
      if (round == 0) first = now;
      probability = forward_backward(t.hidden, log_likelihoods(t.pieces, t.hidden, map, kCells, {}))
                        .probability;
    }
    EXPECT_GT(before, first) << seed;
  }
}

// The map of a given posterior is the best there is: any cell moved either way is worse.
TEST(HiddenPoses, TheMapIsTheMaximum) {
  const Tiny t = tiny(5);
  PerHypothesis probability;
  for (const auto& support : t.hidden.supports)
    probability.emplace_back(support.size(), 1.0 / static_cast<double>(support.size()));
  const HitMap best = maximise(t.pieces, t.hidden, probability, kCells);
  const auto expected = [&](HitMap map) {
    const PerHypothesis l = log_likelihoods(t.pieces, t.hidden, map, kCells, {});
    double q = 0;
    for (std::size_t p = 0; p < l.size(); ++p)
      for (std::size_t s = 0; s < l[p].size(); ++s) q += probability[p][s] * l[p][s];
    for (std::size_t c = 0; c < map.log_hit.size(); ++c)
      q += kCells.hits * static_cast<double>(map.log_hit[c]) +
           kCells.misses * static_cast<double>(map.log_miss[c]);
    return q;
  };
  const double q = expected(best);
  for (std::size_t c = 0; c < best.log_hit.size(); ++c)
    for (const double step : {-0.05, 0.05}) {
      HitMap other = best;
      const double m = std::exp(static_cast<double>(best.log_hit[c])) * (1 + step);
      other.log_hit[c] = static_cast<float>(std::log(m));
      other.log_miss[c] = static_cast<float>(std::log(1 - m));
      EXPECT_LT(expected(other), q) << c;
    }
}

TEST(HiddenPoses, ProbabilitiesOfHitAndMissSumToOne) {
  const Tiny t = tiny(6);
  PerHypothesis probability;
  for (const auto& support : t.hidden.supports)
    probability.emplace_back(support.size(), 1.0 / static_cast<double>(support.size()));
  const HitMap map = maximise(t.pieces, t.hidden, probability, kCells);
  for (std::size_t c = 0; c < map.log_hit.size(); ++c)
    ASSERT_NEAR(std::exp(map.log_hit[c]) + std::exp(map.log_miss[c]), 1, 1e-6);
}

Mapping mapped(const std::vector<Event>& events, const ExpectationMaximizationOptions& options,
               int threads = 1) {
  ExpectationMaximization method({}, options, {threads});
  for (const Event& event : events) EXPECT_FALSE(method.add(event));
  return method.finish();
}

const std::vector<Event>& ring_run() {
  static const std::vector<Event> events = [] {
    sim::SimulationOptions o;
    o.laser.max_range = 8;
    o.robot.left_scale = 1.02;
    o.robot.slip = 0.02;
    return simulated_run("bare_ring", 0, o);
  }();
  return events;
}
ExpectationMaximizationOptions quick() {
  ExpectationMaximizationOptions o;
  o.hypotheses = 80;
  o.rounds = 5;
  return o;
}

/// m, between where the last scan at the start of the lap stands and where it stood, seen from the
/// first.
template <class PoseOf>
double gap(const Site& site, const PoseOf& pose_of) {
  std::map<Time, Pose2> at;
  for (const Truth& t : site.truth) at[t.time] = t.T_world_robot;
  const auto truth = [&](std::size_t i) { return at.at(site.scans[i].scan.time); };
  std::size_t lap = site.scans.size() - 1;
  while (between(truth(0), truth(lap)).vector().norm() > 0.3) --lap;
  EXPECT_GT(lap, site.scans.size() / 2);
  return between(between(truth(0), truth(lap)),
                 between(pose_of(site.scans[0]), pose_of(site.scans[lap])))
      .translation()
      .norm();
}

TEST(ExpectationMaximization, LikelihoodOfARunNeverFallsAndTheRingCloses) {
  const Mapping mapping = mapped(ring_run(), quick());
  ASSERT_EQ(mapping.log_likelihoods.size(), 4U);
  for (const auto& series : mapping.log_likelihoods) {
    EXPECT_GT(series.size(), 1U);
    for (std::size_t i = 1; i < series.size(); ++i) EXPECT_GE(series[i], series[i - 1] - 1e-3);
  }
  EXPECT_FALSE(mapping.posterior);
  EXPECT_LT(gap(mapping.site, [](const PosedScan& s) { return s.estimate.T_map_robot; }), 0.02);
  EXPECT_GT(gap(mapping.site, [](const PosedScan& s) { return s.T_map_robot_front_end; }), 0.1);
}

TEST(ExpectationMaximization, SameForAnyNumberOfThreads) {
  ExpectationMaximizationOptions o = quick();
  o.levels = 1, o.hypotheses = 40, o.refine = false;
  const Mapping one = mapped(ring_run(), o), two = mapped(ring_run(), o, 2);
  EXPECT_EQ(one.log_likelihoods, two.log_likelihoods);
  for (std::size_t i = 0; i < one.site.scans.size(); ++i)
    ASSERT_EQ(one.site.scans[i].estimate.T_map_robot, two.site.scans[i].estimate.T_map_robot);
}

TEST(ExpectationMaximization, OneScanIsItsOwnMap) {
  std::vector<Event> events;
  for (const Event& e : ring_run()) {
    events.push_back(e);
    if (std::holds_alternative<Scan>(e)) break;
  }
  for (const Event& e : ring_run())
    if (std::holds_alternative<Odometry>(e) || std::holds_alternative<WheelMotion>(e)) {
      events.push_back(e);
      if (events.size() > 6) break;
    }
  const Mapping mapping = mapped(events, quick());
  EXPECT_EQ(mapping.site.scans.size(), 1U);
}

TEST(ExpectationMaximization, NeedsOdometry) {
  ExpectationMaximization method({}, quick(), {1});
  int scans = 0;
  for (const Event& e : ring_run()) {
    const auto* scan = std::get_if<Scan>(&e);
    if (!scan || ++scans > 50) continue;
    Scan alone = *scan;
    alone.T_odom_robot.reset();
    method.add(alone);
  }
  try {
    method.finish();
    FAIL() << "no odometry, and nothing was said";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find("expectation maximisation needs odometry"), 0U);
  }
}

}  // namespace
}  // namespace majak::slam
