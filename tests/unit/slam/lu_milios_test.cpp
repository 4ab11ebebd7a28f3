// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/lu_milios.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/graph/marginals.hpp"
#include "majak/graph/optimize.hpp"
#include "tests/unit/slam/simulated.hpp"

namespace majak::slam {
namespace {

/// A walk of n poses with a relation a step and as many between others, all with noise of their
/// own covariance; the guess has drifted.
struct Problem {
  std::vector<graph::Edge> relations;
  std::vector<Pose2> guess;
};
Mat3 random_information(RandomStream& r) {
  Mat3 a;
  for (int i = 0; i < 9; ++i) a.data()[i] = r.normal();
  const Mat3 sigma = Vec3(0.02, 0.02, 0.01).asDiagonal();
  const Mat3 covariance = sigma * (a * a.transpose() + 0.3 * Mat3::Identity()) * sigma;
  const Mat3 information = covariance.inverse();
  return 0.5 * (information + information.transpose());
}
Problem random_problem(int poses, std::uint64_t seed) {
  RandomStream r(seed);
  std::vector<Pose2> truth{{3, -2, 0.4}};
  for (int i = 1; i < poses; ++i)
    truth.push_back(truth.back() * exp(Vec3(0.5, 0.05 * r.normal(), 0.11 + 0.1 * r.normal())));
  Problem p;
  const auto relate = [&](int from, int to) {
    const Mat3 information = random_information(r);
    const Vec3 white(r.normal(), r.normal(), r.normal());
    const Vec3 error = information.llt().matrixU().solve(white);
    const Pose2 T =
        between(truth[static_cast<std::size_t>(from)], truth[static_cast<std::size_t>(to)]);
    p.relations.push_back({from, to, T * exp(error), information, false});
  };
  for (int i = 1; i < poses; ++i) relate(i - 1, i);
  for (int i = 2; i < poses; ++i) {
    const int from = static_cast<int>(r.below(static_cast<std::uint64_t>(i - 1)));
    if (i % 2 == 0)
      relate(from, i);
    else
      relate(i, from);
  }
  p.guess.push_back(truth.front());
  for (int i = 1; i < poses; ++i)
    p.guess.push_back(p.guess.back() * p.relations[static_cast<std::size_t>(i - 1)].T_from_to);
  return p;
}

double farthest(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max({most, (a[i].translation() - b[i].translation()).norm(),
                     std::abs(angle_diff(a[i].theta, b[i].theta))});
  return most;
}

graph::PoseGraph optimum(const std::vector<graph::Edge>& relations, std::vector<Pose2> guess) {
  graph::PoseGraph graph{std::move(guess), relations, 0};
  graph::optimize(graph, {.relative_tolerance = 1e-14, .start = graph::Start::given});
  return graph;
}

// The paper's own words, dense: D = V_a less V_b in b's frame, its error in b's axes with the
// covariance turned there, derivatives by differences.
std::vector<Pose2> dense_twin(const Problem& p, Eigen::MatrixXd& covariance) {
  std::vector<Pose2> poses = p.guess;
  const auto n = static_cast<Eigen::Index>(3 * poses.size() - 3);
  const auto error = [&](const graph::Edge& r, const std::vector<Pose2>& v) {
    const Pose2 d = between(v[static_cast<std::size_t>(r.from)], v[static_cast<std::size_t>(r.to)]);
    return Vec3(d.x - r.T_from_to.x, d.y - r.T_from_to.y, angle_diff(d.theta, r.T_from_to.theta));
  };
  for (int round = 0; round < 12; ++round) {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (const graph::Edge& r : p.relations) {
      Eigen::MatrixXd j = Eigen::MatrixXd::Zero(3, n);
      for (const int pose : {r.from, r.to})
        for (int c = 0; c < 3 && pose > 0; ++c) {
          constexpr double kStep = 1e-6;
          std::vector<Pose2> up = poses, down = poses;
          Vec3 step = Vec3::Zero();
          step(c) = kStep;
          const auto at = static_cast<std::size_t>(pose);
          up[at] = from_vector(up[at].vector() + step);
          down[at] = from_vector(down[at].vector() - step);
          j.col(3 * pose - 3 + c) = (error(r, up) - error(r, down)) / (2 * kStep);
        }
      const Mat3 turn = adjoint({0, 0, r.T_from_to.theta});
      const Mat3 information = turn * r.information * turn.transpose();
      h += j.transpose() * information * j;
      b -= j.transpose() * information * error(r, poses);
    }
    const Eigen::VectorXd step = h.ldlt().solve(b);
    for (std::size_t i = 1; i < poses.size(); ++i)
      poses[i] =
          from_vector(poses[i].vector() + step.segment<3>(static_cast<Eigen::Index>(3 * i - 3)));
    covariance = h.inverse();
  }
  return poses;
}

TEST(LuMilios, EqualsThePoseGraphsOptimumOnSixtyScans) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Problem p = random_problem(60, seed);
    const ConsistentPoses consistent = consistent_poses(p.relations, p.guess);
    ASSERT_TRUE(consistent.converged) << seed;
    const graph::PoseGraph best = optimum(p.relations, p.guess);
    EXPECT_LT(farthest(consistent.poses, best.poses), 1e-6) << seed;
    EXPECT_GT(farthest(consistent.poses, p.guess), 0.01) << seed;
    const graph::Marginals marginals({consistent.poses, p.relations, 0});
    for (int i = 0; i < 60; ++i) {
      const Mat3& expected = marginals.covariance(i);
      EXPECT_LT((consistent.covariances[static_cast<std::size_t>(i)] - expected).norm(),
                1e-9 * expected.norm() + 1e-300)
          << seed << " pose " << i;
    }
  }
}

TEST(LuMilios, EqualsTheDenseSystem) {
  const Problem p = random_problem(25, 7);
  Eigen::MatrixXd covariance;
  const std::vector<Pose2> twin = dense_twin(p, covariance);
  const ConsistentPoses consistent = consistent_poses(p.relations, p.guess);
  EXPECT_LT(farthest(consistent.poses, twin), 1e-8);
  for (Eigen::Index i = 1; i < 25; ++i) {
    const Mat3 expected = covariance.block<3, 3>(3 * i - 3, 3 * i - 3);
    EXPECT_LT((consistent.covariances[static_cast<std::size_t>(i)] - expected).norm(),
              1e-6 * expected.norm());
  }
}

// One linear problem: with all headings known and alike, a single solve is exact.
TEST(LuMilios, OneRoundIsEnoughWithoutTurns) {
  std::vector<graph::Edge> relations;
  const Mat3 information = Vec3(100, 400, 1e12).asDiagonal();
  for (int i = 0; i < 3; ++i)
    relations.push_back({i, i + 1, {1.0 + 0.1 * i, 0.2, 0}, information, false});
  relations.push_back({0, 3, {3.6, 0.6, 0}, information, false});
  const ConsistentPoses once =
      consistent_poses(relations, {{}, {9, 9, 0}, {-5, 3, 0}, {1, 1, 0}}, {.max_rounds = 1});
  // 0.3 m too much in x, shared alike by four equal relations
  EXPECT_NEAR(once.poses[3].x, 3.3 + 0.3 * 3 / 4, 1e-9);
  EXPECT_NEAR(once.poses[1].x, 1.0 + 0.3 / 4, 1e-9);
  EXPECT_NEAR(once.poses[3].y, 0.6, 1e-9);
}

TEST(LuMilios, AnOpenPoseIsAnError) {
  const std::vector<graph::Edge> relations{{0, 1, {}, Mat3::Identity(), false}};
  EXPECT_THROW(consistent_poses(relations, {{}, {}, {}}), Error);
  EXPECT_THROW(consistent_poses(relations, {{}}), Error);
}

TEST(LuMilios, OnePoseStandsStill) {
  const ConsistentPoses one = consistent_poses({}, {{1, 2, 3}});
  EXPECT_TRUE(one.converged);
  ASSERT_EQ(one.covariances.size(), 1U);
  EXPECT_TRUE(one.covariances[0].isZero());
}

Mapping mapped(const std::vector<Event>& events, const LuMiliosOptions& options = {},
               int threads = 1) {
  LuMilios method({}, options, {threads});
  for (const Event& event : events) EXPECT_FALSE(method.add(event));
  return method.finish();
}

const Mapping& building() {
  static const Mapping mapping = mapped(building_run());
  return mapping;
}

TEST(LuMilios, MapsABuilding) {
  const Mapping& mapping = building();
  EXPECT_TRUE(mapping.posterior);
  EXPECT_TRUE(mapping.corrections.empty());
  const PathError error = error_of(mapping.site), front = front_end_error_of(mapping.site);
  EXPECT_LT(error.rms, 0.5 * front.rms);
  EXPECT_LT(error.worst, 0.5 * front.worst);
  for (const PosedScan& s : mapping.site.scans) {
    ASSERT_TRUE(s.estimate.covariance.allFinite());
    ASSERT_GE(s.estimate.covariance.determinant(), 0);
  }
}

// The relations of a whole run: the poses that the method left are the pose graph's optimum.
TEST(LuMilios, OfARunEqualsThePoseGraphsOptimum) {
  const Site& site = building().site;
  graph::PoseGraph graph;
  std::vector<int> pose_of(site.scans.size(), -1);
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    if (!site.scans[i].key) continue;
    pose_of[i] = static_cast<int>(graph.poses.size());
    graph.poses.push_back(site.scans[i].estimate.T_map_robot);
  }
  for (const Constraint& c : site.constraints)
    graph.edges.push_back({pose_of[c.from], pose_of[c.to], c.T_from_to, c.information, false});
  const std::vector<Pose2> left = graph.poses;
  EXPECT_GT(graph.edges.size(), 4 * left.size());
  graph::optimize(graph, {.relative_tolerance = 1e-14, .start = graph::Start::given});
  EXPECT_LT(farthest(graph.poses, left), 1e-6);
}

TEST(LuMilios, SameForAnyNumberOfThreads) {
  const Mapping one = mapped(building_run(), {.rounds = 1}),
                two = mapped(building_run(), {.rounds = 1}, 2);
  for (std::size_t i = 0; i < one.site.scans.size(); ++i) {
    ASSERT_EQ(one.site.scans[i].estimate.T_map_robot, two.site.scans[i].estimate.T_map_robot);
    ASSERT_EQ(one.site.scans[i].estimate.covariance, two.site.scans[i].estimate.covariance);
  }
}

}  // namespace
}  // namespace majak::slam
