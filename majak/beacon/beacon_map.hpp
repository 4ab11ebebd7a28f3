// SPDX-License-Identifier: Apache-2.0
// Beacons of known places, and where one has been seen from.
#pragma once

#include <string>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::beacon {

struct Beacon {
  int number = 0;  ///< not negative
  Vec2 p_map = Vec2::Zero();
  std::string name;
};

/// No number is in it twice.
struct BeaconMap {
  std::vector<Beacon> beacons;

  /// nullptr where no beacon has this number.
  const Beacon* find(int number) const {
    for (const Beacon& b : beacons)
      if (b.number == number) return &b;
    return nullptr;
  }
};

}  // namespace majak::beacon
