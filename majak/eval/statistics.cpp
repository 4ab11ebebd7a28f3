// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace majak::eval {
namespace {

double sorted_quantile(const std::vector<double>& sorted, double q) {
  const double at = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (at - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

}  // namespace

ErrorStats error_stats(std::vector<double> errors) {
  ErrorStats stats;
  if (errors.empty()) return stats;
  std::sort(errors.begin(), errors.end());
  const double n = static_cast<double>(errors.size());
  double sum = 0, squares = 0;
  for (const double e : errors) {
    sum += e;
    squares += e * e;
  }
  stats.count = errors.size();
  stats.mean = sum / n;
  stats.rms = std::sqrt(squares / n);
  double around_mean = 0;
  for (const double e : errors) around_mean += (e - stats.mean) * (e - stats.mean);
  stats.sigma = errors.size() > 1 ? std::sqrt(around_mean / (n - 1)) : 0.0;
  stats.median = sorted_quantile(errors, 0.5);
  stats.max = errors.back();
  return stats;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return sorted_quantile(values, q);
}

}  // namespace majak::eval
