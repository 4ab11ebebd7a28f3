// SPDX-License-Identifier: Apache-2.0
// The configuration block in the device's EEPROM: 34 bytes, 32 with old firmware. All bytes are
// kept as they came, so that what is written back differs only where it was meant to.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace majak::sensor {

enum class Unit : std::uint8_t { centimetre = 0, millimetre = 1, decimetre = 2 };

/// Metres a step; 0 for a unit that does not exist.
double metres(Unit unit);

struct LmsConfiguration {
  static constexpr std::size_t kSize = 34, kOldSize = 32;

  std::vector<std::uint8_t> raw;  ///< 34 or 32 bytes

  /// As an LMS-291 leaves the factory: centimetres, 82 m, fields A and B, dazzle flag.
  static LmsConfiguration factory(std::size_t size = kSize);
  static bool is_size(std::size_t bytes) { return bytes == kSize || bytes == kOldSize; }

  int blanking() const { return raw[0] | raw[1] << 8; }  ///< cm, echoes nearer are not looked at
  int stop_threshold() const { return raw[2]; }          ///< mV; LMS-200 and 220
  /// 0 standard (30 m on 10 %), 1 medium (25 m), 2 low (20 m), 3 high (42 m); LMS-211, 221, 291.
  int sensitivity() const { return raw[3]; }
  int availability() const { return raw[4]; }
  bool real_time_indices() const { return (raw[4] & 2) != 0; }  ///< scans carry two counters
  int measuring_mode() const { return raw[5]; }
  Unit unit() const { return static_cast<Unit>(raw[6]); }

  void set_sensitivity(int value) { raw[3] = static_cast<std::uint8_t>(value); }
  void set_real_time_indices(bool on);
  void set_measuring_mode(int mode) { raw[5] = static_cast<std::uint8_t>(mode); }
  void set_unit(Unit unit) { raw[6] = static_cast<std::uint8_t>(unit); }

  bool operator==(const LmsConfiguration&) const = default;
};

}  // namespace majak::sensor
