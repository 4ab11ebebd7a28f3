// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/ways.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::slam {
namespace {

using Table = std::vector<std::vector<double>>;
using ShortCut = std::tuple<std::size_t, std::size_t, double>;

/// Steps and short cuts of a random drive; some ways are zero, some short cuts are longer than the
/// way, doubled, or from a place to itself.
struct Drive {
  std::vector<double> steps;  // the first is not driven
  std::vector<ShortCut> short_cuts;
};
Drive random_drive(std::uint64_t seed) {
  RandomStream r(seed);
  Drive d;
  d.steps.resize(1 + r.below(14));
  for (double& step : d.steps) step = r.uniform() < 0.15 ? 0 : r.uniform(0, 10);
  for (std::uint64_t i = r.below(8); i > 0; --i)
    d.short_cuts.emplace_back(r.below(d.steps.size()), r.below(d.steps.size()), r.uniform(0, 15));
  return d;
}

Ways ways_of(const Drive& drive) {
  Ways ways;
  for (const double step : drive.steps) ways.add_place(step);
  for (const auto& [a, b, way] : drive.short_cuts) ways.add_short_cut(a, b, way);
  return ways;
}

Table table_of(const Ways& ways) {
  Table table;
  for (std::size_t i = 0; i < ways.size(); ++i) table.push_back(ways.from(i));
  return table;
}

/// The slow twin: Floyd 1962, over all places in between.
Table floyd_warshall(const Drive& drive) {
  const std::size_t n = drive.steps.size();
  Table d(n, std::vector<double>(n, std::numeric_limits<double>::infinity()));
  const auto join = [&](std::size_t a, std::size_t b, double way) {
    d[a][b] = std::min(d[a][b], way), d[b][a] = std::min(d[b][a], way);
  };
  for (std::size_t i = 0; i < n; ++i) join(i, i, 0);
  for (std::size_t i = 1; i < n; ++i) join(i - 1, i, drive.steps[i]);
  for (const auto& [a, b, way] : drive.short_cuts) join(a, b, way);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) d[i][j] = std::min(d[i][j], d[i][k] + d[k][j]);
  return d;
}

TEST(Ways, EqualTheirSlowTwin) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Drive drive = random_drive(seed);
    const Table fast = table_of(ways_of(drive)), slow = floyd_warshall(drive);
    ASSERT_EQ(fast.size(), slow.size());
    for (std::size_t i = 0; i < slow.size(); ++i) {
      ASSERT_EQ(fast[i].size(), slow.size());
      for (std::size_t j = 0; j < slow.size(); ++j)
        ASSERT_NEAR(fast[i][j], slow[i][j], 1e-12 * (1 + slow[i][j]))
            << seed << ' ' << i << ' ' << j;
    }
  }
}

TEST(Ways, AreAMetric) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Table d = table_of(ways_of(random_drive(seed)));
    for (std::size_t i = 0; i < d.size(); ++i) {
      EXPECT_EQ(d[i][i], 0);
      for (std::size_t j = 0; j < d.size(); ++j) {
        EXPECT_NEAR(d[i][j], d[j][i], 1e-12);
        for (std::size_t k = 0; k < d.size(); ++k) EXPECT_LE(d[i][j], d[i][k] + d[k][j] + 1e-12);
      }
    }
  }
}

TEST(Ways, ShortCutsOnlyShorten) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Drive drive = random_drive(seed);
    const Table with = table_of(ways_of(drive));
    for (const auto& [a, b, way] : drive.short_cuts) EXPECT_LE(with[a][b], way);
    drive.short_cuts.clear();
    const Table without = table_of(ways_of(drive));
    for (std::size_t i = 0; i < with.size(); ++i)
      for (std::size_t j = 0; j < with.size(); ++j) EXPECT_LE(with[i][j], without[i][j] + 1e-12);
  }
}

TEST(Ways, WithoutShortCutsAreWhatWasDriven) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Drive drive = random_drive(seed);
    const std::vector<ShortCut> short_cuts = std::exchange(drive.short_cuts, {});
    Ways ways = ways_of(drive);
    const Table d = table_of(ways);
    double sum = 0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      if (i > 0) sum += drive.steps[i];
      EXPECT_NEAR(ways.driven(i), sum, 1e-12);
      for (std::size_t j = 0; j < d.size(); ++j)
        EXPECT_NEAR(d[i][j], std::abs(ways.driven(i) - ways.driven(j)), 1e-9);
    }
    // A short cut is not driven.
    for (const auto& [a, b, way] : short_cuts) ways.add_short_cut(a, b, way);
    EXPECT_NEAR(ways.driven(d.size() - 1), sum, 1e-12);
  }
}

TEST(Ways, ASquareThatCloses) {
  Ways ways;
  EXPECT_EQ(ways.size(), 0U);
  ways.add_place(7);  // the first has none before it
  EXPECT_EQ(ways.from(0), std::vector<double>{0});
  for (int i = 0; i < 4; ++i) ways.add_place(10);
  EXPECT_EQ(ways.from(0), (std::vector<double>{0, 10, 20, 30, 40}));
  ways.add_short_cut(4, 0, 1);
  EXPECT_EQ(ways.from(0), (std::vector<double>{0, 10, 20, 11, 1}));
  EXPECT_EQ(ways.from(3), (std::vector<double>{11, 20, 10, 0, 10}));
  ways.add_place(10);  // and on, another lap
  EXPECT_EQ(ways.from(5), (std::vector<double>{11, 21, 30, 20, 10, 0}));
}

}  // namespace
}  // namespace majak::slam
