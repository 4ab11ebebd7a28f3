// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdlib>

#include "majak/io/nmea_log.hpp"
#include "tests/fuzz/fuzz.hpp"

/// Any bytes: reading ends, and fixes are finite, on the Earth.
MAJAK_FUZZ(bytes) {
  using namespace majak;
  io::looks_like_nmea(bytes);
  io::NmeaLog log(io::open_bytes_in_memory(bytes).bytes);
  while (const auto event = log.next()) {
    const auto& fix = std::get<GpsFix>(*event);
    const bool sound = std::hypot(fix.east, fix.north) < 3e7 && fix.sigma >= 0;
    if (!sound) std::abort();
  }
}
