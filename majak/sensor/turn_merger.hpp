// SPDX-License-Identifier: Apache-2.0
// TurnMerger: the single turns of an interlaced device put together to whole scans.
//
// In the interlaced mode (20 2A) each turn of the mirror comes by itself: beams at whole degrees,
// in the next turn half a degree (or a quarter) on, and so forth. Each turn tells which part of a
// scan it is, and so when the first part of that scan was sent: turns that agree belong together.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "majak/sensor/lms_scan.hpp"

namespace majak::sensor {

/// What whole scans of an interlaced device look like: it measures 180 degrees whatever field of
/// view it is set to.
constexpr Variant merged_variant(const Variant& variant) { return {180, variant.resolution}; }

class TurnMerger {
 public:
  /// The whole scan that this turn completes, of merged_variant(variant) and as if it had been sent
  /// with this turn; nothing while turns are missing. `stamp`: when the turn began to be sent. What
  /// is no single turn of such a device is left out like one that was lost.
  std::optional<LmsScan> add(const LmsScan& turn, const Variant& variant, Time stamp);

  /// Scans given up because the next one began before all their turns had come.
  std::int64_t incomplete() const { return incomplete_; }

 private:
  /// The turns of one scan, as far as they have come.
  struct Set {
    Variant whole{180, 100};
    Time begin = 0;                     ///< stamp of its first turn
    std::optional<std::uint8_t> index;  ///< the device's counter in that turn, modulo 256
    std::vector<std::optional<LmsScan>> turns;
    std::size_t missing = 0;
  };
  static bool same(const Set& a, const Set& b);

  Set set_;
  std::int64_t incomplete_ = 0;
};

}  // namespace majak::sensor
