// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdlib>

#include "majak/sensor/cola_emulator.hpp"
#include "majak/sensor/cola_session.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace majak;
using namespace majak::sensor;

void require(bool law) {
  if (!law) std::abort();
}

// What was read is written and read again without loss, in both dialects.
void check(const ColaTelegram& telegram) {
  ColaScan scan;
  try {
    scan = decode_scan(telegram);
  } catch (const Error&) {
    return;
  }
  for (const ColaDialect dialect : {ColaDialect::a, ColaDialect::b}) {
    const std::string written = encode_scan(scan, dialect);
    const ColaScan again = decode_scan({telegram.time, dialect, written});
    require(encode_scan(again, dialect) == written);
    require(encode_scan(again, ColaDialect::b) == encode_scan(scan, ColaDialect::b));
  }
  try {
    const Scan out = to_scan(scan);
    require(out.intensities.empty() || out.intensities.size() == out.ranges.size());
    for (const float range : out.ranges)
      require(std::isnan(range) || range == kNoReturn || (range > 0 && range < out.max_range));
  } catch (const Error&) {
  }
}

}  // namespace

/// Any bytes, in pieces whose sizes they state themselves: framer, scans, both sides of a session.
MAJAK_FUZZ(bytes) {
  const std::size_t piece = bytes.empty() ? 1 : 1 + static_cast<unsigned char>(bytes[0]);
  ColaFramer framer;
  ColaSession session;
  ColaEmulator device(
      {.beams = 3}, [](Time) { return std::vector{1.0}; }, 0);
  Time now = 0;
  session.start(now);
  const std::span all(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  for (std::size_t i = 0; i < all.size(); i += piece) {
    const auto part = all.subspan(i, std::min(piece, all.size() - i));
    framer.push(part, now);
    while (const auto telegram = framer.next()) {
      check(*telegram);
      cola_refusal(*telegram);
    }
    session.receive(part, now);
    session.advance(now);
    while (session.next()) continue;
    device.receive(part, now);
    device.advance(now);
    now += kSecond / 5;
    if (session.take_output().size() + device.take_output().size() > (4U << 20)) std::abort();
  }
}
