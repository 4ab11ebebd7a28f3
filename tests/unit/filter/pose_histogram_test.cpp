// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/pose_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::filter {
namespace {

constexpr int kWidth = 11, kHeight = 19, kHeadings = 12;  // 2 x 3 tiles, not full

// A hall with a block in it.
std::shared_ptr<const PoseLattice> hall() {
  PoseLattice l(-1, 2, 0.2, kWidth, kHeight, kHeadings);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (x < 4 || x > 6 || y < 7 || y > 12) l.set_open(x, y);
  return std::make_shared<const PoseLattice>(l);
}

std::size_t index(int x, int y, int h) {
  return static_cast<std::size_t>((h * kHeight + y) * kWidth + x);
}
template <class Do>
void each(const Do& act) {
  for (int h = 0; h < kHeadings; ++h)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) act(x, y, h);
}

float& cell(PoseHistogram& p, int x, int y, int h) {
  auto& tile = p.tile(p.lattice().tile(x, y));
  tile.resize(kHeadings * PoseLattice::kSlice);
  return tile[static_cast<std::size_t>(h * PoseLattice::kSlice + y % 8 * 8 + x % 8)];
}

PoseHistogram random_belief(std::uint64_t seed) {
  PoseHistogram p(hall());
  p.add_uniform(1);
  RandomStream random(seed);
  each([&](int x, int y, int h) {
    cell(p, x, y, h) *= static_cast<float>(std::pow(random.uniform(), 3));
  });
  p.scale(1 / p.mass());
  return p;
}

double tap(const Kernel& k, int by) {
  return by < k.first || by >= k.first + static_cast<int>(k.taps.size())
             ? 0
             : k.taps[static_cast<std::size_t>(by - k.first)];
}

// Bel-(l) = sum over all l' of P(l | a, l') Bel(l').
std::vector<double> exhaustive(const PoseHistogram& p, const PoseMotion& a) {
  const PoseLattice& l = p.lattice();
  std::vector<double> moved(kWidth * kHeight * kHeadings);
  const Kernel turn =
      motion_kernel(a.T_from_to.theta / l.turn(), a.covariance(2, 2) / (l.turn() * l.turn()));
  each([&](int x, int y, int h) {
    if (p.at(x, y, h) == 0) return;
    const double from = l.heading(h), to = from + a.T_from_to.theta, k = 1 / l.cell;
    const Pose2 step = Pose2{0, 0, from} * a.T_from_to;
    const double c = std::cos(to), s = std::sin(to);
    const double xx = a.covariance(0, 0), xy = a.covariance(0, 1), yy = a.covariance(1, 1);
    const Kernel kx = motion_kernel(k * step.x, k * k * (c * c * xx - 2 * c * s * xy + s * s * yy));
    const Kernel ky = motion_kernel(k * step.y, k * k * (s * s * xx + 2 * c * s * xy + c * c * yy));
    each([&](int x2, int y2, int h2) {
      if ((l.open[l.tile(x2, y2)] >> (y2 % 8 * 8 + x2 % 8) & 1) == 0) return;
      double p_turn = 0;
      for (int round = -3; round <= 3; ++round) p_turn += tap(turn, h2 - h + round * kHeadings);
      moved[index(x2, y2, h2)] += p_turn * tap(kx, x2 - x) * tap(ky, y2 - y) * p.at(x, y, h);
    });
  });
  return moved;
}

PoseMotion motion(const Pose2& step, double along, double across, double turn) {
  PoseMotion m{step, Vec3(along * along, across * across, turn * turn).asDiagonal()};
  m.covariance(0, 1) = m.covariance(1, 0) = 0.3 * along * across;
  return m;
}

TEST(PoseHistogram, MoveIsTheSumOverAllPoses) {
  for (const PoseMotion& a :
       {motion({0.33, -0.1, 0.4}, 0.2, 0.05, 0.3), motion({-1.7, 0.2, -2.9}, 0.01, 0.01, 0.02),
        motion({0, 0, 0}, 0.9, 0.4, 1.5), motion({}, 0, 0, 0)}) {
    PoseHistogram p = random_belief(1);
    const std::vector<double> expected = exhaustive(p, a);
    p.move(a);
    each([&](int x, int y, int h) {
      ASSERT_NEAR(p.at(x, y, h), expected[index(x, y, h)], 1e-9) << x << ' ' << y << ' ' << h;
    });
  }
}

TEST(PoseHistogram, AnyNumberOfThreadsGivesTheSameBytes) {
  const PoseMotion a = motion({0.33, -0.1, 0.4}, 0.2, 0.05, 0.3);
  PoseHistogram one = random_belief(2);
  one.move(a);
  for (const int threads : {2, 8}) {
    PoseHistogram p = random_belief(2);
    p.move(a, {threads});
    ASSERT_EQ(p.held(), one.held());
    for (const std::size_t i : p.held()) EXPECT_EQ(p.tile(i), one.tile(i));
  }
}

TEST(PoseHistogram, NobodyIsInAWall) {
  PoseHistogram p = random_belief(3);
  for (int i = 0; i < 3; ++i) p.move(motion({0.5, 0, 0.2}, 0.3, 0.3, 0.3));
  EXPECT_EQ(p.at(5, 9, 4), 0);
  EXPECT_LT(p.mass(), 1);
  EXPECT_GT(p.mass(), 0.1);
}

TEST(PoseHistogram, MotionRaisesTheEntropyOfOnePlace) {
  PoseHistogram p(hall());
  cell(p, 2, 3, 0) = 1;
  EXPECT_EQ(p.entropy(), 0);
  EXPECT_EQ(p.held().size(), 1U);
  double before = 0;
  for (int i = 0; i < 4; ++i) {
    p.move(motion({0.1, 0, 0.1}, 0.1, 0.1, 0.1));
    EXPECT_GT(p.entropy(), before);
    before = p.entropy();
  }
  EXPECT_LT(before, std::log(hall()->open_cells() * kHeadings));
}

TEST(PoseHistogram, UniformIsSpreadOverOpenCells) {
  PoseHistogram p(hall());
  p.add_uniform(0.5);
  p.add_uniform(0.5);
  const std::size_t open = kWidth * kHeight - 3 * 6;
  EXPECT_EQ(p.lattice().open_cells(), open);
  EXPECT_NEAR(p.mass(), 1, 1e-6);
  EXPECT_NEAR(p.entropy(), std::log(open * kHeadings), 1e-6);
  EXPECT_EQ(p.at(5, 9, 4), 0);
  EXPECT_EQ(p.at(-1, 3, 0), 0);
  EXPECT_FLOAT_EQ(p.at(0, 0, 3), p.at(10, 18, 3 + kHeadings));
  EXPECT_EQ(p.bytes(), 6 * kHeadings * 64 * sizeof(float));
}

TEST(PoseHistogram, SumsAreOfAllTilesOfBoth) {
  PoseHistogram a(hall()), b(hall());
  cell(a, 1, 1, 0) = 0.25F;
  cell(b, 1, 1, 0) = 0.5F, cell(b, 9, 17, 5) = 1;
  a.add(b, 0.5);
  EXPECT_EQ(a.at(1, 1, 0), 0.5F);
  EXPECT_EQ(a.at(9, 17, 5), 0.5F);
  EXPECT_EQ(a.mass(), 1);
  EXPECT_NEAR(a.lattice().corner(a.lattice().tile(9, 17)).x(), -1 + 8.5 * 0.2, 1e-12);
  EXPECT_NEAR(a.lattice().corner(a.lattice().tile(9, 17)).y(), 2 + 16.5 * 0.2, 1e-12);
}

TEST(PoseMotion, TwoAreOne) {
  const PoseMotion a = motion({0.3, 0.1, 0.5}, 0.1, 0.02, 0.05),
                   b = motion({1, 0, -0.2}, 0.2, 0.1, 0.1);
  const PoseMotion both = a.then(b);
  EXPECT_LT((both.T_from_to.vector() - (a.T_from_to * b.T_from_to).vector()).norm(), 1e-15);
  // An error of the first, seen from the end of both: T exp(e) b = (T b) exp(Ad(b^-1) e).
  Mat3 j;
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = 1e-6 * Vec3::Unit(k);
    j.col(k) = log(both.T_from_to.inverse() * (a.T_from_to * exp(e) * b.T_from_to)) / 1e-6;
  }
  EXPECT_LT((both.covariance - (j * a.covariance * j.transpose() + b.covariance)).norm(), 1e-8);
}

}  // namespace
}  // namespace majak::filter
