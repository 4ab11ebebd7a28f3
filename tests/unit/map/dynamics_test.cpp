// SPDX-License-Identifier: Apache-2.0
#include "majak/map/dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/map/doors.hpp"

namespace majak::map {
namespace {

double logit(double p) { return std::log(p / (1 - p)); }

/// A laser in the origin sees one thing ahead; `ranges` one a second, beam 0 straight along x.
Site stare(const std::vector<float>& ranges, double spacing = 1) {
  Site site;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    PosedScan s;
    s.scan.time = from_seconds(100 + spacing * static_cast<double>(i));
    s.scan.max_range = 80;
    s.scan.ranges = {ranges[i]};
    s.estimate.T_map_robot = {0.025, 0.025, 0};
    site.scans.push_back(s);
  }
  return site;
}

std::vector<float> repeat(std::initializer_list<std::pair<int, float>> parts) {
  std::vector<float> ranges;
  for (const auto& [times, range] : parts) ranges.insert(ranges.end(), times, range);
  return ranges;
}

// The filter against Bayes' rule written out for the whole history at once: the sum over both
// states at every reading.
TEST(Dynamics, FilterIsTheForwardAlgorithm) {
  DynamicsOptions options;
  options.sure = 0.999;  // no change is stated, so the rates stay the prior's
  options.log_odds_limit = 20;
  options.prior_time = 20;
  DynamicsMap map(options);
  RandomStream random(5);
  CellHistory cell;
  double occupied = 0.5;
  float last = 0;
  for (int i = 0; i < 60; ++i) {
    const float time = last + static_cast<float>(random.uniform(0, 5));
    const bool hit = random.uniform() < 0.4;
    const DynamicsMap::Rates rates = map.rates(cell);
    map.add(cell, time, hit);
    if (i > 0) {  // slow twin: the chain in a thousand small steps
      for (int k = 0; k < 1000; ++k) {
        const double dt = static_cast<double>(time - last) / 1000;
        occupied += dt * (rates.fill * (1 - occupied) - rates.empty * occupied);
      }
    }
    const double l = hit ? options.hit_occupied : 1 - options.hit_occupied,
                 m = hit ? options.hit_free : 1 - options.hit_free;
    occupied = occupied * l / (occupied * l + (1 - occupied) * m);
    EXPECT_NEAR(static_cast<double>(cell.log_odds), logit(occupied), 2e-3);
    last = time;
  }
}

TEST(Dynamics, AThingThatIsTakenAwayLeavesAChange) {
  const DynamicsMap map = build_dynamics(stare(repeat({{60, 2.0F}, {60, 4.0F}})));
  const CellHistory* cell = map.history(40, 0);
  ASSERT_NE(cell, nullptr);
  const auto changes = map.changes(*cell);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].from, 59);
  EXPECT_EQ(changes[0].to, 60);
  EXPECT_EQ(map.kind(40, 0), CellKind::switching);
  EXPECT_EQ(map.kind(20, 0), CellKind::free);
  EXPECT_EQ(map.kind(80, 0), CellKind::occupied);
  EXPECT_EQ(map.kind(100, 0), CellKind::unknown);
  EXPECT_DOUBLE_EQ(map.duration(), 119);
}

TEST(Dynamics, WhoWalksByIsPassing) {
  const DynamicsMap map = build_dynamics(stare(repeat({{60, 4.0F}, {5, 2.0F}, {60, 4.0F}})));
  EXPECT_EQ(map.kind(40, 0), CellKind::passed);
  EXPECT_EQ(map.kind(80, 0), CellKind::occupied);
}

// Memory does not grow with what happens: the changes kept are bounded, all are counted, and the
// longest stays survive.
TEST(Dynamics, KeptChangesAreBounded) {
  std::vector<float> ranges = repeat({{300, 2.0F}});
  for (int i = 0; i < 40; ++i) {
    ranges.insert(ranges.end(), 12, 4.0F);
    ranges.insert(ranges.end(), 8, 2.0F);
  }
  ranges.insert(ranges.end(), 300, 4.0F);
  const DynamicsMap map = build_dynamics(stare(ranges));
  const CellHistory* cell = map.history(40, 0);
  ASSERT_NE(cell, nullptr);
  EXPECT_LE(map.changes(*cell).size(), CellHistory::kKept);
  EXPECT_EQ(cell->emptied, 41);
  EXPECT_EQ(cell->filled, 40);
  EXPECT_EQ(map.longest_stay(*cell, true), 299);
  EXPECT_GE(map.longest_stay(*cell, false), 299);  // what came between is forgotten
  EXPECT_FALSE(cell->occupied);
  const DynamicsMap twice = build_dynamics(stare(repeat({{5000, 4.0F}})));
  EXPECT_LE(map.bytes(), twice.bytes() + 16 * 8 * CellHistory::kKept);
}

// Rates: a cell that changes every 20 s learns about 1/20 s, one that never changed stays slow.
TEST(Dynamics, RatesAreLearntPerCell) {
  std::vector<float> ranges;
  for (int i = 0; i < 50; ++i) {
    ranges.insert(ranges.end(), 20, 4.0F);
    ranges.insert(ranges.end(), 40, 2.0F);
  }
  DynamicsOptions options;
  options.prior_time = 100;
  const DynamicsMap map = build_dynamics(stare(ranges), options);
  const auto busy = map.rates(*map.history(40, 0)), calm = map.rates(*map.history(20, 0));
  EXPECT_NEAR(busy.fill, 1.0 / 20, 0.006);
  EXPECT_NEAR(busy.empty, 1.0 / 40, 0.003);
  EXPECT_LT(calm.fill, 1e-3 / 5);
}

TEST(Dynamics, TheMapChangesWithTime) {
  const DynamicsMap map = build_dynamics(stare(repeat({{60, 2.0F}, {60, 4.0F}, {60, 2.0F}})));
  const auto at = [&](double time, bool hindsight) {
    return map_at(map, time, hindsight).log_odds(40, 0);
  };
  for (const bool hindsight : {true, false}) {
    EXPECT_GT(at(30, hindsight), 3);
    EXPECT_LT(at(90, hindsight), -3);
    EXPECT_GT(at(150, hindsight), 3);
  }
  // Before anything was seen: with hindsight as it was found, without it nothing is known.
  EXPECT_GT(at(-5, true), 3);
  EXPECT_FALSE(map_at(map, -5, false).known(40, 0));
  // Long after the last reading the cell is as likely one as the other.
  EXPECT_NEAR(at(1e7, true), 0, 1.5);
}

TEST(Dynamics, SameBytesForAnyNumberOfThreads) {
  Site site;
  RandomStream random(9);
  for (int i = 0; i < 60; ++i) {
    PosedScan s;
    s.scan.time = from_seconds(i);
    s.scan.angle_step = 0.1;
    for (int k = 0; k < 60; ++k) s.scan.ranges.push_back(static_cast<float>(random.uniform(1, 6)));
    s.estimate.T_map_robot = {random.uniform(-1, 1), random.uniform(-1, 1), 0};
    site.scans.push_back(s);
  }
  const DynamicsMap one = build_dynamics(site, {}, {1});
  for (const int threads : {2, 8}) {
    const DynamicsMap many = build_dynamics(site, {}, {threads});
    ASSERT_EQ(many.bounds(), one.bounds());
    EXPECT_EQ(many.bytes(), one.bytes());
    const CellBox box = one.bounds();
    for (int y = box.y0; y < box.y0 + box.height; ++y)
      for (int x = box.x0; x < box.x0 + box.width; ++x) {
        const CellHistory *a = one.history(x, y), *b = many.history(x, y);
        ASSERT_EQ(a == nullptr, b == nullptr);
        if (a) {
          ASSERT_EQ(a->log_odds, b->log_odds);
        }
      }
  }
}

TEST(Dynamics, NothingToSeeIsNoFailure) {
  EXPECT_EQ(build_dynamics({}).bounds(), CellBox{});
  const Site none = stare(std::vector<float>(5, kNoReturn));
  EXPECT_EQ(build_dynamics(none).kind(3, 0), CellKind::unknown);
  EXPECT_EQ(map_at(build_dynamics(none), 0).known_area(), 0);
  DynamicsOptions bad;
  bad.sure = 2;
  EXPECT_THROW(build_dynamics(none, bad), Error);
}

}  // namespace
}  // namespace majak::map
