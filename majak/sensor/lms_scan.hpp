// SPDX-License-Identifier: Apache-2.0
// The telegrams of a SICK LMS-2xx that carry measured values, and the Scan they become.
//
// B0 whole scan or one turn of the mirror, B6 mean of several, B7 some beams, BF mean of some
// beams, BE some beams with their fields, F5 some beams with reflectivities, C4 a whole scan with
// reflectivities (type S14). Source: SICK telegram listing, 2006.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/sensor/lms291.hpp"
#include "majak/sensor/lms_configuration.hpp"
#include "majak/sensor/lms_telegrams.hpp"
#include "majak/sensor/telegram.hpp"

namespace majak::sensor {

/// The status byte that ends every telegram of a device.
struct LmsHealth {
  using Severity = LmsErrorEntry::Severity;
  Severity severity = Severity::none;  ///< info is normal: something once happened
  bool restart = false;                ///< level of the restart input
  bool implausible = false;            ///< measured values cannot be trusted
  bool pollution = false;              ///< of the front window
  bool operator==(const LmsHealth&) const = default;
};
LmsHealth health_of(std::uint8_t status);

/// One telegram of measured values, as sent.
struct LmsScan {
  Reply code = Reply::scan;
  Unit unit = Unit::centimetre;
  bool partial = false;         ///< one turn of the mirror: a value a degree, always 180 degrees
  int quarter = 0;              ///< of a partial scan: its beams are at n + quarter / 4 degrees
  int mean_of = 1;              ///< scans
  std::vector<Subrange> beams;  ///< which; empty: all
  std::vector<std::uint16_t> values;          ///< one a beam, with flags, see decode_values()
  std::vector<std::uint16_t> reflectivities;  ///< F5: one a value; C4: one of each below
  Subrange reflectivity_beams;                ///< C4: those that have one
  std::vector<std::array<std::uint16_t, 3>> fields;  ///< BE: fields A, B, C, one a value
  std::optional<std::uint8_t> scan_index;            ///< turns of the mirror, modulo 256
  std::optional<std::uint8_t> telegram_index;        ///< telegrams sent, modulo 256
  std::uint8_t status = kStatusFine;

  LmsHealth health() const { return health_of(status); }
  bool operator==(const LmsScan&) const = default;
};

/// Nothing for a telegram that is none of those above, or whose counts contradict its length.
std::optional<LmsScan> decode_scan(const Telegram& telegram);

/// The other way round, for an emulated device. Throws Error if the counts do not fit.
Telegram tell_scan(const LmsScan& scan, std::uint8_t address = kDeviceBit);

/// How one value splits into distance and flags; that depends on the measuring mode.
struct ValueLayout {
  int distance_bits = 13;  ///< 13: up to 81 m in centimetres, 8 m in millimetres; 14, 15: more
  int fields = 0;          ///< bits for fields A, B, C above the distance, in this order
  int reflector = 0;       ///< bits for the level of a reflector, above those
  bool dazzle = false;     ///< bit 15: dazzled

  /// The first code that is no distance. 1FF7 with 13 bits, 3FF7 with 14 ...
  unsigned first_code() const { return (1u << distance_bits) - 9; }
};
/// Nothing for a mode that sends no distances (3F: energies) or is not known.
std::optional<ValueLayout> value_layout(int measuring_mode);

/// Meanings of the values from first_code() on, as offsets from it.
enum class ValueCode : unsigned {
  too_far = 0,
  read_error = 3,
  too_weak = 4,  ///< an echo too weak to be measured
  overflow = 6,
  dazzled = 7,
  no_echo = 8,
};

struct LmsValues {
  static constexpr std::uint8_t kFieldA = 1, kFieldB = 2, kFieldC = 4, kDazzled = 8;

  std::vector<float> ranges;        ///< m; kNoReturn: no echo or too far; kInvalidRange: not known
  std::vector<std::uint8_t> flags;  ///< kFieldA | ...
  std::vector<std::uint8_t> reflector;  ///< level, 0 none
  float max_range = 0;                  ///< m; returns lie strictly below
};
/// Throws Error for a measuring mode without distances and for an unknown unit. A value of zero
/// is no distance; a dazzled one is not believed.
LmsValues decode_values(const LmsScan& scan, int measuring_mode);

/// The value that a device sends for a range: not a number is too weak an echo, infinity none.
/// In a measuring mode without distances: always the same.
std::uint16_t encode_value(double range, Unit unit, int measuring_mode);

/// Whether the number of values is the one that a device set to this variant sends.
bool fits(const LmsScan& scan, const Variant& variant);

/// Turns of the mirror from the first beam of such a scan to the moment it is sent.
int turns(const LmsScan& scan, const Variant& variant);

/// The scan in the laser's frame: ahead is the middle beam, counter-clockwise as the device turns.
/// Beams that a telegram of some beams leaves out are kInvalidRange. A device begins to send when
/// the last turn is over, so beam 0 was fired turns() of the mirror before the first byte began.
/// Throws Error as decode_values(), and if the scan does not fit the variant.
Scan to_scan(const LmsScan& scan, const LmsConfiguration& configuration, const Variant& variant,
             Time first_byte);

}  // namespace majak::sensor
