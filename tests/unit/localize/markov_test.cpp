// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/markov.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "majak/core/random.hpp"
#include "tests/unit/localize/hall.hpp"

namespace majak::localize {
namespace {

using filter::PoseHistogram;
using filter::PoseLattice;
using fixture::hall;
using fixture::seen_from;

std::shared_ptr<const PoseLattice> cells_of_the_hall() {
  PoseLattice l(0, 0, 0.1, 120, 52, 36);
  for (int y = 0; y < 52; ++y)
    for (int x = 0; x < 120; ++x)
      if (hall()->known.at(Vec2(0.1 * x + 0.05, 0.1 * y + 0.05)) == map::CellState::free)
        l.set_open(x, y);
  return std::make_shared<const PoseLattice>(l);
}

PoseHistogram uneven(const std::shared_ptr<const PoseLattice>& lattice) {
  PoseHistogram belief(lattice);
  belief.add_uniform(1);
  RandomStream random(1);
  for (const std::size_t i : belief.held())
    for (float& p : belief.tile(i)) p *= static_cast<float>(random.uniform());
  return belief;
}

const Pose2 kTruth{3.53, 2.21, 0.6};

TEST(BeliefWeighing, NothingIsWeighedDownTooFarAndWhatMattersIsExact) {
  const auto lattice = cells_of_the_hall();
  const BeliefWeighing weighing(hall(), lattice, 20);
  const match::Beams beams = match::beams(seen_from(kTruth), {.most = 60});
  const PoseHistogram before = uneven(lattice);
  PoseHistogram after = before;
  const double share = 1e-2;
  const Weighed done = weighing.weigh(after, beams, {.share = share});
  const std::size_t all = lattice->open_cells() * 36;
  EXPECT_GT(done.cells, 0U);
  EXPECT_LT(done.cells, all / 5);  // coarse to fine is worth it

  // One by one.
  std::vector<double> exact, found;
  match::PoseArrays pose;
  pose.resize(1);
  double best = 0, of_best = 0;
  for (int y = 0; y < 52; ++y)
    for (int x = 0; x < 120; ++x)
      for (int h = 0; h < 36; ++h) {
        if (before.at(x, y, h) == 0) continue;
        pose.set(0, {0.1 * x + 0.05, 0.1 * y + 0.05, lattice->heading(h)});
        std::uint32_t cost = 0;
        hall()->likelihood.costs(beams, pose, 0, 1, &cost);
        const double p =
            before.at(x, y, h) * std::exp(-20.0 * cost * match::LikelihoodField::kUnit /
                                          static_cast<double>(beams.returns));
        exact.push_back(p), found.push_back(after.at(x, y, h));
        if (p > best) best = p, of_best = after.at(x, y, h);
      }
  std::size_t large = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double e = exact[i] / best, f = found[i] / of_best;
    ASSERT_GE(f, e * (1 - 1e-5) - 1e-30);
    if (e >= share) {
      ASSERT_NEAR(f, e, 1e-5 * e);
      ++large;
    }
  }
  EXPECT_GT(large, 5U);
  EXPECT_LT(large, exact.size() / 50);
}

TEST(BeliefWeighing, WhatIsNotLookedAtGetsOneLikelihood) {
  const auto lattice = cells_of_the_hall();
  const BeliefWeighing weighing(hall(), lattice, 10);
  PoseHistogram belief(lattice);
  belief.add_uniform(1e-6);
  PoseHistogram peak(lattice);
  const std::size_t tile = lattice->tile(36, 17);
  peak.tile(tile).assign(36 * 64, 0);
  peak.tile(tile)[4 * 64 + 1 * 8 + 4] = 1;
  belief.add(peak, 1);
  const float before = belief.at(50, 12, 7), before_peak = belief.at(36, 17, 4);
  const match::Beams beams = match::beams(seen_from(kTruth));
  const Weighed done = weighing.weigh(belief, beams, {1e-4, 1e-4, 0.9});
  EXPECT_EQ(done.blocks, 1U);
  EXPECT_LE(done.cells, 16U);
  EXPECT_NEAR(belief.at(50, 12, 7) / before, done.elsewhere, 1e-6 * done.elsewhere);
  // P(s) elsewhere against that at the peak.
  match::PoseArrays pose;
  pose.resize(1);
  pose.set(0, {3.65, 1.75, lattice->heading(4)});
  std::uint32_t cost = 0;
  hall()->likelihood.costs(beams, pose, 0, 1, &cost);
  const double mean = cost * match::LikelihoodField::kUnit / static_cast<double>(beams.returns);
  EXPECT_NEAR(done.elsewhere / (belief.at(36, 17, 4) / before_peak), std::exp(10 * (mean - 0.9)),
              1e-4 * done.elsewhere);
}

TEST(BeliefWeighing, AnyNumberOfThreadsGivesTheSameBytes) {
  const auto lattice = cells_of_the_hall();
  const BeliefWeighing weighing(hall(), lattice, 15);
  const match::Beams beams = match::beams(seen_from(kTruth));
  PoseHistogram one = uneven(lattice);
  weighing.weigh(one, beams, {});
  for (const int threads : {2, 8}) {
    PoseHistogram p = uneven(lattice);
    weighing.weigh(p, beams, {}, {threads});
    for (const std::size_t i : p.held()) ASSERT_EQ(p.tile(i), one.tile(i));
  }
}

/// A robot that drives curves in the hall; its wheels err by 5 %.
struct Drive {
  Pose2 truth = kTruth;
  Time time = 0;

  FedScan stand() { return {at(truth), {}, Mat3::Zero(), true}; }
  FedScan step() {
    const Vec3 twist(0.08, 0, 0.07);
    truth = truth * exp(twist);
    FedScan fed{at(truth), exp(0.95 * twist), Mat3::Zero(), true};
    fed.covariance = Vec3(1e-4, 1e-4, 1e-4).asDiagonal();
    return fed;
  }
  Scan at(const Pose2& pose) {
    Scan scan = seen_from(pose);
    scan.time = time += 100'000'000;
    return scan;
  }
};

double off(const Estimate& e, const Pose2& truth) {
  return (e.T_map_robot.translation() - truth.translation()).norm();
}

const MarkovOptions kOptions{.turn = radians(4)};

TEST(Markov, FindsItselfFromNothingAndThenLooksAtLittle) {
  Markov filter(hall(), kOptions);
  Drive drive;
  const double n = filter.belief().entropy();
  EXPECT_NEAR(n, std::log(90.0 * static_cast<double>(filter.belief().lattice().open_cells())),
              1e-4);
  Estimate e = filter.add(drive.stand());
  EXPECT_EQ(filter.updates(), 1);
  EXPECT_LT(filter.belief().entropy(), n - 3);
  const std::size_t looked_at = filter.weighed().blocks, most = filter.bytes();
  for (int i = 0; i < 30; ++i) {
    e = filter.add(drive.step());
    EXPECT_NEAR(filter.belief().mass() + filter.resting(), 1, 1e-5);
  }
  EXPECT_EQ(e.health, Health::ok);
  EXPECT_LT(off(e, drive.truth), 0.08);
  EXPECT_LT(std::abs(angle_diff(e.T_map_robot.theta, drive.truth.theta)), radians(3));
  EXPECT_LT(filter.weighed().blocks, looked_at / 50);
  EXPECT_LT(filter.bytes(), most / 2);
  EXPECT_LT(filter.resting(), 1e-3);
  const Vec3 d(e.T_map_robot.x - drive.truth.x, e.T_map_robot.y - drive.truth.y,
               angle_diff(e.T_map_robot.theta, drive.truth.theta));
  EXPECT_LT(d.dot(e.covariance.inverse() * d), 12);
}

TEST(Markov, StandingStillTeachesNothingTwice) {
  Markov filter(hall(), kOptions);
  Drive drive;
  filter.add(drive.stand());
  const double before = filter.belief().entropy();
  for (int i = 0; i < 5; ++i) filter.add(drive.stand());
  EXPECT_EQ(filter.updates(), 1);
  EXPECT_EQ(filter.belief().entropy(), before);
}

TEST(Markov, BetweenUpdatesTheEstimateRidesOnTheWheels) {
  Markov filter(hall(), {.motion_step = 1, .motion_turn = 1});
  Drive drive;
  const Pose2 first = filter.add(drive.stand()).T_map_robot;
  const FedScan a = drive.step(), b = drive.step();
  filter.add(a);
  const Estimate e = filter.add(b);
  EXPECT_EQ(filter.updates(), 1);
  EXPECT_EQ(e.time, b.scan.time);
  EXPECT_LT(
      (e.T_map_robot.vector() - (first * a.T_previous_robot * b.T_previous_robot).vector()).norm(),
      1e-12);
}

TEST(Markov, ARobotThatWasCarriedAwayIsFoundAgain) {
  Markov filter(hall(), kOptions);
  Drive drive;
  filter.add(drive.stand());
  Estimate e;
  for (int i = 0; i < 20; ++i) e = filter.add(drive.step());
  ASSERT_EQ(e.health, Health::ok);
  drive.truth = {7.76, 1.98, 1.0};
  bool doubted = false;
  int until = 0;
  for (; until < 20 && !(e.health == Health::ok && off(e, drive.truth) < 0.15); ++until) {
    e = filter.add(drive.step());
    doubted = doubted || e.health != Health::ok;
    EXPECT_NEAR(filter.belief().mass() + filter.resting(), 1, 1e-5);
  }
  EXPECT_TRUE(doubted);
  EXPECT_LE(until, 8);
}

// A place that the map does not show: nothing on it fits, which a whole look tells once.
TEST(Markov, WhereTheMapIsWrongItDoubtsButDoesNotSearchAtEveryStep) {
  Markov filter(hall(), kOptions);
  Drive drive;
  filter.add(drive.stand());
  Estimate e;
  int ok = 0, whole = 0;
  const std::size_t blocks = filter.weighed().blocks;
  for (int i = 0; i < 30; ++i) {
    FedScan wrong = drive.step();
    for (std::size_t b = 0; b < wrong.scan.ranges.size(); ++b)
      wrong.scan.ranges[b] = 0.5F + 0.1F * static_cast<float>(b % 7);
    e = filter.add(wrong);
    ok += e.health == Health::ok;
    whole += filter.weighed().blocks > blocks / 2;
  }
  EXPECT_EQ(ok, 0);
  EXPECT_LE(whole, 10);
}

TEST(Markov, AnyNumberOfThreadsGivesTheSameBytes) {
  const auto path = [](int threads) {
    Markov filter(hall(), kOptions, {threads});
    Drive drive;
    std::vector<double> numbers;
    filter.add(drive.stand());
    for (int i = 0; i < 6; ++i) {
      const Estimate e = filter.add(drive.step());
      for (const double v : {e.T_map_robot.x, e.T_map_robot.y, e.T_map_robot.theta,
                             e.covariance(0, 0), filter.resting()})
        numbers.push_back(v);
    }
    return numbers;
  };
  const auto one = path(1);
  EXPECT_EQ(path(2), one);
  EXPECT_EQ(path(8), one);
}

TEST(Markov, AScanThatSeesNothingMovesTheBeliefOnly) {
  Markov filter(hall(), kOptions);
  Drive drive;
  filter.add(drive.stand());
  const double before = filter.belief().entropy();
  FedScan blind = drive.step();
  for (float& r : blind.scan.ranges) r = kNoReturn;
  filter.add(blind), filter.add(blind);
  EXPECT_GE(filter.updates(), 2);
  EXPECT_GT(filter.belief().entropy(), before);
}

TEST(Markov, ALogIsLocalizedScanByScan) {
  const Localizer localizer = markov(hall(), kOptions, {.probation = 5}, [] { return 1.0; });
  Drive drive;
  Pose2 odometry;
  std::size_t scans = 0;
  for (int i = 0; i < 25; ++i) {
    FedScan fed = drive.step();
    odometry = odometry * fed.T_previous_robot;
    fed.scan.T_odom_robot = odometry;
    localizer.add(Odometry{fed.scan.time, odometry, {}, {}});
    localizer.add(fed.scan);
    ++scans;
  }
  const Localization result = localizer.finish();
  ASSERT_EQ(result.estimates.size(), scans);
  EXPECT_LT(off(result.estimates.back(), drive.truth), 0.1);
  EXPECT_EQ(result.estimates.back().health, Health::ok);
  ASSERT_EQ(result.phases.size(), 1U);
}

}  // namespace
}  // namespace majak::localize
