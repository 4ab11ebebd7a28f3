// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/histogram.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace majak::filter {
namespace {

constexpr double kTail = 1e-6;    // mass of a Gaussian that may be cut off
constexpr double kSampled = 100;  // cells^2 from where on a sampled Gaussian is exact as well

// exp(-t) I_n(t) for n = 0, 1, ... until all but kTail is in.
std::vector<double> half_gaussian(double t) {
  std::vector<double> half;
  double mass = 0;
  for (int n = 0; mass < 1 - kTail; ++n) {
    half.push_back(t < kSampled ? std::exp(-t) * std::cyl_bessel_i(double(n), t)
                                : std::exp(-n * n / (2 * t)) / std::sqrt(2 * std::acos(-1) * t));
    mass += (n == 0 ? 1 : 2) * half.back();
  }
  return half;
}

}  // namespace

Kernel motion_kernel(double shift, double variance) {
  const double whole = std::floor(shift), f = shift - whole;
  const std::vector<double> half = half_gaussian(std::max(0.0, variance - f * (1 - f)));
  const int radius = static_cast<int>(half.size()) - 1;
  Kernel kernel{static_cast<int>(whole) - radius,
                std::vector<double>(2 * half.size() - (f > 0 ? 0 : 1))};
  for (int n = -radius; n <= radius; ++n) {
    const double g = half[static_cast<std::size_t>(std::abs(n))];
    kernel.taps[static_cast<std::size_t>(n + radius)] += (1 - f) * g;
    if (f > 0) kernel.taps[static_cast<std::size_t>(n + radius + 1)] += f * g;
  }
  const double sum = std::accumulate(kernel.taps.begin(), kernel.taps.end(), 0.0);
  for (double& tap : kernel.taps) tap /= sum;
  return kernel;
}

double entropy(std::span<const double> p) {
  double sum = 0;
  for (const double q : p)
    if (q > 0) sum -= q * std::log(q);
  return sum;
}

Histogram Histogram::uniform(std::size_t cells, bool cyclic) {
  return {std::vector<double>(cells, 1 / static_cast<double>(cells)), cyclic};
}

void Histogram::move(double shift, double variance) {
  const Kernel kernel = motion_kernel(shift, variance);
  const int n = static_cast<int>(p.size());
  std::vector<double> moved(p.size());
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < static_cast<int>(kernel.taps.size()); ++k) {
      const int to = i + kernel.first + k;
      const int cell = cyclic ? ((to % n) + n) % n : std::clamp(to, 0, n - 1);
      moved[static_cast<std::size_t>(cell)] +=
          kernel.taps[static_cast<std::size_t>(k)] * p[static_cast<std::size_t>(i)];
    }
  p = std::move(moved);
}

double Histogram::see(std::span<const double> likelihood) {
  const double evidence = std::inner_product(p.begin(), p.end(), likelihood.begin(), 0.0);
  if (!(evidence > 0)) return 0;
  for (std::size_t i = 0; i < p.size(); ++i) p[i] *= likelihood[i] / evidence;
  return evidence;
}

}  // namespace majak::filter
