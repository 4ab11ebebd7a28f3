// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/trilateration.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "tests/unit/beacon/scatter.hpp"

namespace majak::beacon {
namespace {

const std::vector<Vec2> kThree = {{0, 0}, {20, 2}, {8, 19}};
const std::vector<Vec2> kEight = {{0, 0},   {20, 2},  {8, 19}, {-3, 12},
                                  {23, 14}, {12, -4}, {2, 22}, {18, 24}};

std::vector<RangeTo> exact(const std::vector<Vec2>& beacons, const Vec2& p, double sigma = 0.05) {
  std::vector<RangeTo> out;
  for (const Vec2& b : beacons) out.push_back({b, (b - p).norm(), sigma});
  return out;
}

std::vector<RangeTo> noisy(std::vector<RangeTo> ranges, RandomStream& random) {
  for (RangeTo& m : ranges) m.range = std::abs(m.range + m.sigma * random.normal());
  return ranges;
}

// ---- two circles ----------------------------------------------------------------------------

TEST(Circles, MeetInTwoPointsOnBoth) {
  RandomStream random(1);
  int met = 0;
  for (int i = 0; i < 10000; ++i) {
    const Circle a{{random.uniform(-9, 9), random.uniform(-9, 9)}, random.uniform(0, 9)};
    const Circle b{{random.uniform(-9, 9), random.uniform(-9, 9)}, random.uniform(0, 9)};
    const Intersection found = intersect(a, b, 0);
    for (int k = 0; k < found.count; ++k) {
      EXPECT_NEAR((found.points[k] - a.centre).norm(), a.radius, 1e-12);  // seen: 1.8e-14
      EXPECT_NEAR((found.points[k] - b.centre).norm(), b.radius, 1e-12);
    }
    const double d = (a.centre - b.centre).norm();
    const bool cross = d < a.radius + b.radius && d > std::abs(a.radius - b.radius);
    EXPECT_EQ(found.count, cross ? 2 : 0);
    met += cross;
  }
  EXPECT_GT(met, 3000);
}

TEST(Circles, FirstPointLiesToTheLeft) {
  const auto found = intersect({{0, 0}, 5}, {{8, 0}, 5});
  ASSERT_EQ(found.count, 2);
  EXPECT_NEAR((found.points[0] - Vec2(4, 3)).norm(), 0, 1e-15);
  EXPECT_NEAR((found.points[1] - Vec2(4, -3)).norm(), 0, 1e-15);
}

TEST(Circles, TouchFromOutsideAndFromInside) {
  for (const double slip : {-5e-10, 0.0, 5e-10}) {
    const auto outside = intersect({{1, 0}, 2}, {{6 + slip, 0}, 3});
    ASSERT_EQ(outside.count, 1);
    EXPECT_NEAR((outside.points[0] - Vec2(3, 0)).norm(), 0, 1e-9);
    const auto second_inside = intersect({{1, 0}, 5}, {{4 + slip, 0}, 2});
    ASSERT_EQ(second_inside.count, 1);
    EXPECT_NEAR((second_inside.points[0] - Vec2(6, 0)).norm(), 0, 1e-9);
    const auto first_inside = intersect({{4, 0}, 2}, {{1 + slip, 0}, 5});
    ASSERT_EQ(first_inside.count, 1);
    EXPECT_NEAR((first_inside.points[0] - Vec2(6, 0)).norm(), 0, 1e-9);
  }
}

TEST(Circles, ToleranceDecidesWhetherTheyTouch) {
  const Circle a{{0, 0}, 2}, apart{{5.1, 0}, 3}, overlapping{{4.9, 0}, 3};
  EXPECT_EQ(intersect(a, apart, 0.05).count, 0);
  EXPECT_EQ(intersect(a, apart, 0.2).count, 1);
  EXPECT_NEAR(intersect(a, apart, 0.2).points[0].x(), 2.05, 1e-12);  // in the middle of the gap
  EXPECT_EQ(intersect(a, overlapping, 0.05).count, 2);
  EXPECT_EQ(intersect(a, overlapping, 0.2).count, 1);
}

TEST(Circles, ThatAreNone) {
  EXPECT_EQ(intersect({{0, 0}, -1}, {{1, 0}, 1}).count, 0);
  EXPECT_EQ(intersect({{0, 0}, std::nan("")}, {{1, 0}, 1}).count, 0);
  EXPECT_EQ(intersect({{0, std::nan("")}, 1}, {{1, 0}, 1}).count, 0);
  EXPECT_FALSE(intersect({{0, 0}, 1}, {{0, 0}, 2}).same);
  EXPECT_TRUE(intersect({{0, 0}, 1}, {{0, 0}, 1}).same);
}

// ---- two ranges -----------------------------------------------------------------------------

TEST(TwoRanges, LeaveTwoPlacesAndThePriorDecides) {
  const Vec2 truth(4, 3), mirrored(4, -3);
  const auto ranges = exact({{0, 0}, {8, 0}}, truth);
  const auto open = trilaterate(ranges);
  EXPECT_EQ(open.problem, FixProblem::ambiguous);
  ASSERT_TRUE(open.mirror);
  EXPECT_NEAR(open.p_map.y() + open.mirror->y(), 0, 1e-12);
  for (const Vec2& prior : {truth, mirrored}) {
    const auto fix = trilaterate(ranges, Vec2(prior + Vec2(1, 1)));
    EXPECT_EQ(fix.problem, FixProblem::none);
    EXPECT_NEAR((fix.p_map - prior).norm(), 0, 1e-12);
    EXPECT_NEAR((*fix.mirror + prior - Vec2(8, 0)).norm(), 0, 1e-12);
  }
}

TEST(TwoRanges, ThatAreRoughStillMeetTwice) {
  // The circles overlap by 0.6 m, less than the gate's 3.3 sigmas of both: no touch all the same.
  const Vec2 truth(4, 1.5);
  const auto open = trilaterate(exact({{0, 0}, {8, 0}}, truth, 0.2));
  ASSERT_TRUE(open.mirror);
  EXPECT_NEAR((*open.mirror - open.p_map).norm(), 3, 1e-9);
  // Kept apart by noise: the place between, and a word.
  const std::vector<RangeTo> gap = {{{0, 0}, 3.9, 0.05}, {{8, 0}, 4, 0.05}};
  const auto touching = trilaterate(gap);
  EXPECT_EQ(touching.problem, FixProblem::ill_conditioned);
  EXPECT_NEAR((touching.p_map - Vec2(3.95, 0)).norm(), 0, 1e-9);
}

TEST(TwoRanges, CovarianceIsThatOfTheTwoDirections) {
  // At a right angle each range says one axis.
  const std::vector<RangeTo> ranges = {{{-5, 0}, 5, 0.1}, {{0, -5}, 5, 0.2}};
  const auto fix = trilaterate(ranges, Vec2(1, 1));
  EXPECT_EQ(fix.problem, FixProblem::none);
  EXPECT_NEAR(fix.covariance(0, 0), 0.01, 1e-15);
  EXPECT_NEAR(fix.covariance(1, 1), 0.04, 1e-15);
  EXPECT_NEAR(fix.hdop, std::sqrt(2), 1e-12);
}

TEST(TwoRanges, ThatDoNotMeet) {
  EXPECT_EQ(trilaterate(exact({{0, 0}, {8, 0}}, {4, 0})).problem, FixProblem::ill_conditioned);
  const std::vector<RangeTo> gap = {{{0, 0}, 3, 0.05}, {{8, 0}, 4, 0.05}};
  EXPECT_EQ(trilaterate(gap).problem, FixProblem::inconsistent);
  const std::vector<RangeTo> one_place = {{{1, 0}, 3, 0.05}, {{1, 0}, 3, 0.05}};
  EXPECT_EQ(trilaterate(one_place).problem, FixProblem::identical);
}

// ---- three and more -------------------------------------------------------------------------

TEST(Trilateration, IsExactWithoutNoise) {
  RandomStream random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p(random.uniform(-10, 30), random.uniform(-10, 30));
    const auto fix = trilaterate(exact(i % 2 == 0 ? kThree : kEight, p));
    EXPECT_EQ(fix.problem, FixProblem::none);
    EXPECT_NEAR((fix.p_map - p).norm(), 0, 1e-12);  // seen: 1.5e-13
    EXPECT_NEAR(fix.chi2, 0, 1e-20);
  }
}

TEST(Trilateration, HdopOfARing) {
  // n beacons around: H = n/2 I.
  std::vector<Vec2> ring;
  for (int i = 0; i < 5; ++i)
    ring.push_back(7 * Vec2(std::cos(i * 0.4 * kPi), std::sin(i * 0.4 * kPi)));
  const auto fix = trilaterate(exact(ring, {0, 0}, 0.1));
  EXPECT_NEAR(fix.hdop, std::sqrt(4.0 / 5), 1e-12);
  EXPECT_NEAR(fix.covariance.trace(), 0.01 * 4.0 / 5, 1e-12);
}

/// The least squares solution by walking downhill on a grid that shrinks.
Vec2 slow_twin(const std::vector<RangeTo>& ranges, Vec2 p) {
  const auto cost = [&](const Vec2& q) {
    double sum = 0;
    for (const RangeTo& m : ranges) sum += std::pow(((q - m.p_map).norm() - m.range) / m.sigma, 2);
    return sum;
  };
  for (double step = 1; step > 1e-9; step /= 2) {
    for (bool moved = true; moved;) {
      moved = false;
      for (const Vec2& way : {Vec2(step, 0), Vec2(-step, 0), Vec2(0, step), Vec2(0, -step)}) {
        if (cost(p + way) < cost(p)) p += way, moved = true;
      }
    }
  }
  return p;
}

TEST(Trilateration, IsTheMinimumOfTheSquares) {
  RandomStream random(3);
  for (int i = 0; i < 50; ++i) {
    const Vec2 p(random.uniform(0, 20), random.uniform(0, 20));
    auto ranges = noisy(exact(kEight, p, 0.3), random);
    ranges[2].sigma = 0.1;
    const auto fix = trilaterate(ranges);
    if (fix.used != 255) continue;
    EXPECT_NEAR((fix.p_map - slow_twin(ranges, p)).norm(), 0, 1e-6);
  }
}

TEST(Trilateration, ScatterIsTheStatedCovarianceOverAField) {
  for (const auto& beacons : {kThree, kEight}) {
    for (int place = 0; place < 36; ++place) {
      const Vec2 p(3.5 * (place % 6) + 1.2, 3.5 * (place / 6) + 0.4);
      const auto ranges = exact(beacons, p);
      Scatter<2> scatter(trilaterate(ranges).covariance);
      RandomStream random(4, place);
      int refused = 0;
      for (int i = 0; i < 16000; ++i) {
        const auto fix = trilaterate(noisy(ranges, random));
        refused += fix.problem != FixProblem::none;
        if (fix.problem == FixProblem::none) scatter.add(fix.p_map - p);
      }
      EXPECT_LT(scatter.difference(), 0.05) << p.transpose();
      EXPECT_LT(refused, 80) << p.transpose();  // beyond 3.3 sigmas where nothing can be left out
    }
  }
}

TEST(Trilateration, GrossErrorsLeaveTheResultWithinItsEllipse) {
  RandomStream random(5);
  int inside = 0, found = 0, gross = 0;
  constexpr int kRuns = 5000;
  for (int run = 0; run < kRuns; ++run) {
    const Vec2 p(random.uniform(0, 20), random.uniform(0, 20));
    auto ranges = noisy(exact(kEight, p), random);
    for (RangeTo& m : ranges) {
      if (random.uniform() < 0.2) m.range = random.uniform(0, 30), ++gross;
    }
    const auto fix = trilaterate(ranges);
    if (fix.problem != FixProblem::none) continue;
    ++found;
    const Vec2 e = fix.p_map - p;
    inside += e.dot(fix.covariance.inverse() * e) < 5.991;  // 95 %, 2 dof
  }
  EXPECT_NEAR(gross, 0.2 * 8 * kRuns, 300);
  EXPECT_NEAR(found, 0.944 * kRuns,
              50);  // in 5.6 % of the runs half of the ranges or more are gross
  EXPECT_GT(inside, 0.94 * found);
  EXPECT_LT(inside, 0.96 * found);
}

TEST(Trilateration, SaysWhichRangesAreGross) {
  auto ranges = exact(kEight, {6, 7});
  ranges[1].range += 2;
  ranges[6].range -= 1;
  const auto fix = trilaterate(ranges);
  EXPECT_EQ(fix.used, Mask{0b10111101});
  EXPECT_EQ(fix.dof, 4);
  EXPECT_NEAR((fix.p_map - Vec2(6, 7)).norm(), 0, 1e-12);
}

TEST(Trilateration, ResidualTestIsChiSquare) {
  RandomStream random(6);
  double sum = 0;
  int passed = 0;
  constexpr int kRuns = 4000;
  for (int i = 0; i < kRuns; ++i) {
    const auto fix = trilaterate(noisy(exact(kEight, {9, 9}), random));
    sum += fix.chi2 - fix.dof;
    passed += passes_residual_test(fix.chi2, fix.dof);
  }
  EXPECT_NEAR(sum / kRuns, 0,
              0.15);  // sigma of the mean 0.055; outliers left out lower it a little
  EXPECT_GT(passed, 0.995 * kRuns);
  // All ranges too long by the same 0.3 m: no place fits.
  auto wrong = exact(kEight, {9, 9});
  for (RangeTo& m : wrong) m.range += 0.3;
  const auto fix = trilaterate(wrong);
  EXPECT_TRUE(fix.problem == FixProblem::inconsistent || fix.used != 255 ||
              !passes_residual_test(fix.chi2, fix.dof));
}

// ---- what cannot be ---------------------------------------------------------------------------

TEST(Trilateration, BeaconsInALineLeaveTheMirror) {
  const std::vector<Vec2> line = {{0, 0}, {5, 5}, {9, 9}, {14, 14}};
  const Vec2 truth(2, 7), mirrored(7, 2);
  RandomStream random(7);
  for (const bool noise : {false, true}) {
    auto ranges = exact(line, truth);
    if (noise) ranges = noisy(ranges, random);
    const auto open = trilaterate(ranges);
    EXPECT_EQ(open.problem, FixProblem::ambiguous);
    ASSERT_TRUE(open.mirror);
    EXPECT_NEAR(((open.p_map + *open.mirror) - Vec2(9, 9)).norm(), 0, noise ? 0.2 : 1e-9);
    const auto fix = trilaterate(ranges, Vec2(8, 0));
    EXPECT_EQ(fix.problem, FixProblem::none);
    EXPECT_NEAR((fix.p_map - mirrored).norm(), 0, noise ? 0.2 : 1e-9);
    EXPECT_EQ(fix.dof, 2);
  }
}

TEST(Trilateration, NearlyInALineIsDecidedWhereTheRangesCan) {
  // 30 cm off the line: the mirror's residuals are many sigmas of 1 cm, and less than one of 1 m.
  const std::vector<Vec2> bent = {{0, 0}, {5, 0.3}, {10, 0}};
  const auto clear = trilaterate(exact(bent, {4, 6}, 0.01));
  EXPECT_EQ(clear.problem, FixProblem::none);
  EXPECT_FALSE(clear.mirror);
  EXPECT_NEAR((clear.p_map - Vec2(4, 6)).norm(), 0, 1e-9);
  EXPECT_EQ(trilaterate(exact(bent, {4, 6}, 0.3)).problem, FixProblem::ambiguous);
}

TEST(Trilateration, OnTheLineOfTheBeacons) {
  const auto fix = trilaterate(exact({{0, 0}, {5, 0}, {9, 0}}, {3, 0}));
  EXPECT_EQ(fix.problem, FixProblem::ill_conditioned);
}

TEST(Trilateration, BadInput) {
  EXPECT_EQ(trilaterate({}).problem, FixProblem::too_few);
  EXPECT_EQ(trilaterate(exact({{0, 0}}, {1, 1})).problem, FixProblem::too_few);
  EXPECT_EQ(trilaterate(exact({{1, 2}, {1, 2}, {1, 2}}, {3, 3})).problem, FixProblem::identical);
  EXPECT_EQ(trilaterate(exact({{1, 2}, {1, 2}, {5, 2}}, {3, 3})).problem, FixProblem::ambiguous);
  for (const double bad : {std::nan(""), HUGE_VAL, -1.0}) {
    auto ranges = exact(kThree, {3, 3});
    ranges[1].range = bad;
    EXPECT_EQ(trilaterate(ranges).problem, FixProblem::bad_value);
  }
  auto ranges = exact(kThree, {3, 3});
  ranges[0].sigma = 0;
  EXPECT_EQ(trilaterate(ranges).problem, FixProblem::bad_value);
  ranges = exact(kThree, {3, 3});
  ranges[0].p_map.x() = std::nan("");
  EXPECT_EQ(trilaterate(ranges).problem, FixProblem::bad_value);
  // Three ranges that contradict each other: nothing to choose between.
  ranges = exact(kThree, {9, 9});
  ranges[0].range += 5;
  EXPECT_EQ(trilaterate(ranges).problem, FixProblem::inconsistent);
  EXPECT_THROW(trilaterate(std::vector<RangeTo>(65)), Error);
}

TEST(Trilateration, ProblemsHaveWords) {
  for (const auto p :
       {FixProblem::none, FixProblem::too_few, FixProblem::bad_value, FixProblem::identical,
        FixProblem::ambiguous, FixProblem::ill_conditioned, FixProblem::inconsistent}) {
    EXPECT_GT(std::string(describe(p)).size(), 3u);
  }
}

}  // namespace
}  // namespace majak::beacon
