// SPDX-License-Identifier: Apache-2.0
// Random numbers from streams that are keyed, not shared: stream (seed, step, particle) gives the
// same numbers whatever thread asks, and on every machine (no <random> distributions, whose output
// differs between standard libraries).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace majak {

/// SplitMix64 (Steele, Lea, Flood 2014) over a key made of (seed, step, index).
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed, std::uint64_t step = 0, std::uint64_t index = 0)
      : state_(mix(mix(mix(seed) ^ step) ^ index)) {}

  std::uint64_t bits() { return mix(state_ += kGamma); }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in {0 .. n-1}; n > 0.
  std::uint64_t below(std::uint64_t n) {
    return static_cast<std::uint64_t>(uniform() * static_cast<double>(n));
  }
  /// Standard normal (Box and Muller).
  double normal() {
    const double u = 1.0 - uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  static constexpr std::uint64_t kGamma = 0x9e3779b97f4a7c15ULL;
  static std::uint64_t mix(std::uint64_t z) {
    z += kGamma;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace majak
