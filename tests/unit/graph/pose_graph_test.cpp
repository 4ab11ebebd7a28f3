// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/pose_graph.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "majak/core/error.hpp"
#include "random_graph.hpp"

namespace majak::graph {
namespace {

using testing::HasSubstr;

PoseGraph two_poses() {
  return {.poses = {{0, 0, 0}, {1, 0, 0}}, .edges = {{0, 1, {1, 0, 0}, Mat3::Identity(), false}}};
}

std::string complaint(const PoseGraph& graph) {
  try {
    check(graph);
  } catch (const Error& e) {
    return e.what();
  }
  return "none";
}

TEST(Residual, IsZeroAtTheMeasurementAndNowhereElse) {
  RandomStream random(1);
  for (int k = 0; k < 50; ++k) {
    const Pose2 a = random_pose(random), b = random_pose(random);
    EXPECT_LT(residual(a, b, between(a, b)).norm(), 1e-12);
    EXPECT_GT(residual(a, b, between(a, b) * Pose2{0.1, 0, 0}).norm(), 0.09);
  }
}

TEST(Residual, ByHand) {
  // Seen from (1, 2) looking up, (0, 4) is 2 ahead and 1 to the left. Measured: 1 ahead, turned
  // left.
  const Vec3 e = residual({1, 2, kPi / 2}, {0, 4, kPi}, {1, 0, kPi / 2});
  EXPECT_NEAR(e.x(), 1, 1e-15);  // 1 to the left of the start is ahead of the measured heading
  EXPECT_NEAR(e.y(), -1, 1e-15);
  EXPECT_NEAR(e.z(), 0, 1e-15);
}

TEST(Residual, TurnsTheShortWayAtPi) {
  EXPECT_NEAR(residual({0, 0, kPi - 0.01}, {0, 0, -kPi + 0.01}, {0, 0, 0}).z(), 0.02, 1e-12);
  EXPECT_NEAR(residual({0, 0, 0}, {0, 0, -kPi + 0.01}, {0, 0, kPi}).z(), 0.01, 1e-12);
}

TEST(ResidualJacobians, AgreeWithDifferences) {
  RandomStream random(2);
  for (int k = 0; k < 100; ++k) {
    Pose2 a = random_pose(random), b = random_pose(random);
    const Pose2 z = random_pose(random);
    if (k == 0) a = b = {};
    const auto [from, to] = residual_jacobians(a, b, z);
    constexpr double h = 1e-6;
    for (int c = 0; c < 3; ++c) {
      const auto moved = [&](const Pose2& p, double step) {
        Vec3 v = p.vector();
        v(c) += step;
        return from_vector(v);
      };
      const auto slope = [&](const Vec3& high, const Vec3& low) {
        Vec3 d = high - low;
        d.z() = angle_diff(high.z(), low.z());
        return Vec3(d / (2 * h));
      };
      EXPECT_LT(
          (slope(residual(moved(a, h), b, z), residual(moved(a, -h), b, z)) - from.col(c)).norm(),
          1e-7);
      EXPECT_LT(
          (slope(residual(a, moved(b, h), z), residual(a, moved(b, -h), z)) - to.col(c)).norm(),
          1e-7);
    }
  }
}

TEST(Chi2, UsesTheWholeInformation) {
  PoseGraph g = two_poses();
  g.poses[1] = {1 + 1, 2, 0.5};  // error (1, 2, 0.5)
  g.edges[0].information << 4, 1, 2, 1, 5, 3, 2, 3, 6;
  // 4 + 5*4 + 6/4 + 2*(1*2 + 2*0.5 + 3*2*0.5)
  EXPECT_NEAR(chi2(g), 25.5 + 12, 1e-12);
  g.edges.push_back(g.edges[0]);
  EXPECT_NEAR(chi2(g), 2 * 37.5, 1e-12);
}

TEST(Check, AcceptsUsableGraphs) {
  EXPECT_EQ(complaint({}), "none");
  EXPECT_EQ(complaint(two_poses()), "none");
  PoseGraph weak = two_poses();
  weak.edges[0].information = Mat3::Zero();
  EXPECT_EQ(complaint(weak), "none");
  weak.edges[0].information = Vec3(1e9, 1e-3, 0) * Vec3(1e9, 1e-3, 0).transpose();  // rank one
  EXPECT_EQ(complaint(weak), "none");
}

TEST(Check, NamesWhatIsWrong) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  const auto with = [](auto change) {
    PoseGraph g = two_poses();
    change(g);
    return complaint(g);
  };
  EXPECT_THAT(with([](auto& g) { g.poses[1].theta = nan; }), HasSubstr("pose 1 is not finite"));
  EXPECT_THAT(with([](auto& g) { g.fixed = 2; }), HasSubstr("fixed pose 2"));
  EXPECT_THAT(with([](auto& g) { g.fixed = -1; }), HasSubstr("fixed pose -1"));
  EXPECT_THAT(with([](auto& g) { g.edges[0].to = 2; }), HasSubstr("edge 0 (0 to 2) names a pose"));
  EXPECT_THAT(with([](auto& g) { g.edges[0].from = -3; }), HasSubstr("does not exist"));
  EXPECT_THAT(with([](auto& g) { g.edges[0].to = 0; }), HasSubstr("to itself"));
  EXPECT_THAT(with([](auto& g) { g.edges[0].T_from_to.x = inf; }), HasSubstr("measurement"));
  EXPECT_THAT(with([](auto& g) { g.edges[0].information(2, 1) = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(with([](auto& g) { g.edges[0].information(0, 1) = 0.5; }),
              HasSubstr("not symmetric"));
  EXPECT_THAT(with([](auto& g) { g.edges[0].information(2, 2) = -1; }), HasSubstr("semi-definite"));
  EXPECT_THAT(
      with([](auto& g) { g.edges[0].information(0, 1) = g.edges[0].information(1, 0) = 2; }),
      HasSubstr("semi-definite"));
  // each pair of directions is consistent, all three are not
  EXPECT_THAT(
      with([](auto& g) { g.edges[0].information << 1, -0.9, -0.9, -0.9, 1, -0.9, -0.9, -0.9, 1; }),
      HasSubstr("semi-definite"));
}

TEST(Anchors, OneForEachComponent) {
  PoseGraph g;
  EXPECT_TRUE(anchors(g).empty());
  g.poses.resize(7);
  for (const auto& [a, b] : {std::pair{1, 4}, {4, 6}, {5, 2}})
    g.edges.push_back({a, b, {}, Mat3::Identity(), false});
  EXPECT_EQ(anchors(g), (std::vector{0, 1, 2, 3}));
  g.fixed = 6;
  EXPECT_EQ(anchors(g), (std::vector{0, 2, 3, 6}));
}

TEST(TrustedEdges, ConnectOnlyIfNoRobustEdgeIsABridge) {
  PoseGraph g;
  g.poses.resize(3);
  g.edges = {{0, 1, {}, Mat3::Identity(), false}, {0, 1, {}, Mat3::Identity(), true}};
  EXPECT_TRUE(trusted_edges_connect(g));
  g.edges.push_back({1, 2, {}, Mat3::Identity(), true});
  EXPECT_FALSE(trusted_edges_connect(g));
}

}  // namespace
}  // namespace majak::graph
