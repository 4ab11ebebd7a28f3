// SPDX-License-Identifier: Apache-2.0
// NormalTable: standard normal numbers from a RandomStream, several times as fast as Box and Muller
// and as exact: the ziggurat of Marsaglia and Tsang (2000) in Doornik's form (2005), whose 128
// layers of equal area are picked by bits that the number itself does not use.
//
//   const NormalTable normal;
//   const double z = normal(stream);
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "majak/core/random.hpp"

namespace majak {

class NormalTable {
 public:
  NormalTable() {
    double f = std::exp(-0.5 * kTail * kTail);
    edge_[0] = kArea / f;  // the lowest layer with its tail, as wide as its area asks
    edge_[1] = kTail;
    edge_[kLayers] = 0;
    for (std::size_t i = 2; i < kLayers; ++i) {
      edge_[i] = std::sqrt(-2 * std::log(kArea / edge_[i - 1] + f));
      f = std::exp(-0.5 * edge_[i] * edge_[i]);
    }
    for (std::size_t i = 0; i < kLayers; ++i) inside_[i] = edge_[i + 1] / edge_[i];
  }

  double operator()(RandomStream& stream) const {
    for (;;) {
      const std::uint64_t bits = stream.bits();
      const std::size_t i = bits % kLayers;
      const double u = static_cast<double>(bits >> 11) * 0x1.0p-52 - 1;  // in [-1, 1)
      if (std::abs(u) < inside_[i]) return u * edge_[i];
      if (i == 0) return beyond(stream, u < 0);
      const double x = u * edge_[i];
      const double below = std::exp(-0.5 * (edge_[i] * edge_[i] - x * x)),
                   above = std::exp(-0.5 * (edge_[i + 1] * edge_[i + 1] - x * x));
      if (below + stream.uniform() * (above - below) < 1) return x;
    }
  }

 private:
  static constexpr std::size_t kLayers = 128;
  static constexpr double kTail = 3.442619855899, kArea = 9.91256303526217e-3;

  /// The tail (Marsaglia 1964).
  static double beyond(RandomStream& stream, bool negative) {
    for (;;) {
      const double x = std::log(1 - stream.uniform()) / kTail;
      if (-2 * std::log(1 - stream.uniform()) < x * x) continue;
      return negative ? x - kTail : kTail - x;
    }
  }

  std::array<double, kLayers + 1> edge_{};
  std::array<double, kLayers> inside_{};
};

}  // namespace majak
