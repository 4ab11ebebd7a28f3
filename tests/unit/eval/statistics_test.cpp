// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/statistics.hpp"

#include <gtest/gtest.h>

#include "majak/core/random.hpp"

namespace majak::eval {
namespace {

/// Groups of as many samples, of which a part errs alike in each.
struct Samples {
  std::vector<double> values;
  std::vector<int> groups;
};

Samples bursts(std::uint64_t run, int groups, int each, double alike, double alone) {
  RandomStream random(17, run);
  Samples s;
  for (int g = 0; g < groups; ++g) {
    const double common = alike * random.normal();
    for (int i = 0; i < each; ++i)
      s.values.push_back(5 + common + alone * random.normal()), s.groups.push_back(g);
  }
  return s;
}

TEST(MeanWithConfidence, IsTheMeanWithinItsInterval) {
  const Samples s = bursts(1, 12, 20, 1, 0.1);
  const auto m = mean_with_confidence(s.values, s.groups);
  EXPECT_NEAR(m.mean, error_stats(s.values).mean, 1e-12);
  EXPECT_LT(m.low, m.mean);
  EXPECT_GT(m.high, m.mean);
  const auto again = mean_with_confidence(s.values, s.groups);
  EXPECT_EQ(m.low, again.low);
  EXPECT_EQ(m.high, again.high);
  EXPECT_NE(m.low, mean_with_confidence(s.values, s.groups, {.seed = 2}).low);
}

TEST(MeanWithConfidence, HoldsTheTruthAsOftenAsItSays) {
  int held = 0, of_lone = 0;
  constexpr int kRuns = 1000;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    Samples s = bursts(run, 30, 5, 1, 0.2);
    const auto m = mean_with_confidence(s.values, s.groups, {.draws = 200});
    held += m.low < 5 && 5 < m.high;
    for (std::size_t i = 0; i < s.groups.size(); ++i) s.groups[i] = int(i);
    const auto l = mean_with_confidence(s.values, s.groups, {.draws = 200});
    of_lone += l.low < 5 && 5 < l.high;
  }
  EXPECT_NEAR(held / double(kRuns), 0.94, 0.03);
  EXPECT_LT(of_lone / double(kRuns), 0.66);  // were each sample taken for a group of its own
}

TEST(MeanWithConfidence, WeighsGroupsByTheirSamples) {
  const std::vector<double> values{1, 1, 1, 5};
  const std::vector<int> groups{7, 7, 7, -2};
  const auto m = mean_with_confidence(values, groups);
  EXPECT_EQ(m.mean, 2);
  EXPECT_EQ(m.low, 1);
  EXPECT_EQ(m.high, 5);
}

TEST(MeanWithConfidence, OfOneGroupOrNoneKnowsNothing) {
  const std::vector<double> values{1, 3};
  const std::vector<int> groups{0, 0};
  const auto m = mean_with_confidence(values, groups);
  EXPECT_EQ(m.low, 2);
  EXPECT_EQ(m.high, 2);
  EXPECT_EQ(mean_with_confidence({}, {}).mean, 0);
}

}  // namespace
}  // namespace majak::eval
