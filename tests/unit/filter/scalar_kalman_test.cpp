// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/scalar_kalman.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::filter {
namespace {

TEST(ScalarKalman, PredictionAddsQ) {
  ScalarKalman k{.mean = 2, .variance = 0.75};
  k.predict(0.25);
  EXPECT_EQ(k.variance, 1.0);
  EXPECT_EQ(k.mean, 2.0);
  k.predict(0.5, -3);
  EXPECT_EQ(k.variance, 1.5);
  EXPECT_EQ(k.mean, -1.0);
}

TEST(ScalarKalman, CorrectionIsTheThesis) {
  // avg = avg + K (y - avg), K = P / (P + R), P = (1 - K) P, in numbers without rounding.
  ScalarKalman k{.mean = 1, .variance = 1};
  EXPECT_EQ(k.correct(5, 3), 0.25);
  EXPECT_EQ(k.mean, 2.0);
  EXPECT_EQ(k.variance, 0.75);
}

TEST(ScalarKalman, GainIsWithinZeroAndOne) {
  RandomStream random(33);
  for (int i = 0; i < 10'000; ++i) {
    ScalarKalman k{.mean = random.normal(), .variance = std::exp(20 * random.normal())};
    const double p = k.variance, m = k.mean, y = random.normal();
    const double gain = k.correct(y, std::exp(20 * random.normal()));
    EXPECT_GE(gain, 0);
    EXPECT_LE(gain, 1);
    EXPECT_LE(k.variance, p);
    EXPECT_GE(k.variance, 0);
    EXPECT_GE(k.mean, std::min(m, y) - 1e-12);
    EXPECT_LE(k.mean, std::max(m, y) + 1e-12);
  }
}

TEST(ScalarKalman, GainIsOneWithoutMeasurementNoise) {
  // The thesis says "always less than 1", and in the next sentence that R = 0 means all of it.
  ScalarKalman k{.mean = 1, .variance = 0.3};
  EXPECT_EQ(k.correct(7, 0), 1.0);
  EXPECT_EQ(k.mean, 7.0);
  EXPECT_EQ(k.variance, 0.0);
}

TEST(ScalarKalman, WhoKnowsLearnsNothing) {
  for (const double r : {0.0, 9.0}) {
    ScalarKalman k{.mean = 1, .variance = 0};
    EXPECT_EQ(k.correct(7, r), 0.0);
    EXPECT_EQ(k.mean, 1.0);
    EXPECT_EQ(k.variance, 0.0);
  }
}

TEST(ScalarKalman, BalanceKeepsTheGainAtATenth) {
  ScalarKalman k{.mean = 0, .variance = 0.9};
  for (int i = 0; i < 1000; ++i) {
    k.predict(0.1);
    ASSERT_NEAR(k.variance, 1.0, 1e-15);
    ASSERT_NEAR(k.correct(i, 9), 0.1, 1e-16);
    ASSERT_NEAR(k.variance, 0.9, 1e-15);
  }
}

TEST(ScalarKalman, BalanceIsAnExponentialAverageAndNoWindow) {
  RandomStream random(38);
  std::vector<double> y;
  ScalarKalman k{.mean = 0, .variance = 0.9};
  double exponential = 0, worst = 0;
  for (int i = 0; i < 200; ++i) {
    y.push_back(random.normal());
    k.predict(0.1);
    k.correct(y.back(), 9);
    exponential += 0.1 * (y.back() - exponential);
    EXPECT_NEAR(k.mean, exponential, 1e-14);
    if (i >= 10)
      worst = std::max(worst, std::abs(k.mean - std::accumulate(y.end() - 10, y.end(), 0.0) / 10));
  }
  EXPECT_GT(worst, 0.3);  // the window of 10 that the thesis names differs by up to 0.5
}

TEST(ScalarKalman, AnImpulseIsForgottenExponentially) {
  ScalarKalman k{.mean = 0, .variance = 0.9};
  for (int i = 0; i < 30; ++i) {
    k.predict(0.1);
    k.correct(i == 0 ? 1 : 0, 9);
    EXPECT_NEAR(k.mean, 0.1 * std::pow(0.9, i), 1e-15);  // after 10 steps too, unlike a window
  }
}

TEST(ScalarKalman, SettlesAtTheRiccatiSolution) {
  // P = P R / (P + R) + Q has the root (Q + sqrt(Q^2 + 4 Q R)) / 2.
  RandomStream random(37);
  for (int i = 0; i < 100; ++i) {
    const double q = std::exp(2 * random.normal()), r = std::exp(2 * random.normal());
    ScalarKalman k{.mean = 0, .variance = std::exp(4 * random.normal())};
    for (int step = 0; step < 20'000; ++step) k.predict(q), k.correct(0, r);
    k.predict(q);
    const double p = (q + std::sqrt(q * q + 4 * q * r)) / 2;
    EXPECT_NEAR(k.variance / p, 1, 1e-12);
    EXPECT_NEAR(k.correct(0, r), p / (p + r), 1e-12);
  }
}

TEST(ScalarKalman, VarianceStaysPositiveOverAMillionSteps) {
  RandomStream random(39);
  ScalarKalman k;
  double least = k.variance;
  for (int i = 0; i < 1'000'000; ++i) {
    k.predict(1e-9 * random.uniform());
    k.correct(random.normal(), 1e-6 + random.uniform());
    least = std::min(least, k.variance);
  }
  EXPECT_GT(least, 0);
  EXPECT_TRUE(std::isfinite(k.mean));
}

TEST(ScalarKalman, WithoutMotionItIsTheWeightedMean) {
  RandomStream random(35);
  ScalarKalman k{.mean = 0, .variance = 100};
  double sum = 0, weights = 0.01;
  for (int i = 0; i < 50; ++i) {
    const double r = random.uniform(0.5, 2), y = random.normal();
    k.correct(y, r);
    sum += y / r, weights += 1 / r;
  }
  EXPECT_NEAR(k.mean, sum / weights, 1e-13);
  EXPECT_NEAR(k.variance, 1 / weights, 1e-13);
}

}  // namespace
}  // namespace majak::filter
