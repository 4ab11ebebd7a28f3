// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/optimize.hpp"

#include <gtest/gtest.h>

#include "majak/core/error.hpp"
#include "majak/graph/initialize.hpp"
#include "random_graph.hpp"
#ifdef MAJAK_HAVE_CERES
#include "ceres_twin.hpp"
#endif

namespace majak::graph {
namespace {

constexpr OptimizeOptions kExactOptions{.relative_tolerance = 1e-14};

double largest_difference(std::span<const Pose2> a, std::span<const Pose2> b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, between(a[i], b[i]).vector().cwiseAbs().maxCoeff());
  return largest;
}

TEST(Optimize, FindsTheTruthOfNoiselessMeasurementsFromAnywhere) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    RandomGraph r = random_graph(seed, 40, 20, 0);
    RandomStream random(seed);
    for (Pose2& p : r.graph.poses) p = random_pose(random, 100);
    r.graph.poses[0] = r.truth[0];
    const Summary s = optimize(r.graph);
    EXPECT_TRUE(s.converged);
    EXPECT_LT(largest_difference(r.graph.poses, r.truth), 1e-8);
  }
}

TEST(Optimize, ReachesTheOptimumThatCeresFinds) {
#ifndef MAJAK_HAVE_CERES
  GTEST_SKIP() << "Ceres is not installed (libceres-dev)";
#else
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    PoseGraph g = random_graph(seed, 30, 25, 0.1).graph;
    CeresPoses poses = ceres_poses(g);
    ceres::Problem problem;
    add_to_ceres(g, poses, problem);
    ceres::Solver::Options options;
    options.max_num_iterations = 200;
    options.function_tolerance = options.parameter_tolerance = options.gradient_tolerance = 1e-15;
    ceres::Solver::Summary theirs;
    ceres::Solve(options, &problem, &theirs);

    const Summary ours = optimize(g, kExactOptions);
    EXPECT_NEAR(ours.final_chi2, 2 * theirs.final_cost, 1e-9 * ours.final_chi2);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_NEAR(g.poses[i].x, poses[i][0], 1e-6);
      EXPECT_NEAR(g.poses[i].y, poses[i][1], 1e-6);
      EXPECT_NEAR(angle_diff(g.poses[i].theta, poses[i][2]), 0, 1e-6);
    }
  }
#endif
}

TEST(Optimize, SummaryTellsWhatTheGraphSays) {
  PoseGraph g = random_graph(1, 30, 25, 0.1).graph;
  const double before = chi2(g);
  const Summary s = optimize(g);
  EXPECT_NEAR(s.initial_chi2, before, 1e-12 * before);
  EXPECT_NEAR(s.final_chi2, chi2(g), 1e-9 * chi2(g));
  EXPECT_NEAR(s.final_cost, s.final_chi2, 1e-12 * s.final_cost);
  ASSERT_EQ(s.edge_chi2.size(), g.edges.size());
  EXPECT_NEAR(s.edge_chi2[7], chi2(g, g.edges[7]), 1e-9 * (1 + s.edge_chi2[7]));
  EXPECT_EQ(s.edge_weight, std::vector<double>(g.edges.size(), 1.0));
  EXPECT_GT(s.iterations, 0);
}

TEST(Optimize, AnchorStaysAndTheGradientVanishes) {
  PoseGraph g = random_graph(2, 30, 25, 0.1).graph;
  g.fixed = 12;
  const Pose2 anchor = g.poses[12];
  optimize(g, kExactOptions);
  EXPECT_EQ(g.poses[12], anchor);
  const double best = chi2(g);
  for (std::size_t i = 0; i < g.poses.size(); ++i)
    for (const double step : {-1e-3, 1e-3})
      for (int c = 0; c < 3 && i != 12; ++c) {
        PoseGraph moved = g;
        Vec3 v = g.poses[i].vector();
        v(c) += step;
        moved.poses[i] = from_vector(v);
        EXPECT_GT(chi2(moved), best);
      }
}

TEST(Optimize, TrivialGraphs) {
  PoseGraph none;
  EXPECT_TRUE(optimize(none).converged);
  PoseGraph one{.poses = {{1, 2, 3}}, .edges = {}};
  EXPECT_TRUE(optimize(one).converged);
  EXPECT_EQ(one.poses[0], (Pose2{1, 2, 3}));
  PoseGraph apart{.poses = {{1, 2, 3}, {4, 5, -1}, {0, 0, 0}}, .edges = {}, .fixed = 1};
  const Summary s = optimize(apart);
  EXPECT_EQ(s.final_chi2, 0);
  EXPECT_EQ(apart.poses[2], (Pose2{0, 0, 0}));
}

TEST(Optimize, EveryComponentKeepsItsFirstPose) {
  PoseGraph g = random_graph(3, 12, 5, 0.1).graph;
  const PoseGraph other = random_graph(4, 9, 5, 0.1).graph;
  PoseGraph both = g;
  both.poses.insert(both.poses.end(), other.poses.begin(), other.poses.end());
  for (Edge e : other.edges) {
    e.from += 12;
    e.to += 12;
    both.edges.push_back(e);
  }
  PoseGraph alone = other;
  const double sum =
      optimize(g, kExactOptions).final_chi2 + optimize(alone, kExactOptions).final_chi2;
  EXPECT_NEAR(optimize(both, kExactOptions).final_chi2, sum, 1e-9 * sum);
  EXPECT_EQ(both.poses[12], other.poses[0]);
  EXPECT_LT(largest_difference(std::span(both.poses).subspan(12), alone.poses), 1e-7);
}

TEST(Optimize, TwiceTheSameEdgeIsTwiceTheInformation) {
  PoseGraph twice = random_graph(5, 15, 10, 0.1).graph;
  PoseGraph strong = twice;
  twice.edges.push_back(twice.edges[16]);
  strong.edges[16].information *= 2;
  const double a = optimize(twice, kExactOptions).final_chi2,
               b = optimize(strong, kExactOptions).final_chi2;
  EXPECT_NEAR(a, b, 1e-9 * a);
  EXPECT_LT(largest_difference(twice.poses, strong.poses), 1e-7);
}

TEST(Optimize, ClosesARingAcrossPi) {
  // 36 steps of 1 m and 10 degrees, with headings through +-pi; the first and last pose are
  // neighbours.
  PoseGraph g;
  const Pose2 step{1, 0, radians(10)};
  Pose2 at{0, 0, radians(175)};
  for (int i = 0; i < 36; ++i, at = at * (step * Pose2{0.03, 0, 0.01})) {
    g.poses.push_back(at);
    g.edges.push_back({i, (i + 1) % 36, step, Mat3::Identity(), false});
  }
  optimize(g);
  EXPECT_LT(chi2(g), 1e-9);
  for (const Edge& e : g.edges)
    EXPECT_LT(residual(g.poses[e.from], g.poses[e.to], step).norm(), 1e-5);
}

TEST(Optimize, EdgeWithoutInformationIsHarmlessIfAnotherHoldsThePose) {
  PoseGraph g = random_graph(6, 10, 6, 0.1).graph;
  PoseGraph same = g;
  g.edges.push_back({2, 7, {50, 50, 1}, Mat3::Zero(), false});
  EXPECT_NEAR(optimize(g, kExactOptions).final_chi2, optimize(same, kExactOptions).final_chi2,
              1e-9);
}

TEST(Optimize, PoseHeldByNothingStaysFinite) {
  PoseGraph g = random_graph(7, 10, 0, 0.1).graph;
  g.edges[5].information = Mat3::Zero();
  const Summary s = optimize(g);
  EXPECT_LT(s.final_chi2, 1e-6);
  for (const Pose2& p : g.poses) EXPECT_TRUE(p.finite());
}

TEST(Optimize, StopsAtTheIterationLimit) {
  PoseGraph g = random_graph(8, 30, 25, 0.3).graph;
  const Summary s = optimize(g, {.max_iterations = 1, .start = Start::given});
  EXPECT_EQ(s.iterations, 1);
  EXPECT_FALSE(s.converged);
  EXPECT_LT(s.final_chi2, s.initial_chi2);
}

TEST(Optimize, UnusableGraphIsAnError) {
  PoseGraph g = random_graph(9, 5, 0, 0).graph;
  g.edges[0].information(0, 0) = -1;
  EXPECT_THROW(optimize(g), Error);
}

TEST(Optimizer, ReusedWhileTheGraphGrowsItEqualsOneCall) {
  const PoseGraph whole = random_graph(10, 80, 60, 0.05).graph;
  Optimizer optimizer({.relative_tolerance = 1e-14, .start = Start::given});
  PoseGraph g;
  for (std::size_t i = 0; i < whole.poses.size(); ++i) {
    g.poses.push_back(whole.poses[i]);
    for (const Edge& e : whole.edges)
      if (static_cast<std::size_t>(std::max(e.from, e.to)) == i) g.edges.push_back(e);
    const Summary s = optimizer.optimize(g);
    EXPECT_TRUE(s.converged);
  }
  PoseGraph once = g;
  once.poses = whole.poses;
  optimize(once, kExactOptions);
  EXPECT_LT(largest_difference(g.poses, once.poses), 1e-7);
}

TEST(Optimizer, SameInputSameBytes) {
  const PoseGraph start = random_graph(11, 100, 80, 0.1).graph;
  PoseGraph a = start, b = start, c = start;
  Optimizer optimizer;
  optimizer.optimize(a);
  optimizer.optimize(b);
  optimize(c);
  EXPECT_EQ(a.poses, b.poses);
  EXPECT_EQ(a.poses, c.poses);
}

TEST(Initialize, NeedsNoPoses) {
  RandomGraph r = random_graph(12, 60, 30, 0);
  std::fill(r.graph.poses.begin() + 1, r.graph.poses.end(), Pose2{});
  r.graph.poses[0] = r.truth[0];
  EXPECT_LT(largest_difference(initialize(r.graph), r.truth), 1e-8);
  EXPECT_LT(largest_difference(spanning_tree(r.graph), r.truth), 1e-8);
}

TEST(Initialize, FallsBackToTheSpanningTreeWhereEquationsAreSingular) {
  RandomGraph r = random_graph(13, 20, 0, 0);
  r.graph.poses[0] = r.truth[0];
  for (Edge& e : r.graph.edges) e.information = Vec3(1, 1, 0).asDiagonal();  // headings unknown
  EXPECT_LT(largest_difference(initialize(r.graph), r.truth), 1e-8);
}

TEST(SpanningTree, WalksOverTrustedEdgesFirst) {
  PoseGraph g;
  g.poses.resize(4);
  const Mat3 one = Mat3::Identity();
  g.edges = {{0, 3, {99, 0, 0}, one, true},
             {0, 1, {1, 0, 0}, one, false},
             {1, 2, {1, 0, 0}, one, false},
             {3, 2, {-1, 0, 0}, one, true},
             {1, 2, {50, 0, 0}, one, true}};
  const auto poses = spanning_tree(g);
  EXPECT_EQ(poses[1].x, 1);
  EXPECT_EQ(poses[2].x, 2);
  EXPECT_EQ(poses[3].x, 99);  // joined by doubted edges only: the first one found
}

}  // namespace
}  // namespace majak::graph
