// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "majak/sensor/lms_driver.hpp"
#include "majak/sensor/lms_emulator.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace majak;
using namespace majak::sensor;

void require(bool law) {
  if (!law) std::abort();
}

void check_scan(const Telegram& telegram) {
  const auto scan = decode_scan(telegram);
  if (!scan) return;
  // Bits without a meaning may differ; what is understood may not.
  require(decode_scan(tell_scan(*scan, telegram.address)) == scan);
  for (const Variant& variant : kVariants) {
    if (!fits(*scan, variant)) continue;
    LmsConfiguration configuration = LmsConfiguration::factory();
    for (int mode = 0; mode < 16; ++mode) {
      configuration.set_measuring_mode(mode);
      try {
        const Scan out = to_scan(*scan, configuration, variant, 0);
        for (const float r : out.ranges) {
          require(std::isnan(r) || r == kNoReturn || (r > 0 && r < out.max_range));
        }
      } catch (const Error&) {
      }
    }
  }
}

// What has a meaning comes back from its encoder.
void check(const Telegram& t) {
  require(decode(encode(t)) == t);
  check_scan(t);
  decode_scan_request(t);
  if (const auto v = decode_variant(t)) require(decode_variant(ask_variant(*v)) == v);
  if (const auto c = decode_write_configuration(t)) {
    require(ask_write_configuration(*c).data == t.data);
  }
  if (!t.status) return;
  const Sender from{t.address, *t.status};
  if (const auto s = decode_status(t)) require(tell_status(*s, from) == t);
  if (const auto e = decode_errors(t)) require(tell_errors(*e, from) == t);
  if (const auto c = decode_counters(t)) require(tell_counters(*c, from) == t);
  if (const auto c = decode_configuration(t)) require(tell_configuration(*c, from) == t);
  if (const auto i = decode_identity(t)) {
    require(tell_identity(*i, from, t.is(Reply::power_on_identity)) == t);
  }
  decode_mode_result(t);
  decode_variant_result(t);
  decode_power_on_result(t);
  decode_configuration_result(t);
}

Telegram telegram_of(std::span<const std::uint8_t> bytes, bool device) {
  Telegram t;
  t.address = device ? kDeviceBit : 0;
  t.code = static_cast<std::uint8_t>(device ? bytes[0] | kDeviceBit : bytes[0] & ~kDeviceBit);
  t.data.assign(bytes.begin() + 1, bytes.end());
  if (device) t.status = kStatusFine;
  return t;
}

}  // namespace

/// First byte: what the others are. Bit 0: raw bytes for framers, driver and device, or the code
/// and the data of telegrams; the rest: the size of the pieces they come in.
MAJAK_FUZZ(text) {
  if (text.size() < 2) return;
  const std::span all(reinterpret_cast<const std::uint8_t*>(text.data()) + 1, text.size() - 1);
  const bool raw = (text[0] & 1) != 0;
  const std::size_t piece = 1 + 4U * (static_cast<unsigned char>(text[0]) >> 1);
  LmsEmulatorOptions options = lms291_s05();
  options.booted = true;
  LmsEmulator device(
      options,
      [](Time, const Variant& v) {
        return std::vector<double>(static_cast<std::size_t>(v.beams()), 3.0);
      },
      0);
  LmsDriver driver({}, 0);
  TelegramFramer framer(TelegramFramer::Direction::device_to_host);
  Time now = 0;
  for (std::size_t i = 0; i < all.size() && i < 20 * piece; i += piece) {
    const auto part = all.subspan(i, std::min(piece, all.size() - i));
    std::vector<std::uint8_t> to_host(part.begin(), part.end()), to_device = to_host;
    if (!raw) {
      const Telegram reply = telegram_of(part, true), command = telegram_of(part, false);
      check(reply);
      check(command);
      to_host = encode(reply);
      to_device = encode(command);
    }
    framer.push(to_host, now);
    while (const auto frame = framer.next()) {
      if (frame->kind == Frame::Kind::telegram) check(frame->telegram);
    }
    driver.receive(to_host, now);
    driver.advance(now);
    while (driver.next()) continue;
    device.receive(to_device, device.baud(), now);
    now += kSecond / 4;
    for (const Chunk& chunk : device.transmit(now, device.baud())) {
      driver.receive(chunk.bytes, chunk.end());
    }
    while (driver.next()) continue;
    driver.take_output();
  }
}
