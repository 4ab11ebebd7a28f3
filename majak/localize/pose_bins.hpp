// SPDX-License-Identifier: Apache-2.0
// PoseBins: a histogram over (x, y, heading) that holds only what is not empty: a hash table of
// fixed size, cleared in no time. Headings are told apart by sin / (|sin| + |cos|), which rises
// with the angle and needs no arc tangent; a bin is 6 to 11 degrees wide.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace majak::localize {

class PoseBins {
 public:
  /// cell: m, side of a bin; most: poses that are added between two clear().
  PoseBins(double cell, std::size_t most) : inverse_(static_cast<float>(1 / cell)) {
    std::size_t size = 16;
    while (size < 2 * most) size *= 2;
    slots_.resize(size);
  }

  void clear() { ++round_, count_ = 0; }

  /// Adds to the bin of a pose; returns what is in it now.
  double add(float x, float y, float cos, float sin, double weight) {
    const std::uint64_t key = key_of(x, y, cos, sin);
    std::size_t at = (key * 0x9e3779b97f4a7c15ULL) >> 20;
    for (;; ++at) {
      Slot& slot = slots_[at &= slots_.size() - 1];
      if (slot.round == round_ && slot.key != key) continue;
      if (slot.round != round_) slot = {key, round_, 0}, ++count_;
      return slot.weight += weight;
    }
  }

  /// Bins that are not empty.
  std::size_t count() const { return count_; }

 private:
  struct Slot {
    std::uint64_t key = 0, round = 0;
    double weight = 0;
  };
  std::uint64_t key_of(float x, float y, float cos, float sin) const {
    const auto part = [](float v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v))) & 0x3fffff;
    };
    const float diamond = sin / (std::abs(sin) + std::abs(cos));
    return part(x * inverse_) << 36 | part(y * inverse_) << 12 |
           part((cos < 0 ? 2 - diamond : diamond) * 10 + 10);
  }

  float inverse_;
  std::uint64_t round_ = 1;
  std::size_t count_ = 0;
  std::vector<Slot> slots_;
};

}  // namespace majak::localize
