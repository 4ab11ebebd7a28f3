// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdlib>

#include "majak/io/player_log.hpp"
#include "tests/fuzz/fuzz.hpp"

/// Any bytes: reading ends, and ranges are what Scan promises.
MAJAK_FUZZ(bytes) {
  using namespace majak;
  io::looks_like_player(bytes);
  io::PlayerLog log(io::open_bytes_in_memory(bytes).bytes);
  while (const auto event = log.next()) {
    const Scan* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr) continue;
    for (const float range : scan->ranges) {
      const bool sound =
          std::isnan(range) || range == kNoReturn || (range > 0 && range < scan->max_range);
      if (!sound) std::abort();
    }
  }
}
