// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>

#include "majak/io/nmea_log.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

void read(const std::string& bytes) {
  using namespace majak;
  io::NmeaLog log(io::open_bytes_in_memory(bytes).bytes);
  while (const auto event = log.next()) {
    const auto& fix = std::get<GpsFix>(*event);
    const bool sound = std::hypot(fix.east, fix.north) < 1e9 && fix.sigma >= 0;
    if (!sound) std::abort();
  }
}

/// Every line as a sentence with the right checksum, which chance does not find.
std::string as_sentences(const std::string& bytes) {
  std::istringstream lines(bytes);
  std::string line, out;
  while (std::getline(lines, line)) {
    unsigned sum = 0;
    std::string text = line.substr(0, line.rfind('*'));
    if (text.starts_with('$')) text.erase(0, 1);
    for (const char c : text) sum ^= static_cast<unsigned char>(c);
    char tail[8];
    std::snprintf(tail, sizeof tail, "*%02X\n", sum);
    out += "$" + text + tail;
  }
  return out;
}

}  // namespace

/// Any bytes: reading ends, and fixes are finite.
MAJAK_FUZZ(bytes) {
  majak::io::looks_like_nmea(bytes);
  read(bytes);
  read(as_sentences(bytes));
}
