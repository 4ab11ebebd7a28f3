// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/triangulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "tests/unit/beacon/scatter.hpp"

namespace majak::beacon {
namespace {

const std::vector<Vec2> kThree = {{0, 0}, {20, 2}, {8, 19}};
const std::vector<Vec2> kTen = {{0, 0},   {20, 2}, {8, 19},  {-3, 12}, {23, 14},
                                {12, -4}, {2, 22}, {18, 24}, {-5, 4},  {26, 7}};
constexpr double kSigma = 0.001;  // rad

std::vector<BearingTo> exact(const std::vector<Vec2>& beacons, const Pose2& pose,
                             double sigma = kSigma) {
  std::vector<BearingTo> out;
  for (const Vec2& b : beacons) {
    const Vec2 way = b - pose.translation();
    out.push_back({b, angle_diff(std::atan2(way.y(), way.x()), pose.theta), sigma});
  }
  return out;
}

std::vector<BearingTo> noisy(std::vector<BearingTo> bearings, RandomStream& random) {
  for (BearingTo& m : bearings) m.bearing += m.sigma * random.normal();
  return bearings;
}

Vec3 error(const Triangulation& fix, const Pose2& truth) {
  return {fix.T_map_sensor.x - truth.x, fix.T_map_sensor.y - truth.y,
          angle_diff(fix.T_map_sensor.theta, truth.theta)};
}

Pose2 anywhere(RandomStream& random) {
  return {random.uniform(0, 20), random.uniform(0, 20), random.uniform(-kPi, kPi)};
}

/// Distance from the circle through three points, positive outside.
double outside_circle(const std::vector<Vec2>& b, const Vec2& p) {
  const Vec2 u = b[1] - b[0], v = b[2] - b[0];
  const double d = 2 * (u.x() * v.y() - u.y() * v.x());
  const Vec2 c = Vec2(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                      u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) /
                 d;
  return (p - b[0] - c).norm() - c.norm();
}

TEST(Triangulation, IsExactInAnyOrder) {
  RandomStream random(1);
  int near_circle = 0;
  for (int i = 0; i < 2000; ++i) {
    const Pose2 pose = anywhere(random);
    if (std::abs(outside_circle(kThree, pose.translation())) < 0.5) {
      ++near_circle;
      continue;
    }
    auto bearings = exact(kThree, pose, 1e-5);
    std::array<int, 3> order = {0, 1, 2};
    do {
      const auto fix =
          triangulate(std::array{bearings[order[0]], bearings[order[1]], bearings[order[2]]});
      EXPECT_EQ(fix.problem, FixProblem::none) << pose.vector().transpose();
      EXPECT_LT(error(fix, pose).norm(), 1e-11);  // seen: 1.2e-12
    } while (std::next_permutation(order.begin(), order.end()));
  }
  EXPECT_LT(near_circle, 300);
}

TEST(Triangulation, WhereCotangentsHaveNoValue) {
  // Bearings that differ by 0 and by half a turn: between two beacons, and behind one another.
  for (const Pose2& pose : {Pose2{10, 0, 0.3}, Pose2{-10, 0, 3}, Pose2{0, 7, -kPi / 2}}) {
    const auto fix = triangulate(exact({{0, 0}, {20, 0}, {3, 15}}, pose));
    EXPECT_EQ(fix.problem, FixProblem::none);
    EXPECT_LT(error(fix, pose).norm(), 1e-12);
  }
}

TEST(Triangulation, BeaconsInALineWillDoBesideIt) {
  const Pose2 pose{4, 6, 2};
  const auto fix = triangulate(exact({{0, 0}, {5, 0}, {12, 0}}, pose));
  EXPECT_EQ(fix.problem, FixProblem::none);
  EXPECT_LT(error(fix, pose).norm(), 1e-12);
  EXPECT_EQ(triangulate(exact({{0, 0}, {5, 0}, {12, 0}}, {3, 0, 1})).problem,
            FixProblem::ill_conditioned);
  EXPECT_EQ(triangulate(exact({{0, 0}, {5, 0}, {12, 0}, {14, 0}, {15, 0}}, {3, 0, 1})).problem,
            FixProblem::ill_conditioned);
}

TEST(Triangulation, ManyBearingsWithoutNoise) {
  RandomStream random(2);
  for (int i = 0; i < 1000; ++i) {
    const Pose2 pose = anywhere(random);
    const auto fix = triangulate(exact(kTen, pose, 1e-5));
    EXPECT_EQ(fix.problem, FixProblem::none);
    EXPECT_LT(error(fix, pose).norm(), 1e-12);
    EXPECT_EQ(fix.dof, 7);
  }
}

TEST(Triangulation, OfARing) {
  // n beacons at distance r around: position H = n / (2 r^2) I, heading n.
  std::vector<Vec2> ring;
  for (int i = 0; i < 6; ++i)
    ring.push_back(5 * Vec2(std::cos(i * kPi / 3), std::sin(i * kPi / 3)));
  const auto fix = triangulate(exact(ring, {0, 0, 0.4}, 0.01));
  EXPECT_NEAR(fix.covariance(0, 0), 1e-4 * 2 * 25 / 6.0, 1e-12);
  EXPECT_NEAR(fix.covariance(2, 2), 1e-4 / 6, 1e-15);
  EXPECT_NEAR(fix.dop, 5 * std::sqrt(4.0 / 6), 1e-9);
  EXPECT_NEAR(fix.conditioning, std::sqrt(6.0) / 2, 1e-9);
}

TEST(Triangulation, ScatterIsTheStatedCovarianceOverAFieldOrItIsReported) {
  int reported = 0;
  for (int place = 0; place < 49; ++place) {
    const Pose2 pose{3.2 * (place % 7) + 0.5, 3.2 * (place / 7) + 0.5, 0.4 * place - 10};
    const auto bearings = exact(kThree, pose);
    const auto stated = triangulate(bearings);
    if (stated.problem == FixProblem::ill_conditioned) {
      // Near the circle, or beside a beacon.
      EXPECT_LT(std::abs(outside_circle(kThree, pose.translation())), 1.5);
      ++reported;
      continue;
    }
    ASSERT_EQ(stated.problem, FixProblem::none);
    Scatter<3> scatter(stated.covariance);
    RandomStream random(3, place);
    for (int i = 0; i < 20000; ++i) scatter.add(error(triangulate(noisy(bearings, random)), pose));
    EXPECT_LT(scatter.difference(), 0.05)
        << pose.vector().transpose() << " " << stated.nonlinearity;
  }
  EXPECT_GT(reported, 0);
  EXPECT_LT(reported, 20);
}

TEST(Triangulation, ScatterOfManyIsTheStatedCovarianceOverAField) {
  for (int place = 0; place < 9; ++place) {
    const Pose2 pose{10.0 * (place % 3), 9.0 * (place / 3) + 1, 0.4 * place - 2};
    const auto bearings = exact(kTen, pose);
    Scatter<3> scatter(triangulate(bearings).covariance);
    RandomStream random(4, place);
    int refused = 0;
    for (int i = 0; i < 20000; ++i) {
      const auto fix = triangulate(noisy(bearings, random));
      refused += fix.problem != FixProblem::none;
      if (fix.problem == FixProblem::none) scatter.add(error(fix, pose));
    }
    EXPECT_LT(refused, 20);
    EXPECT_LT(scatter.difference(), 0.05) << pose.vector().transpose();
  }
}

TEST(Triangulation, OnTheDangerCircleIsReported) {
  // The circle through (0,0), (10,0), (0,10) has its centre at (5,5).
  const std::vector<Vec2> beacons = {{0, 0}, {10, 0}, {0, 10}};
  const double radius = 5 * std::sqrt(2.0);
  double last = 0;
  for (const double outside : {0.0, 0.01, 0.1, 1.0, 2.0, 3.0}) {
    const Vec2 p = Vec2(5, 5) + (radius + outside) * Vec2(std::cos(0.6), std::sin(0.6));
    const auto fix = triangulate(exact(beacons, {p.x(), p.y(), 1}, 5e-4));
    if (outside < 0.2) {
      EXPECT_EQ(fix.problem, FixProblem::ill_conditioned) << outside;
    } else if (outside > 2) {
      EXPECT_EQ(fix.problem, FixProblem::none) << outside << " " << fix.nonlinearity;
    }
    EXPECT_GE(fix.conditioning, last);
    last = fix.conditioning;
  }
  EXPECT_NEAR(last, 0.094, 0.001);
  // A beacon off the circle removes the danger.
  const Vec2 p = Vec2(5, 5) + radius * Vec2(std::cos(0.6), std::sin(0.6));
  const auto fix = triangulate(exact({{0, 0}, {10, 0}, {0, 10}, {15, 15}}, {p.x(), p.y(), 1}));
  EXPECT_EQ(fix.problem, FixProblem::none);
}

TEST(Triangulation, GrossErrorsLeaveTheResultWithinItsEllipse) {
  RandomStream random(5);
  int inside = 0, found = 0;
  constexpr int kRuns = 2000;
  for (int run = 0; run < kRuns; ++run) {
    const Pose2 pose = anywhere(random);
    auto bearings = noisy(exact(kTen, pose), random);
    for (const int i : {run % 10, (run / 10) % 10}) bearings[i].bearing = random.uniform(-kPi, kPi);
    const auto fix = triangulate(bearings);
    if (fix.problem != FixProblem::none) continue;
    ++found;
    const Vec3 e = error(fix, pose);
    inside += e.dot(fix.covariance.inverse() * e) < 7.815;  // 95 %, 3 dof
  }
  EXPECT_GT(found, 0.995 * kRuns);
  EXPECT_GT(inside, 0.935 * found);
  EXPECT_LT(inside, 0.965 * found);
}

TEST(Triangulation, SaysWhichBearingsAreGross) {
  auto bearings = exact(kTen, {6, 7, 1});
  bearings[3].bearing += 0.5;
  bearings[8].bearing -= 2;
  const auto fix = triangulate(bearings);
  EXPECT_EQ(fix.used, Mask{0b1011110111});
  EXPECT_LT(error(fix, {6, 7, 1}).norm(), 1e-12);
}

TEST(Triangulation, GivesEqualBytesTwice) {
  RandomStream random(6);
  auto bearings = noisy(exact(kTen, {6, 7, 1}), random);
  bearings[3].bearing += 0.5;
  const auto a = triangulate(bearings), b = triangulate(bearings);
  EXPECT_EQ(a.T_map_sensor, b.T_map_sensor);
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(Triangulation, BadInput) {
  const Pose2 pose{3, 4, 1};
  EXPECT_EQ(triangulate({}).problem, FixProblem::too_few);
  EXPECT_EQ(triangulate(exact({{0, 0}, {9, 1}}, pose)).problem, FixProblem::too_few);
  EXPECT_EQ(triangulate(exact({{1, 1}, {1, 1}, {9, 1}}, pose)).problem, FixProblem::identical);
  EXPECT_EQ(triangulate(exact({{1, 1}, {1, 1}, {9, 1}, {9, 1}}, pose)).problem,
            FixProblem::identical);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    auto bearings = exact(kThree, pose);
    bearings[1].bearing = bad;
    EXPECT_EQ(triangulate(bearings).problem, FixProblem::bad_value);
    bearings = exact(kThree, pose);
    bearings[2].p_map.y() = bad;
    EXPECT_EQ(triangulate(bearings).problem, FixProblem::bad_value);
  }
  auto bearings = exact(kThree, pose);
  bearings[0].sigma = -1;
  EXPECT_EQ(triangulate(bearings).problem, FixProblem::bad_value);
  // A beacon seen behind instead of ahead: the circles meet all the same.
  bearings = exact(kThree, pose);
  bearings[0].bearing += kPi;
  EXPECT_NE(triangulate(bearings).problem, FixProblem::none);
  // Four bearings, one of them gross: no telling which.
  bearings = exact({{0, 0}, {20, 2}, {8, 19}, {-5, 9}}, pose);
  bearings[3].bearing += 1;
  EXPECT_EQ(triangulate(bearings).problem, FixProblem::inconsistent);
  EXPECT_THROW(triangulate(std::vector<BearingTo>(65)), Error);
}

}  // namespace
}  // namespace majak::beacon
