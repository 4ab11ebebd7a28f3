// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/resampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "majak/core/chi_square.hpp"

namespace majak::filter {
namespace {

using Resample = void (*)(std::span<const double>, RandomStream&, std::span<std::uint32_t>);

std::vector<double> some_weights(std::size_t n, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<double> log_weights(n), weights(n);
  for (double& w : log_weights) w = 4 * random.normal();
  normalise(log_weights, weights);
  return weights;
}

std::vector<int> copies(Resample resample, const std::vector<double>& weights, std::size_t n,
                        std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<std::uint32_t> chosen(n, 4711);
  resample(weights, random, chosen);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  std::vector<int> count(weights.size());
  for (const std::uint32_t i : chosen) ++count.at(i);
  return count;
}

TEST(Normalise, SumIsOneWhateverTheScale) {
  for (const double shift : {0.0, 1e4, -1e4, 1e8}) {
    RandomStream random(2);
    std::vector<double> log_weights(5000), weights(5000);
    for (double& w : log_weights) w = shift + 30 * random.normal();
    const double log_sum = normalise(log_weights, weights);
    EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), 1, 1e-12);
    for (std::size_t i = 0; i < weights.size();
         i += 100)  // a number near 1e8 has 1.5e-8 at its end
      EXPECT_NEAR(weights[i], std::exp(log_weights[i] - log_sum), 3e-8 * weights[i] + 1e-300);
  }
}

TEST(Normalise, SlowTwinAndNothingLeft) {
  const std::vector<double> logs{std::log(1.0), std::log(3.0), -1e9};
  std::vector<double> w(3);
  EXPECT_NEAR(normalise(logs, w), std::log(4.0), 1e-15);
  EXPECT_NEAR(w[0], 0.25, 1e-16);
  EXPECT_NEAR(w[1], 0.75, 1e-16);
  EXPECT_EQ(w[2], 0);
  const double none = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(normalise(std::vector{none, none, none}, w), none);
  for (const double x : w) EXPECT_EQ(x, 1.0 / 3);
}

TEST(EffectiveSize, BetweenOneAndAll) {
  EXPECT_NEAR(effective_size(std::vector(50, 0.02)), 50, 1e-12);
  EXPECT_EQ(effective_size(std::vector{0.0, 1.0, 0.0}), 1);
  EXPECT_NEAR(effective_size(std::vector{0.5, 0.5, 0.0}), 2, 1e-15);
}

// Systematic and residual: never further than one from n w.
TEST(Resampling, CopiesAreFloorOrCeiling) {
  for (const Resample resample : {resample_systematic, resample_residual})
    for (std::uint64_t seed = 1; seed < 200; ++seed) {
      const auto weights = some_weights(37, seed);
      const std::size_t n = 5 + 13 * (seed % 20);
      const auto count = copies(resample, weights, n, seed);
      for (std::size_t i = 0; i < weights.size(); ++i) {
        EXPECT_GE(count[i], std::floor(n * weights[i] - 1e-9));
        EXPECT_LE(count[i], std::ceil(n * weights[i] + 1e-9));
      }
    }
}

TEST(Resampling, ExpectedCopiesAreTheWeights) {
  const auto weights = some_weights(12, 5);
  constexpr int kRuns = 20000, kDraws = 30;
  for (const Resample resample : {resample_systematic, resample_stratified, resample_residual}) {
    std::vector<double> mean(weights.size());
    for (int run = 0; run < kRuns; ++run) {
      const auto count = copies(resample, weights, kDraws, 1000 + run);
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += count[i];
    }
    for (std::size_t i = 0; i < mean.size(); ++i)  // a count's variance is 1/4 to 1/2 at most
      EXPECT_NEAR(mean[i] / kRuns, kDraws * weights[i], 4 * std::sqrt(0.5 / kRuns)) << i;
  }
}

// One draw a run is an independent sample: chi-square against the weights.
TEST(Resampling, SingleDrawsAreChiSquare) {
  const auto weights = some_weights(8, 11);
  constexpr int kRuns = 50000;
  for (const Resample resample : {resample_systematic, resample_stratified, resample_residual}) {
    std::vector<double> count(weights.size());
    for (int run = 0; run < kRuns; ++run) {
      RandomStream random(1, run);
      std::uint32_t chosen = 0;
      resample(weights, random, std::span(&chosen, 1));
      ++count[chosen];
    }
    double chi2 = 0;
    int classes = 0;
    for (std::size_t i = 0; i < weights.size(); ++i)
      if (const double expected = kRuns * weights[i]; expected > 5)
        chi2 += (count[i] - expected) * (count[i] - expected) / expected, ++classes;
    EXPECT_GE(classes, 4);
    EXPECT_LT(chi2, chi_square_quantile(0.999, classes - 1));
  }
}

// The slow twin: for each mark the first sample whose sum of weights lies above it.
TEST(Resampling, SystematicEqualsTheSlowTwin) {
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    const auto weights = some_weights(64, seed);
    std::vector<std::uint32_t> chosen(100);
    RandomStream random(seed), same(seed);
    resample_systematic(weights, random, chosen);
    const double first = same.uniform();
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      double sum = 0;
      std::size_t i = 0;
      for (; i + 1 < weights.size(); ++i)
        if ((sum += weights[i]) > (static_cast<double>(k) + first) * 0.01) break;
      EXPECT_EQ(chosen[k], i);
    }
  }
}

TEST(Resampling, NothingIsDrawnThatHasNoWeight) {
  const std::vector<double> weights{0, 0.5, 0, 0.5, 0, 0};
  for (const Resample resample : {resample_systematic, resample_stratified, resample_residual})
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
      const auto count = copies(resample, weights, 7, seed);
      EXPECT_EQ(count[1] + count[3], 7);
    }
}

// Fox's bound is the chi-square quantile with k - 1 degrees of freedom over 2 epsilon.
TEST(KldSize, IsTheQuantileOfChiSquare) {
  EXPECT_EQ(kld_size(0, 0.05, 2.326), 1U);
  EXPECT_EQ(kld_size(1, 0.05, 2.326), 1U);
  for (const std::size_t k : {5UL, 20UL, 100UL, 2000UL}) {
    const double exact = chi_square_quantile(0.99, double(k) - 1) / (2 * 0.05);
    EXPECT_NEAR(double(kld_size(k, 0.05, 2.3263479)), exact, 0.01 * exact + 1);
  }
}

}  // namespace
}  // namespace majak::filter
