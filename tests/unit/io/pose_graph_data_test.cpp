// SPDX-License-Identifier: Apache-2.0
// The known graphs of the field: their optima, and what false closures do to them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "majak/core/random.hpp"
#include "majak/graph/optimize.hpp"
#include "majak/io/g2o.hpp"
#include "tests/support/data_folder.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using graph::PoseGraph;

fs::path posegraph_folder() { return data_folder() / "posegraph"; }

PoseGraph load(const std::string& name) {
  Report report;
  return read_g2o(posegraph_folder() / (name + ".g2o.gz"), report).graph;
}

bool absent(const std::string& name) {
  return !fs::exists(posegraph_folder() / (name + ".g2o.gz"));
}

struct Known {
  const char* name;
  std::size_t poses, edges;
  double start, optimum;  ///< chi2; start 0: the file has no vertices
};

class KnownGraphs : public testing::TestWithParam<Known> {};

TEST_P(KnownGraphs, OneCallWithDefaultsReachesTheOptimum) {
  const Known& known = GetParam();
  if (absent(known.name)) GTEST_SKIP() << "the data folder has no " << known.name;
  PoseGraph g = load(known.name);
  EXPECT_EQ(g.poses.size(), known.poses);
  EXPECT_EQ(g.edges.size(), known.edges);
  const double start = known.start > 0 ? known.start : graph::chi2(g);
  EXPECT_NEAR(graph::chi2(g), start, 1e-5 * start);
  const graph::Summary s = graph::optimize(g);
  EXPECT_TRUE(s.converged);
  EXPECT_NEAR(s.final_chi2, known.optimum, 1e-6 * known.optimum);
  EXPECT_NEAR(graph::chi2(g), known.optimum, 1e-6 * known.optimum);
}

INSTANTIATE_TEST_SUITE_P(All, KnownGraphs,
                         testing::Values(Known{"intel", 1728, 2512, 551.736, 45.004696},
                                         Known{"MIT", 808, 827, 0, 41.163269},
                                         Known{"manhattan", 3500, 5453, 0, 3549.0368},
                                         Known{"city10000", 10000, 20687, 6.54162688e8, 511.98516}),
                         [](const auto& param) { return param.param.name; });

/// The graph at its optimum with every edge robust that does not join neighbours in time.
PoseGraph clean_graph(const std::string& name) {
  PoseGraph g = load(name);
  graph::optimize(g);
  for (graph::Edge& e : g.edges) e.robust = std::abs(e.from - e.to) != 1;
  return g;
}

/// Mean translational error of the true closures, m.
double relation_error(const PoseGraph& g, std::size_t true_edges) {
  double sum = 0;
  int count = 0;
  for (std::size_t k = 0; k < true_edges; ++k) {
    const graph::Edge& e = g.edges[k];
    if (!e.robust) continue;
    sum += graph::residual(g.poses[e.from], g.poses[e.to], e.T_from_to).head<2>().norm();
    ++count;
  }
  return sum / count;
}

/// As many false closures as a fifth of the true ones, in runs of `run` that agree with each other
/// (a place taken for another); each at least 1 m or 0.5 rad off the truth. The poses are then
/// those of the trusted edges alone.
PoseGraph with_false_closures(const PoseGraph& clean, int run, std::uint64_t seed) {
  RandomStream random(seed, static_cast<std::uint64_t>(run));
  std::vector<graph::Edge> closures;
  for (const graph::Edge& e : clean.edges)
    if (e.robust) closures.push_back(e);
  PoseGraph g = clean;
  const std::size_t wanted = clean.edges.size() + closures.size() / 5;
  const double size = run > 1 ? 3 : 20;  // m
  while (g.edges.size() < wanted) {
    const int a = static_cast<int>(random.below(clean.poses.size() - run));
    const int b = static_cast<int>(random.below(clean.poses.size() - run));
    const Pose2 wrong{random.uniform(-size, size), random.uniform(-size, size),
                      random.uniform(-kPi, kPi)};
    const Vec3 off = graph::residual(clean.poses[a], clean.poses[b], wrong);
    if (std::abs(a - b) < 20 || (off.head<2>().norm() < 1 && std::abs(off.z()) < 0.5)) continue;
    for (int k = 0; k < run && g.edges.size() < wanted; ++k) {
      const Pose2 noise =
          exp(Vec3(0.02 * random.normal(), 0.02 * random.normal(), 0.005 * random.normal()));
      const Pose2 T = between(clean.poses[a + k], clean.poses[a]) * wrong *
                      between(clean.poses[b], clean.poses[b + k]) * noise;
      g.edges.push_back(
          {a + k, b + k, T, closures[random.below(closures.size())].information, true});
    }
  }
  for (const graph::Edge& e : clean.edges)
    if (!e.robust && e.to == e.from + 1) g.poses[e.to] = g.poses[e.from] * e.T_from_to;
  return g;
}

struct Injection {
  const char* name;
  int run, seeds;
};
class FalseClosures : public testing::TestWithParam<Injection> {};

TEST_P(FalseClosures, AFifthOfThemRaisesTheErrorByLessThanATenth) {
  const auto [name, run, seeds] = GetParam();
  if (absent(name)) GTEST_SKIP() << "the data folder has no " << name;
  const PoseGraph clean = clean_graph(name);
  const double best = relation_error(clean, clean.edges.size());
  for (int seed = 0; seed < seeds; ++seed) {
    PoseGraph g = with_false_closures(clean, run, seed);
    ASSERT_GT(relation_error(g, clean.edges.size()), 5 * best);
    const graph::Summary s = graph::optimize(g);
    EXPECT_LT(relation_error(g, clean.edges.size()), 1.1 * best) << "seed " << seed;
    std::size_t believed = 0;
    for (std::size_t k = clean.edges.size(); k < g.edges.size(); ++k)
      believed += s.edge_weight[k] > 0;
    EXPECT_LT(believed, (g.edges.size() - clean.edges.size()) / 10) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(All, FalseClosures,
                         testing::Values(Injection{"intel", 1, 6}, Injection{"intel", 10, 6},
                                         Injection{"manhattan", 1, 1},
                                         Injection{"manhattan", 10, 3}),
                         [](const auto& param) {
                           return std::string(param.param.name) + "_run" +
                                  std::to_string(param.param.run);
                         });

}  // namespace
}  // namespace majak::io
