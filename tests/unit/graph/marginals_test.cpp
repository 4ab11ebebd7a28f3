// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/marginals.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "majak/core/error.hpp"
#include "majak/graph/optimize.hpp"
#include "random_graph.hpp"

namespace majak::graph {
namespace {

/// (J' Omega J)^-1 over all poses but the anchor 0.
Eigen::MatrixXd dense_covariance(const PoseGraph& g) {
  const int n = 3 * static_cast<int>(g.poses.size());
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
  for (const Edge& e : g.edges) {
    const auto [from, to] = residual_jacobians(g.poses[e.from], g.poses[e.to], e.T_from_to);
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(3, n);
    j.middleCols<3>(3 * e.from) = from;
    j.middleCols<3>(3 * e.to) = to;
    h += j.transpose() * e.information * j;
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  covariance.bottomRightCorner(n - 3, n - 3) = h.bottomRightCorner(n - 3, n - 3).inverse();
  return covariance;
}

TEST(Marginals, AreTheDenseInverse) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    PoseGraph g = random_graph(seed, 40, 25, 0.1).graph;
    optimize(g);
    const Marginals marginals(g);
    const Eigen::MatrixXd dense = dense_covariance(g);
    for (int i = 0; i < 40; ++i) {
      EXPECT_LT((marginals.covariance(i) - dense.block<3, 3>(3 * i, 3 * i)).norm(), 1e-10);
      if (i % 7 != 3) continue;
      const auto cross = marginals.cross(i);
      for (int j = 0; j < 40; ++j)
        EXPECT_LT((cross[j] - dense.block<3, 3>(3 * j, 3 * i)).norm(), 1e-10);
    }
    Mat6 joint = marginals.joint(5, 31);
    EXPECT_LT((joint.topRightCorner<3, 3>() - dense.block<3, 3>(15, 93)).norm(), 1e-10);
    EXPECT_LT((joint - joint.transpose()).norm(), 1e-12);
  }
}

TEST(Marginals, OfOneEdgeIsItsInformationTurnedIntoTheMap) {
  RandomStream random(1);
  PoseGraph g;
  const Pose2 z{1, 2, 0.7};
  g.poses = {{4, 5, 2.0}, Pose2{4, 5, 2.0} * z};
  g.edges = {{0, 1, z, random_information(random), false}};
  const Marginals marginals(g);
  Mat3 turn = Mat3::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(2.7), -std::sin(2.7), std::sin(2.7), std::cos(2.7);
  const Mat3 own = g.edges[0].information.inverse();
  EXPECT_LT((marginals.covariance(1) - turn * own * turn.transpose()).norm(), 1e-12);
  EXPECT_LT((marginals.relative(0, 1) - own).norm(), 1e-12);
  EXPECT_EQ(marginals.covariance(0), Mat3::Zero());
}

TEST(Marginals, OfAChainAddUp) {
  // Straight line of 5 edges, sigma 0.1 m, 0.1 m, 0.01 rad: y at the end grows by the lever arms
  // too.
  PoseGraph g;
  const Mat3 information = Vec3(100, 100, 1e4).asDiagonal();
  for (int i = 0; i < 6; ++i) {
    g.poses.push_back({2.0 * i, 0, 0});
    if (i > 0) g.edges.push_back({i - 1, i, {2, 0, 0}, information, false});
  }
  const Mat3 end = Marginals(g).covariance(5);
  EXPECT_NEAR(end(0, 0), 5 * 0.01, 1e-12);
  EXPECT_NEAR(end(2, 2), 5e-4, 1e-14);
  EXPECT_NEAR(end(1, 1), 5 * 0.01 + 1e-4 * (64 + 36 + 16 + 4), 1e-12);
}

TEST(Marginals, RelativeCovarianceDoesNotDependOnTheAnchor) {
  PoseGraph g = random_graph(9, 30, 20, 0.05).graph;
  optimize(g);
  const Mat3 first = Marginals(g).relative(11, 23);
  g.fixed = 17;
  EXPECT_LT((Marginals(g).relative(11, 23) - first).norm(), 1e-10);
}

TEST(Marginals, WeightZeroTakesAnEdgeOut) {
  PoseGraph g = random_graph(10, 12, 1, 0.05).graph;
  std::vector<double> weights(g.edges.size(), 1.0);
  weights.back() = 0;
  const Marginals without(g, weights);
  g.edges.pop_back();
  for (int i = 0; i < 12; ++i)
    EXPECT_LT((without.covariance(i) - Marginals(g).covariance(i)).norm(), 1e-12);
}

TEST(Marginals, UndeterminedPoseIsAnError) {
  PoseGraph g = random_graph(11, 5, 0, 0).graph;
  g.edges[2].information = Mat3::Zero();
  EXPECT_THROW(Marginals{g}, Error);
}

TEST(Marginals, SinglePoseAndComponents) {
  PoseGraph g;
  g.poses.resize(3);
  g.edges = {{1, 2, {1, 0, 0}, Mat3::Identity(), false}};
  const Marginals marginals(g);
  EXPECT_EQ(marginals.covariance(0), Mat3::Zero());
  EXPECT_EQ(marginals.covariance(1), Mat3::Zero());
  EXPECT_GT(marginals.covariance(2)(0, 0), 0.9);
  EXPECT_EQ(marginals.joint(0, 2).topRows(3).norm(), 0);
}

}  // namespace
}  // namespace majak::graph
