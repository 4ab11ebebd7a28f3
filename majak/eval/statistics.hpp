// SPDX-License-Identifier: Apache-2.0
// What is said of a set of errors: mean, spread, median, maximum.
#pragma once

#include <cstddef>
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

}  // namespace majak::eval
