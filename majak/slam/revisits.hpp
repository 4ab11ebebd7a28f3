// SPDX-License-Identifier: Apache-2.0
// Which key scans of other visits to a place a key scan is to be held against.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/slam/key_scan.hpp"
#include "majak/slam/loop_closing.hpp"

namespace majak::slam {

struct RevisitOptions {
  int count = 3;       ///< partners of a key scan
  double reach = 4.0;  ///< m, between the robots of a pair
  double known_way =
      100.0;  ///< m; two places farther apart by way are not known well enough to be paired
};

/// For every key scan the nearest older ones of other visits. Loop closing must have vouched for
/// the places: without it two corridors that only come to lie near each other would be made one.
std::vector<std::vector<std::size_t>> revisits(const KeyScans& keys, const LoopCloser& loops,
                                               const RevisitOptions& options);

}  // namespace majak::slam
