// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/statistics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>

#include "majak/core/random.hpp"

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

MeanWithConfidence mean_with_confidence(std::span<const double> samples,
                                        std::span<const int> groups,
                                        const BootstrapOptions& options) {
  assert(samples.size() == groups.size());
  struct Group {
    double sum = 0, count = 0;
    void add(const Group& other) { sum += other.sum, count += other.count; }
  };
  if (samples.empty()) return {};
  std::map<int, Group> by_name;
  for (std::size_t i = 0; i < samples.size(); ++i) by_name[groups[i]].add({samples[i], 1});
  std::vector<Group> all;
  Group whole;
  for (const auto& [name, group] : by_name) all.push_back(group), whole.add(group);
  std::vector<double> means;
  for (int k = 0; k < options.draws; ++k) {
    RandomStream random(options.seed, static_cast<std::uint64_t>(k));
    Group drawn;
    for (std::size_t i = 0; i < all.size(); ++i) drawn.add(all[random.below(all.size())]);
    means.push_back(drawn.sum / drawn.count);
  }
  std::sort(means.begin(), means.end());
  const double tail = (1 - options.confidence) / 2;
  return {whole.sum / whole.count, sorted_quantile(means, tail), sorted_quantile(means, 1 - tail)};
}

}  // namespace majak::eval
