// SPDX-License-Identifier: Apache-2.0
// The frame that every message of a SICK LMS-2xx travels in, both ways.
//
//   02 | address | length, 2 bytes | code | data ... | status | CRC, 2 bytes
//
// Numbers have their low byte first. The length counts from the code to the status. Only what the
// device sends has a status byte, and an address with bit 7 set. Before a reply the device sends
// one bare byte: 06 (ACK, understood) or 15 (NAK, damaged). Source: SICK telegram listing, 2006.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace majak::sensor {

inline constexpr std::uint8_t kStx = 0x02;
inline constexpr std::uint8_t kAck = 0x06;
inline constexpr std::uint8_t kNak = 0x15;
inline constexpr std::uint8_t kDeviceBit = 0x80;             ///< of a device's address and codes
inline constexpr std::size_t kTelegramEnvelope = 6;          ///< bytes that the length leaves out
inline constexpr std::size_t kLongestTelegramLength = 1024;  ///< real ones stay below 810
inline constexpr std::uint8_t kStatusFine = 0x10;            ///< a standard LMS without a complaint

/// What a host asks.
enum class Command : std::uint8_t {
  reset = 0x10,
  mode = 0x20,
  scan = 0x30,
  status = 0x31,
  errors = 0x32,
  counters = 0x35,
  mean_scan = 0x36,
  subrange_scan = 0x37,
  type = 0x3A,
  variant = 0x3B,
  fields_scan = 0x3E,
  mean_subrange_scan = 0x3F,
  fields = 0x40,
  active_fields = 0x41,
  s14_scan = 0x44,
  outputs = 0x4A,
  power_on = 0x66,
  configuration = 0x74,
  reflectivity_scan = 0x75,
  cartesian_scan = 0x76,
  write_configuration = 0x77,
  configuration_2 = 0x7B,
  write_configuration_2 = 0x7C,
};

/// What a device says: the command's code and bit 7, with three exceptions.
enum class Reply : std::uint8_t {
  power_on_identity = 0x90,  ///< unasked, at the end of the boot
  reset = 0x91,
  refused = 0x92,  ///< unknown command, wrong mode or bad parameter
  mode = 0xA0,
  scan = 0xB0,
  status = 0xB1,
  errors = 0xB2,
  counters = 0xB5,
  mean_scan = 0xB6,
  subrange_scan = 0xB7,
  identity = 0xBA,
  variant = 0xBB,
  fields_scan = 0xBE,
  mean_subrange_scan = 0xBF,
  fields = 0xC0,
  active_fields = 0xC1,
  s14_scan = 0xC4,
  outputs = 0xCA,
  power_on = 0xE6,
  configuration = 0xF4,
  reflectivity_scan = 0xF5,
  cartesian_scan = 0xF6,
  configuration_written = 0xF7,
  configuration_2 = 0xFB,
  configuration_2_written = 0xFC,
};

struct Telegram {
  std::uint8_t address = 0;  ///< 0 everybody, 1 ... 7F one device; a device sends its own + 80
  std::uint8_t code = 0;
  std::vector<std::uint8_t> data;      ///< after the code, without the status
  std::optional<std::uint8_t> status;  ///< what a device sends has one

  bool is(Command command) const { return code == static_cast<std::uint8_t>(command); }
  bool is(Reply reply) const { return code == static_cast<std::uint8_t>(reply); }
  bool operator==(const Telegram&) const = default;
};

/// The check sum over STX ... status. It is SICK's own: the register moves by one bit a byte.
std::uint16_t telegram_crc(std::span<const std::uint8_t> bytes);

/// The whole frame. Throws Error if the data are longer than a telegram can be.
std::vector<std::uint8_t> encode(const Telegram& telegram);

/// The telegram of a whole frame; nothing if a byte is damaged, missing or too many.
std::optional<Telegram> decode(std::span<const std::uint8_t> frame);

}  // namespace majak::sensor
