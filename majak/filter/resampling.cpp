// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/resampling.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace majak::filter {
namespace {

/// Walks the sum of `weight(i)` once; the k-th mark stands at `mark(k)`, marks rise. Where rounding
/// leaves the last marks beyond the sum, they fall to the last sample that has a weight.
template <class Weight, class Mark>
void pick(std::size_t samples, const Weight& weight, const Mark& mark,
          std::span<std::uint32_t> chosen) {
  std::size_t i = 0;
  double sum = weight(0);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const double at = mark(k);
    while (sum <= at && i + 1 < samples) sum += weight(++i);
    while (weight(i) <= 0 && i > 0) --i, sum = std::numeric_limits<double>::infinity();
    chosen[k] = static_cast<std::uint32_t>(i);
  }
}

}  // namespace

double normalise(std::span<const double> log_weights, std::span<double> weights) {
  assert(log_weights.size() == weights.size());
  if (weights.empty()) return -std::numeric_limits<double>::infinity();
  const double top = *std::max_element(log_weights.begin(), log_weights.end());
  if (top == -std::numeric_limits<double>::infinity()) {
    std::fill(weights.begin(), weights.end(), 1 / static_cast<double>(weights.size()));
    return top;
  }
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    sum += weights[i] = std::exp(log_weights[i] - top);
  for (double& w : weights) w /= sum;
  return top + std::log(sum);
}

double effective_size(std::span<const double> weights) {
  double squares = 0;
  for (const double w : weights) squares += w * w;
  return squares > 0 ? 1 / squares : 0;
}

void resample_systematic(std::span<const double> weights, RandomStream& random,
                         std::span<std::uint32_t> chosen) {
  const double step = 1 / static_cast<double>(chosen.size()), first = random.uniform();
  pick(
      weights.size(), [&](std::size_t i) { return weights[i]; },
      [&](std::size_t k) { return (static_cast<double>(k) + first) * step; }, chosen);
}

void resample_stratified(std::span<const double> weights, RandomStream& random,
                         std::span<std::uint32_t> chosen) {
  const double step = 1 / static_cast<double>(chosen.size());
  pick(
      weights.size(), [&](std::size_t i) { return weights[i]; },
      [&](std::size_t k) { return (static_cast<double>(k) + random.uniform()) * step; }, chosen);
}

void resample_residual(std::span<const double> weights, RandomStream& random,
                       std::span<std::uint32_t> chosen) {
  const auto n = static_cast<double>(chosen.size());
  const auto sure = [&](std::size_t i) { return std::floor(n * weights[i]); };
  std::size_t filled = 0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    for (double copy = 0; copy < sure(i) && filled < chosen.size(); ++copy)
      chosen[filled++] = static_cast<std::uint32_t>(i);
  const auto left = chosen.subspan(filled);
  if (left.empty()) return;
  const double total = n - static_cast<double>(filled), first = random.uniform();
  pick(
      weights.size(), [&](std::size_t i) { return n * weights[i] - sure(i); },
      [&](std::size_t k) {
        return (static_cast<double>(k) + first) * total / static_cast<double>(left.size());
      },
      left);
  std::sort(chosen.begin(), chosen.end());
}

std::size_t kld_size(std::size_t bins, double epsilon, double z) {
  if (bins < 2) return 1;
  const double k = static_cast<double>(bins) - 1, a = 2 / (9 * k);
  const double root = 1 - a + std::sqrt(a) * z;
  return static_cast<std::size_t>(std::ceil(k / (2 * epsilon) * root * root * root));
}

}  // namespace majak::filter
