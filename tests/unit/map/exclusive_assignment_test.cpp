// SPDX-License-Identifier: Apache-2.0
#include "majak/map/exclusive_assignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::map {
namespace {

using Rows = std::vector<std::vector<double>>;

/// The slow twin: every way is walked, one by one.
AssignmentBelief slow(const Rows& l, const std::vector<double>& none) {
  const std::size_t pieces = l.size(), objects = l.front().size();
  AssignmentBelief belief{0, Rows(pieces, std::vector<double>(objects))};
  std::vector<std::size_t> way(pieces);
  std::vector<bool> taken(objects);
  double sum = 0;
  const std::function<void(std::size_t, double)> walk = [&](std::size_t k, double likelihood) {
    if (k == pieces) {
      sum += likelihood;
      for (std::size_t i = 0; i < pieces; ++i)
        if (way[i] < objects) belief.chance[i][way[i]] += likelihood;
      return;
    }
    way[k] = objects;
    walk(k + 1, likelihood * std::exp(none[k]));
    for (std::size_t n = 0; n < objects; ++n) {
      if (taken[n]) continue;
      taken[n] = true;
      way[k] = n;
      walk(k + 1, likelihood * std::exp(l[k][n]));
      taken[n] = false;
    }
  };
  walk(0, 1);
  for (auto& row : belief.chance)
    for (double& c : row) c /= sum;
  belief.log_sum = std::log(sum);
  return belief;
}

TEST(ExclusiveAssignment, SumsWhatTheSlowTwinWalks) {
  RandomStream random(1);
  for (int round = 0; round < 50; ++round) {
    const std::size_t pieces = 1 + random.below(4), objects = 1 + random.below(5);
    Rows l(pieces, std::vector<double>(objects));
    std::vector<double> none(pieces);
    for (auto& row : l)
      for (double& v : row) v = random.uniform(-8, 2);
    for (double& v : none) v = random.uniform(-8, 0);
    const auto fast = exclusive_assignment(l, none), twin = slow(l, none);
    EXPECT_NEAR(fast.log_sum, twin.log_sum, 1e-12);
    for (std::size_t k = 0; k < pieces; ++k)
      for (std::size_t n = 0; n < objects; ++n)
        EXPECT_NEAR(fast.chance[k][n], twin.chance[k][n], 1e-13);
  }
}

// Both pieces look like object 0, the second a little less; only one of them can be it.
TEST(ExclusiveAssignment, TwoPiecesAreNotTheSameObject) {
  const auto belief = exclusive_assignment({{-1, -20}, {-2, -4}}, {-30, -30});
  EXPECT_GT(belief.chance[0][0], 0.99);
  EXPECT_GT(belief.chance[1][1], 0.99);
}

TEST(ExclusiveAssignment, WithoutObjectsAllAreNone) {
  const auto belief = exclusive_assignment({{}, {}}, {-3, -4});
  EXPECT_DOUBLE_EQ(belief.log_sum, -7);
}

// Hundreds of nats apart, and more pieces than objects: nothing underflows.
TEST(ExclusiveAssignment, FarApartLikelihoodsStayFinite) {
  const Rows l(30, std::vector<double>(3, -10.0));
  const std::vector<double> none(30, -400.0);
  const auto belief = exclusive_assignment(l, none);
  // 30 * 29 * 28 ways, in each of which three pieces are objects.
  EXPECT_NEAR(belief.log_sum, -30 - 27 * 400 + std::log(30.0 * 29 * 28), 1e-8);
  for (const auto& row : belief.chance)
    for (const double c : row) EXPECT_NEAR(c, 1.0 / 30, 1e-9);
}

}  // namespace
}  // namespace majak::map
