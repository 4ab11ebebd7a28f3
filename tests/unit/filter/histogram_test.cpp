// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "majak/core/random.hpp"

namespace majak::filter {
namespace {

struct Moments {
  double mass = 0, mean = 0, variance = 0;
};

Moments moments(const Kernel& k) {
  Moments m;
  for (std::size_t i = 0; i < k.taps.size(); ++i) {
    const double at = k.first + static_cast<double>(i);
    m.mass += k.taps[i], m.mean += k.taps[i] * at, m.variance += k.taps[i] * at * at;
  }
  m.variance -= m.mean * m.mean;
  return m;
}

Histogram random_belief(std::size_t n, bool cyclic, std::uint64_t seed) {
  RandomStream random(seed);
  Histogram h{std::vector<double>(n), cyclic};
  for (double& p : h.p) p = random.uniform();
  const double sum = std::accumulate(h.p.begin(), h.p.end(), 0.0);
  for (double& p : h.p) p /= sum;
  return h;
}

TEST(MotionKernel, MeanIsTheShiftAndVarianceTheMotions) {
  for (const double shift : {0.0, 0.5, 3.0, -2.3, 7.9, -0.001})
    for (const double variance : {0.25, 0.3, 1.0, 4.0, 60.0, 150.0}) {
      const Moments m = moments(motion_kernel(shift, variance));
      EXPECT_NEAR(m.mass, 1, 1e-12);
      EXPECT_NEAR(m.mean, shift, 1e-12);
      EXPECT_NEAR(m.variance, variance, 4e-5 * std::max(1.0, variance)) << shift;
    }
}

TEST(MotionKernel, TheGridItselfBlursWhatLiesBetweenCells) {
  const Moments m = moments(motion_kernel(1.3, 0.01));
  EXPECT_NEAR(m.mean, 1.3, 1e-15);
  EXPECT_NEAR(m.variance, 0.3 * 0.7, 1e-15);
  const Kernel whole = motion_kernel(-4, 0);
  EXPECT_EQ(whole.first, -4);
  EXPECT_EQ(whole.taps, std::vector<double>{1});
}

// exp(-t) I_n(t) is a semigroup: two blurs are one of the sum of their variances.
TEST(MotionKernel, TwoBlursAreOne) {
  Histogram once{std::vector<double>(61), true};
  once.p[30] = 1;
  Histogram twice = once;
  once.move(0, 2.0);
  twice.move(0, 0.7), twice.move(0, 1.3);
  for (std::size_t i = 0; i < once.p.size(); ++i) EXPECT_NEAR(once.p[i], twice.p[i], 1e-6);
}

TEST(Histogram, MoveIsTheSumOverAllCells) {
  for (const bool cyclic : {false, true}) {
    Histogram h = random_belief(17, cyclic, 3);
    const std::vector<double> before = h.p;
    const Kernel k = motion_kernel(-2.4, 3);  // longer than the row
    h.move(-2.4, 3);
    std::vector<double> sum(17);
    for (int to = 0; to < 17; ++to)
      for (int from = 0; from < 17; ++from) {
        double p = 0;  // P(to | a, from)
        for (int i = 0; i < static_cast<int>(k.taps.size()); ++i) {
          const int ends = from + k.first + i;
          const bool here = cyclic     ? (ends - to) % 17 == 0
                            : to == 0  ? ends <= 0
                            : to == 16 ? ends >= 16
                                       : ends == to;
          if (here) p += k.taps[i];
        }
        sum[to] += p * before[from];
      }
    for (int i = 0; i < 17; ++i) EXPECT_NEAR(h.p[i], sum[i], 1e-15) << cyclic;
  }
}

TEST(Histogram, EntropyGrowsAtMotionOnACircle) {
  Histogram h = random_belief(40, true, 4);
  RandomStream random(5);
  for (int i = 0; i < 50; ++i) {
    const double before = entropy(h.p);
    h.move(random.uniform(-5, 5), random.uniform(0, 1));
    EXPECT_GE(entropy(h.p), before - 1e-12);
    EXPECT_NEAR(std::accumulate(h.p.begin(), h.p.end(), 0.0), 1, 1e-12);
  }
  EXPECT_NEAR(entropy(h.p), std::log(40), 0.02);
}

// Over all that may be seen, each by its probability: one sighting alone may surprise.
TEST(Histogram, EntropyFallsAtSightingsInTheMean) {
  const Histogram h = random_belief(25, true, 6);
  std::vector<double> door(25), wall(25);
  RandomStream random(7);
  for (int i = 0; i < 25; ++i) door[i] = random.uniform(), wall[i] = 1 - door[i];
  Histogram a = h, b = h;
  const double p_door = a.see(door), p_wall = b.see(wall);
  EXPECT_NEAR(p_door + p_wall, 1, 1e-12);
  EXPECT_LT(p_door * entropy(a.p) + p_wall * entropy(b.p), entropy(h.p));
}

TEST(Histogram, SeeingIsBayesAndImpossibleThingsAreNotBelieved) {
  Histogram h{{0.5, 0.25, 0.25}, false};
  EXPECT_DOUBLE_EQ(h.see(std::vector<double>{0.2, 0.8, 0.0}), 0.3);
  EXPECT_DOUBLE_EQ(h.p[0], 1 / 3.0);
  EXPECT_DOUBLE_EQ(h.p[1], 2 / 3.0);
  EXPECT_DOUBLE_EQ(h.p[2], 0);
  const auto before = h.p;
  EXPECT_EQ(h.see(std::vector<double>{0, 0, 1}), 0);
  EXPECT_EQ(h.p, before);
}

TEST(Histogram, UniformHasTheMostEntropy) {
  EXPECT_NEAR(entropy(Histogram::uniform(8, false).p), std::log(8), 1e-15);
  EXPECT_EQ(entropy(std::vector<double>{0, 1, 0}), 0);
}

}  // namespace
}  // namespace majak::filter
