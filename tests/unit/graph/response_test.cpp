// SPDX-License-Identifier: Apache-2.0
// How an optimum answers to wrong measurements: one solve against optimising again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/graph/marginals.hpp"
#include "majak/graph/optimize.hpp"
#include "random_graph.hpp"

namespace majak::graph {
namespace {

constexpr int kPoses = 14;

/// A graph at its optimum; without noise of the measurements the residuals there are zero.
PoseGraph optimal_graph(std::uint64_t seed, double noise) {
  PoseGraph g = random_graph(seed, kPoses, 9, noise).graph;
  optimize(g, {.relative_tolerance = 1e-15});
  return g;
}

std::vector<Vec3> random_shifts(const PoseGraph& g, std::uint64_t seed) {
  RandomStream r(seed, 1);
  std::vector<Vec3> shifts;
  for (std::size_t k = 0; k < g.edges.size(); ++k)
    shifts.emplace_back(r.normal(), r.normal(), r.normal());
  return shifts;
}

std::vector<Pose2> optimum_with(PoseGraph g, const std::vector<Vec3>& shifts, double share) {
  for (std::size_t k = 0; k < shifts.size(); ++k)
    g.edges[k].T_from_to = g.edges[k].T_from_to * exp(share * shifts[k]);
  optimize(g, {.relative_tolerance = 1e-15});
  return g.poses;
}

/// The slow twin: the graph is optimised again with measurements shifted either way.
std::vector<Vec3> moved(const PoseGraph& g, const std::vector<Vec3>& shifts) {
  constexpr double kShare = 1e-4;
  const auto ahead = optimum_with(g, shifts, kShare), back = optimum_with(g, shifts, -kShare);
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < ahead.size(); ++i)
    result.emplace_back(Vec3(ahead[i].x - back[i].x, ahead[i].y - back[i].y,
                             angle_diff(ahead[i].theta, back[i].theta)) /
                        (2 * kShare));
  return result;
}

double off(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}

double size(const std::vector<Vec3>& a) { return off(a, std::vector<Vec3>(a.size(), {0, 0, 0})); }

TEST(Response, IsHowTheOptimumMoves) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const PoseGraph g = optimal_graph(seed, 0);
    const auto shifts = random_shifts(g, seed);
    const auto slow = moved(g, shifts);
    ASSERT_GT(size(slow), 0.1);
    EXPECT_LT(off(Marginals(g).response(g, shifts), slow), 1e-4 * size(slow));
  }
}

TEST(Response, IsNearlySoWhereTheMeasurementsContradict) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const PoseGraph g = optimal_graph(seed, 0.02);
    ASSERT_GT(chi2(g), 0.1);
    const auto shifts = random_shifts(g, seed);
    const auto slow = moved(g, shifts);
    EXPECT_LT(off(Marginals(g).response(g, shifts), slow), 0.1 * size(slow));
  }
}

TEST(Response, OfOneEdgeIsItsShiftTurnedIntoTheMap) {
  PoseGraph g;
  const Pose2 z{1, 2, 0.7};
  g.poses = {{4, 5, 2.0}, Pose2{4, 5, 2.0} * z};
  g.edges = {{0, 1, z, Vec3(10, 20, 30).asDiagonal(), false}};
  const std::vector<Vec3> shifts{{1, 0, 0.5}};
  const auto response = Marginals(g).response(g, shifts);
  EXPECT_EQ(response[0], Vec3(0, 0, 0));
  EXPECT_LT((response[1] - Vec3(std::cos(2.7), std::sin(2.7), 0.5)).norm(), 1e-12);
}

TEST(Response, IsLinearInTheShifts) {
  const PoseGraph g = optimal_graph(5, 0.05);
  const Marginals marginals(g);
  const auto a = random_shifts(g, 1), b = random_shifts(g, 2);
  std::vector<Vec3> both;
  for (std::size_t k = 0; k < a.size(); ++k) both.emplace_back(2 * a[k] - 3 * b[k]);
  const auto of_a = marginals.response(g, a), of_b = marginals.response(g, b);
  std::vector<Vec3> sum;
  for (std::size_t i = 0; i < of_a.size(); ++i) sum.emplace_back(2 * of_a[i] - 3 * of_b[i]);
  EXPECT_LT(off(marginals.response(g, both), sum), 1e-10 * size(sum));
}

TEST(Response, OfSomeEdgesIsThatOfAllWithTheOthersStill) {
  const PoseGraph g = optimal_graph(8, 0.05);
  const Marginals marginals(g);
  const std::size_t first = 3, last = 9;
  auto shifts = random_shifts(g, 4);
  ASSERT_GT(shifts.size(), last);
  const std::vector<Vec3> some(shifts.begin() + first, shifts.begin() + last);
  for (std::size_t k = 0; k < shifts.size(); ++k)
    if (k < first || k >= last) shifts[k].setZero();
  EXPECT_EQ(marginals.response(g, first, some), marginals.response(g, shifts));
}

TEST(Response, ToNothingIsNothing) {
  const PoseGraph g = optimal_graph(6, 0.05);
  const Marginals marginals(g);
  EXPECT_EQ(size(marginals.response(g, std::vector<Vec3>(g.edges.size(), {0, 0, 0}))), 0);
  // The anchor answers to nothing at all.
  EXPECT_EQ(marginals.response(g, random_shifts(g, 3))[0], Vec3(0, 0, 0));
}

TEST(Response, ToShiftsThatAgreeIsThatMotion) {
  // Each measurement is shifted to where a second set of poses would have it: those are the answer.
  PoseGraph g = optimal_graph(7, 0);
  RandomStream r(8);
  constexpr double kSmall = 1e-6;
  std::vector<Pose2> other = g.poses;
  for (std::size_t i = 1; i < other.size(); ++i)
    other[i] = from_vector(g.poses[i].vector() + kSmall * Vec3(r.normal(), r.normal(), r.normal()));
  std::vector<Vec3> shifts, truly;
  for (const Edge& e : g.edges)
    shifts.emplace_back(log(between(e.T_from_to, between(other[e.from], other[e.to]))) / kSmall);
  for (std::size_t i = 0; i < other.size(); ++i)
    truly.emplace_back(Vec3(other[i].x - g.poses[i].x, other[i].y - g.poses[i].y,
                            angle_diff(other[i].theta, g.poses[i].theta)) /
                       kSmall);
  EXPECT_LT(off(Marginals(g).response(g, shifts), truly), 1e-4);
}

}  // namespace
}  // namespace majak::graph
