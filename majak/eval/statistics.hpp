// SPDX-License-Identifier: Apache-2.0
// What is said of a set of errors: mean, spread, median, maximum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace majak::eval {

/// Of n non-negative errors, in the unit of the errors. All zero when n is zero.
struct ErrorStats {
  std::size_t count = 0;
  double mean = 0;
  double sigma = 0;  ///< standard deviation of the sample (n - 1), 0 for fewer than two
  double median = 0;
  double rms = 0;
  double max = 0;
};

ErrorStats error_stats(std::vector<double> errors);

/// The value below which a share q in [0, 1] of the values lies, linear between order statistics.
/// Zero for no values.
double quantile(std::vector<double> values, double q);

struct MeanWithConfidence {
  double mean = 0;
  double low = 0, high = 0;  ///< two-sided interval of the mean
};

struct BootstrapOptions {
  double confidence = 0.95;
  int draws = 2000;
  std::uint64_t seed = 1;  ///< the same one gives the same interval
};

/// The mean of samples that err together within their groups (bursts of fixes, runs), and how well
/// it is known: whole groups are drawn with replacement (Efron and Tibshirani 1993, the percentile
/// interval). groups[i] is the group of samples[i]. With one group alone nothing is known: the
/// interval is the mean. With ten groups it is somewhat too narrow.
MeanWithConfidence mean_with_confidence(std::span<const double> samples,
                                        std::span<const int> groups,
                                        const BootstrapOptions& options = {});

}  // namespace majak::eval
