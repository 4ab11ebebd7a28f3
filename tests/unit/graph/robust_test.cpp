// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "majak/graph/kernel.hpp"
#include "majak/graph/optimize.hpp"
#include "random_graph.hpp"

namespace majak::graph {
namespace {

std::vector<Kernel> kernels() {
  std::vector<Kernel> all;
  for (const double bound : {1.0, 11.34}) {
    for (const auto kind : {Kernel::quadratic, Kernel::cauchy, Kernel::dcs, Kernel::truncated})
      all.push_back({kind, bound});
    for (const double mu : {1e-6, 0.1, 1.0, 50.0}) all.push_back({Kernel::truncated, bound, mu});
  }
  return all;
}

TEST(Kernel, WeightIsTheSlopeOfTheCost) {
  for (const Kernel& k : kernels())
    for (const double s : {1e-3, 0.3, 0.7, 2.0, 9.0, 14.0, 300.0, 1e5}) {
      const double h = 1e-6 * s;
      EXPECT_NEAR((k.cost(s + h) - k.cost(s - h)) / (2 * h), k.weight(s), 1e-5)
          << k.kind << " bound " << k.bound << " mu " << k.mu << " s " << s;
    }
}

TEST(Kernel, SmallErrorsAreBelievedAndLargeOnesNot) {
  for (const Kernel& k : kernels()) {
    EXPECT_EQ(k.cost(0), 0);
    EXPECT_EQ(k.weight(0), 1);
    for (double s = 1e-3, last = 1; s < 1e6; s *= 1.5) {
      EXPECT_LE(k.cost(s), s * (1 + 1e-12));
      EXPECT_LE(k.weight(s), last);
      last = k.weight(s);
    }
    const bool redescends = k.kind != Kernel::quadratic && k.mu > 0.1;
    EXPECT_LT(k.weight(1e6), redescends ? 1e-3 : 1.1);
  }
  EXPECT_EQ((Kernel{Kernel::truncated, 5}.weight(4.999)), 1);
  EXPECT_EQ((Kernel{Kernel::truncated, 5}.weight(5.001)), 0);
}

/// A ring walked twice; the second round meets the first, with `false_edges` lies among them.
PoseGraph ring_with_lies(std::uint64_t seed, int false_edges) {
  RandomStream random(seed);
  PoseGraph g;
  const Pose2 step{1, 0, radians(9)};
  const auto noisy = [&](const Pose2& p) {
    return p * exp(Vec3(0.02 * random.normal(), 0.02 * random.normal(), 0.01 * random.normal()));
  };
  const Mat3 information = Vec3(2500, 2500, 10000).asDiagonal();
  for (int i = 0; i < 80; ++i) {
    g.poses.push_back(i == 0 ? Pose2{} : g.poses.back() * noisy(step));
    if (i > 0)
      g.edges.push_back({i - 1, i, between(g.poses[i - 1], g.poses[i]), information, false});
  }
  for (int i = 40; i < 80; ++i) g.edges.push_back({i - 40, i, noisy({}), information, true});
  for (int k = 0; k < false_edges; ++k) {
    const int a = static_cast<int>(random.below(60));
    g.edges.push_back(
        {a, a + 5 + static_cast<int>(random.below(14)), random_pose(random, 8), information, true});
  }
  return g;
}

class RobustMethods : public testing::TestWithParam<Robust> {};

TEST_P(RobustMethods, WithoutLiesTheResultIsNearLeastSquares) {
  PoseGraph robust = ring_with_lies(1, 0), plain = robust;
  optimize(robust, {.robust = GetParam()});
  optimize(plain, {.robust = Robust::none});
  for (std::size_t i = 0; i < plain.poses.size(); ++i)
    EXPECT_LT(between(robust.poses[i], plain.poses[i]).translation().norm(), 0.05);
}

TEST_P(RobustMethods, LiesBendTheRingLittle) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    PoseGraph clean = ring_with_lies(seed, 0), g = ring_with_lies(seed, 15);
    optimize(clean, {.robust = Robust::none});
    const Summary s = optimize(g, {.robust = GetParam()});
    EXPECT_TRUE(s.converged);
    double worst = 0;
    for (std::size_t i = 0; i < g.poses.size(); ++i)
      worst = std::max(worst, between(clean.poses[i], g.poses[i]).translation().norm());
    EXPECT_LT(worst, GetParam() == Robust::cauchy ? 0.4 : 0.1) << "seed " << seed;
    for (std::size_t k = 0; k < g.edges.size(); ++k) {
      const bool lie = k >= 119;
      EXPECT_LE(s.edge_weight[k], lie ? 0.1 : 1);
      EXPECT_GE(s.edge_weight[k], g.edges[k].robust ? 0 : 1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, RobustMethods,
                         testing::Values(Robust::cauchy, Robust::dcs, Robust::dcs_truncated,
                                         Robust::gnc_truncated));

TEST(Robust, NoneBelievesEverythingAndIsBent) {
  PoseGraph g = ring_with_lies(2, 15);
  const Summary s = optimize(g, {.robust = Robust::none});
  EXPECT_GT(s.final_chi2, 1e4);
  EXPECT_EQ(s.edge_weight, std::vector<double>(g.edges.size(), 1.0));
}

TEST(Robust, TheVerdictIsYesOrNo) {
  PoseGraph g = ring_with_lies(3, 15);
  const Summary s = optimize(g);
  int rejected = 0;
  for (std::size_t k = 0; k < g.edges.size(); ++k) {
    EXPECT_TRUE(s.edge_weight[k] == 0 || s.edge_weight[k] == 1);
    EXPECT_EQ(s.edge_weight[k] == 0, g.edges[k].robust && s.edge_chi2[k] > 11.34);
    rejected += s.edge_weight[k] == 0;
  }
  EXPECT_GE(rejected, 15);
  EXPECT_LE(rejected, 17);
}

TEST(Robust, PartsThatOnlyDoubtedEdgesJoinAreStillJoined) {
  PoseGraph g = ring_with_lies(4, 0);
  for (Edge& e : g.edges) e.robust = e.robust || e.to == 40;  // two chains now
  for (std::size_t i = 40; i < 80; ++i) g.poses[i] = Pose2{100, -50, 2} * g.poses[i];
  const Summary s = optimize(g);
  EXPECT_LT(s.final_cost, 2.0 * 3 * 40);
  EXPECT_LT(between(g.poses[0], g.poses[40]).translation().norm(), 0.2);
}

}  // namespace
}  // namespace majak::graph
