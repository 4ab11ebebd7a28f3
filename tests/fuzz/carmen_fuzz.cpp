// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdlib>

#include "majak/io/carmen_reader.hpp"
#include "tests/fuzz/fuzz.hpp"

/// Any bytes, plain or packed: reading ends, and ranges are what Scan promises.
MAJAK_FUZZ(bytes) {
  using namespace majak;
  io::looks_like_carmen(bytes);
  io::CarmenReader reader(io::open_bytes_in_memory(bytes).bytes, "CARMEN log");
  while (const auto event = reader.next()) {
    const Scan* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr) continue;
    for (const float range : scan->ranges) {
      const bool sound =
          std::isnan(range) || range == kNoReturn || (range > 0 && range < scan->max_range);
      if (!sound) std::abort();
    }
  }
}
