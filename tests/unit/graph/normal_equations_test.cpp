// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/normal_equations.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "random_graph.hpp"

namespace majak::graph {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// J' Omega J and -J' Omega e over all poses, from the textbook derivatives.
struct Dense {
  MatrixXd h;
  VectorXd b;
};
Dense dense(const PoseGraph& g, std::span<const double> weights = {}) {
  const int n = 3 * static_cast<int>(g.poses.size());
  Dense d{MatrixXd::Zero(n, n), VectorXd::Zero(n)};
  for (std::size_t k = 0; k < g.edges.size(); ++k) {
    const Edge& e = g.edges[k];
    const auto [from, to] = residual_jacobians(g.poses[e.from], g.poses[e.to], e.T_from_to);
    MatrixXd j = MatrixXd::Zero(3, n);
    j.middleCols<3>(3 * e.from) = from;
    j.middleCols<3>(3 * e.to) = to;
    const Mat3 w = (weights.empty() ? 1.0 : weights[k]) * e.information;
    d.h += j.transpose() * w * j;
    d.b -= j.transpose() * w * residual(g.poses[e.from], g.poses[e.to], e.T_from_to);
  }
  for (const int a : anchors(g)) {
    d.h.middleRows<3>(3 * a).setZero();
    d.h.middleCols<3>(3 * a).setZero();
    d.h.block<3, 3>(3 * a, 3 * a).setIdentity();
    d.b.segment<3>(3 * a).setZero();
  }
  return d;
}

void expect_same_step(const PoseGraph& g, NormalEquations& equations,
                      std::span<const double> weights) {
  equations.set(g);
  const double sum = equations.linearize(g.poses, weights);
  std::vector<double> dx;
  ASSERT_TRUE(equations.solve(0, dx));
  const Dense d = dense(g, weights);
  const VectorXd expected = d.h.llt().solve(d.b);
  const VectorXd got = Eigen::Map<VectorXd>(dx.data(), static_cast<Eigen::Index>(dx.size()));
  EXPECT_LT((got - expected).norm(), 1e-9 * (1 + expected.norm()));
  EXPECT_NEAR(sum, equations.weighted_chi2(g.poses, weights), 1e-9 * sum);
  EXPECT_NEAR(equations.predicted_decrease(dx, 0), d.b.dot(expected), 1e-8 * sum);
}

TEST(NormalEquations, StepIsTheTextbookOne) {
  NormalEquations equations;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    PoseGraph g = random_graph(seed, 2 + 3 * static_cast<int>(seed), 12, 0.3).graph;
    g.fixed = static_cast<int>(seed) % static_cast<int>(g.poses.size());
    expect_same_step(g, equations, {});
    std::vector<double> weights(g.edges.size());
    RandomStream random(seed);
    for (double& w : weights) w = random.uniform(0.1, 2);
    expect_same_step(g, equations, weights);
  }
}

TEST(NormalEquations, MeasurementsChangeWithoutNewStructure) {
  NormalEquations equations;
  PoseGraph g = random_graph(3, 20, 10, 0.1).graph;
  expect_same_step(g, equations, {});
  for (Edge& e : g.edges) e.T_from_to = e.T_from_to * Pose2{0.3, -0.2, 3.0};
  expect_same_step(g, equations, {});
  std::swap(g.edges[4].from, g.edges[4].to);  // new structure, same size
  expect_same_step(g, equations, {});
}

TEST(NormalEquations, EdgeChi2IsTheTextbookOne) {
  const PoseGraph g = random_graph(4, 30, 20, 0.5).graph;
  NormalEquations equations;
  equations.set(g);
  std::vector<double> values(g.edges.size());
  equations.edge_chi2(g.poses, values);
  for (std::size_t k = 0; k < values.size(); ++k)
    EXPECT_NEAR(values[k], chi2(g, g.edges[k]), 1e-9 * (1 + values[k]));
}

TEST(NormalEquations, PredictionIsTheLinearModelsAlsoWithDamping) {
  const PoseGraph g = random_graph(5, 15, 10, 0.3).graph;
  NormalEquations equations;
  equations.set(g);
  equations.linearize(g.poses);
  std::vector<double> dx;
  ASSERT_TRUE(equations.solve(0.7, dx));
  const Dense d = dense(g);
  const VectorXd x = Eigen::Map<VectorXd>(dx.data(), static_cast<Eigen::Index>(dx.size()));
  EXPECT_NEAR(equations.predicted_decrease(dx, 0.7), 2 * d.b.dot(x) - x.dot(d.h * x),
              1e-9 * chi2(g));
}

TEST(NormalEquations, RotationsOfConsistentEdgesAreExact) {
  RandomGraph r = random_graph(6, 25, 10, 0);
  NormalEquations equations;
  equations.set(r.graph);
  equations.build_rotations(r.truth);
  std::vector<double> z;
  ASSERT_TRUE(equations.solve(0, z));
  for (std::size_t i = 1; i < r.truth.size(); ++i) {
    EXPECT_NEAR(z[3 * i], std::cos(r.truth[i].theta), 1e-10);
    EXPECT_NEAR(z[3 * i + 1], std::sin(r.truth[i].theta), 1e-10);
  }
}

TEST(NormalEquations, PositionsComeInOneStepFromRightHeadings) {
  RandomGraph r = random_graph(7, 25, 10, 0);
  NormalEquations equations;
  equations.set(r.graph);
  std::vector<Pose2> poses = r.truth;
  RandomStream random(1);
  for (std::size_t i = 1; i < poses.size(); ++i)
    poses[i].x = random.uniform(-100, 100), poses[i].y = 7;
  equations.linearize_positions(poses);
  std::vector<double> dx;
  ASSERT_TRUE(equations.solve(0, dx));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(poses[i].x + dx[3 * i], r.truth[i].x, 1e-9);
    EXPECT_NEAR(poses[i].y + dx[3 * i + 1], r.truth[i].y, 1e-9);
    EXPECT_NEAR(dx[3 * i + 2], 0, 1e-10);
  }
}

}  // namespace
}  // namespace majak::graph
