// SPDX-License-Identifier: Apache-2.0
// Weights of samples and how to draw from them (Thrun, Burgard, Fox 2005, 4.3; docs/MATH.md
// "Monte Carlo localization"). Free of robots: samples are numbers 0 ... n-1.
//
//   normalise(log_weights, weights);
//   if (effective_size(weights) < weights.size() / 2.0) resample_systematic(weights, random,
//   chosen);
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "majak/core/random.hpp"

namespace majak::filter {

/// weights = exp(log_weights), scaled to sum 1; returns the log of the sum before scaling. Where
/// all are -infinity, weights are equal and the result is -infinity.
double normalise(std::span<const double> log_weights, std::span<double> weights);

/// Equal weights that would tell as much: 1 / sum w^2, for weights of sum 1.
double effective_size(std::span<const double> weights);

// Each draws chosen.size() samples, in rising order, by weights of sum 1; sample i comes n w_i
// times in the mean.

/// One random number for all: between floor(n w_i) and ceil(n w_i) copies.
void resample_systematic(std::span<const double> weights, RandomStream& random,
                         std::span<std::uint32_t> chosen);
/// One random number for each n-th part.
void resample_stratified(std::span<const double> weights, RandomStream& random,
                         std::span<std::uint32_t> chosen);
/// floor(n w_i) copies for sure, the rest by systematic resampling of what is left of the weights.
void resample_residual(std::span<const double> weights, RandomStream& random,
                       std::span<std::uint32_t> chosen);

/// How many samples keep the Kullback-Leibler distance between them and the density below
/// `epsilon` (nat), with a probability whose standard normal quantile is z, where they fill `bins`
/// bins (Fox 2003, eq. 7: Wilson and Hilferty's quantile of chi-square).
std::size_t kld_size(std::size_t bins, double epsilon, double z);

}  // namespace majak::filter
