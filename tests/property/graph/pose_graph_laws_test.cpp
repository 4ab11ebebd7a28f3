// SPDX-License-Identifier: Apache-2.0
// Laws that hold for every graph, over many random ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "../../unit/graph/random_graph.hpp"
#include "majak/graph/marginals.hpp"
#include "majak/graph/optimize.hpp"

namespace majak::graph {
namespace {

constexpr std::uint64_t kGraphs = 25;
constexpr OptimizeOptions kExact{.relative_tolerance = 1e-14};

PoseGraph graph_of(std::uint64_t seed) {
  RandomStream random(seed, 99);
  const int poses = 2 + static_cast<int>(random.below(40));
  return random_graph(seed, poses, static_cast<int>(random.below(40)), 0.08).graph;
}

PoseGraph moved(PoseGraph g, const Pose2& T_new_old) {
  for (Pose2& p : g.poses) p = T_new_old * p;
  return g;
}

TEST(PoseGraphLaws, Chi2IgnoresARigidMotionOfEverything) {
  for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
    const PoseGraph g = graph_of(seed);
    RandomStream random(seed);
    EXPECT_NEAR(chi2(moved(g, random_pose(random, 50))), chi2(g), 1e-8 * chi2(g));
  }
}

TEST(PoseGraphLaws, TheOptimumMovesWithTheMap) {
  for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
    PoseGraph g = graph_of(seed);
    const Pose2 T{3, -7, kPi - 0.1};
    PoseGraph h = moved(g, T);
    optimize(g, kExact);
    optimize(h, kExact);
    for (std::size_t i = 0; i < g.poses.size(); ++i)
      EXPECT_LT((between(T * g.poses[i], h.poses[i])).vector().norm(), 1e-6);
  }
}

TEST(PoseGraphLaws, AnEdgeMayBeReadBackwards) {
  // Z -> Z^-1 with the information carried over by the adjoint; exact where the residual is zero,
  // so the optimum of a graph without noise and its covariances are the same.
  for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
    PoseGraph g = random_graph(seed, 15, 10, 0).graph;
    PoseGraph back = g;
    for (Edge& e : back.edges) {
      const Mat3 a = adjoint(e.T_from_to.inverse());
      std::swap(e.from, e.to);
      e.information = a.transpose() * e.information * a;
      e.information = (0.5 * (e.information + e.information.transpose())).eval();
      e.T_from_to = e.T_from_to.inverse();
    }
    optimize(g, kExact);
    optimize(back, kExact);
    const Marginals forward(g), backward(back);
    for (int i = 0; i < 15; ++i) {
      EXPECT_LT(between(g.poses[i], back.poses[i]).vector().norm(), 1e-7);
      EXPECT_LT((forward.covariance(i) - backward.covariance(i)).norm(),
                1e-6 * (1e-3 + forward.covariance(i).norm()));
    }
  }
}

TEST(PoseGraphLaws, NamesOfPosesAndOrderOfEdgesDoNotMatter) {
  for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
    PoseGraph g = graph_of(seed), h;
    const int n = static_cast<int>(g.poses.size());
    RandomStream random(seed, 5);
    std::vector<int> name(n);
    std::iota(name.begin(), name.end(), 0);
    for (int i = n - 1; i > 0; --i) std::swap(name[i], name[random.below(i + 1)]);
    h.poses.resize(n);
    for (int i = 0; i < n; ++i) h.poses[name[i]] = g.poses[i];
    h.fixed = name[g.fixed];
    h.edges.assign(g.edges.rbegin(), g.edges.rend());
    for (Edge& e : h.edges) e.from = name[e.from], e.to = name[e.to];
    const double a = optimize(g, kExact).final_chi2, b = optimize(h, kExact).final_chi2;
    EXPECT_NEAR(a, b, 1e-9 * (1 + a));
    for (int i = 0; i < n; ++i)
      EXPECT_LT(between(g.poses[i], h.poses[name[i]]).vector().norm(), 1e-6);
  }
}

TEST(PoseGraphLaws, MoreEdgesNeverMakeAPoseLessSure) {
  for (std::uint64_t seed = 0; seed < kGraphs; ++seed) {
    PoseGraph g = graph_of(seed);
    const Marginals before(g);
    g.edges.push_back(
        {0, static_cast<int>(g.poses.size()) - 1, {1, 1, 1}, Mat3::Identity(), false});
    const Marginals after(g);
    for (int i = 0; i < static_cast<int>(g.poses.size()); ++i)
      EXPECT_LE(after.covariance(i).trace(), before.covariance(i).trace() * (1 + 1e-9));
  }
}

}  // namespace
}  // namespace majak::graph
