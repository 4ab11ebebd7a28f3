// SPDX-License-Identifier: Apache-2.0
// LMDscandata: one turn of an LMS1xx, LMS5xx or TiM, as the device states it (integers in its own
// units), and what a Scan makes of it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/sensor/cola.hpp"

namespace majak::sensor {

/// One value for each beam: DIST1 ... DIST5, RSSI1 ... RSSI5 (echoes), ANGL1, VANG1, REFL1, QLTY1.
struct ColaChannel {
  std::string name;
  float scale = 1, offset = 0;   ///< value = raw * scale + offset; mm for DIST
  std::int32_t start_angle = 0;  ///< 1/10000 deg, the device's own: 90 deg is straight ahead
  std::uint16_t angle_step = 0;  ///< 1/10000 deg
  std::vector<std::uint16_t> raw;
  bool operator==(const ColaChannel&) const = default;
};

struct ColaEncoder {
  std::uint32_t position = 0;
  std::uint16_t speed = 0;
  bool operator==(const ColaEncoder&) const = default;
};

/// The position that was typed into the device; floats as they stand there.
struct ColaPosition {
  std::array<float, 3> place{}, rotation{};
  std::uint8_t rotation_type = 0, sends_name = 0;
  bool operator==(const ColaPosition&) const = default;
};

/// The device's own calendar.
struct ColaDate {
  std::uint16_t year = 0;
  std::uint8_t month = 0, day = 0, hour = 0, minute = 0, second = 0;
  std::uint32_t microsecond = 0;
  bool operator==(const ColaDate&) const = default;
};

struct ColaScan {
  Time time = 0;       ///< arrival of the telegram's first byte
  bool asked = false;  ///< an answer (sRA), not of the stream (sSN)
  std::uint16_t version = 1, device = 1;
  std::uint32_t serial = 0;
  std::array<std::uint8_t, 2> status{};  ///< 0 0: all is well
  std::uint16_t telegram_counter = 0;    ///< telegrams that the device handed out
  std::uint16_t scan_counter = 0;        ///< turns that it measured
  std::uint32_t first_shot = 0;          ///< us since power-up, wraps after 71.6 min
  std::uint32_t transmission = 0;        ///< us, when it began to send
  std::array<std::uint8_t, 2> inputs{}, outputs{};
  std::uint16_t layer = 0;           ///< 0 for devices with one plane
  std::uint32_t mirror_rate = 0;     ///< 1/100 Hz
  std::uint32_t measuring_rate = 0;  ///< 100 Hz; some firmware states a hundred times as much
  std::vector<ColaEncoder> encoders;
  std::vector<ColaChannel> channels16, channels8;
  std::optional<ColaPosition> position;
  std::optional<std::string> name, comment;
  std::optional<ColaDate> date;
  bool operator==(const ColaScan&) const = default;

  /// The channel of this name among the 16-bit and 8-bit ones, nullptr if it was not sent.
  const ColaChannel* channel(std::string_view name) const;
};

/// Reads "sSN LMDscandata" or "sRA LMDscandata", field by field as its counts say. Throws Error,
/// one line with byte and field, for another telegram, one that was cut, or one with impossible
/// fields. What stands behind the event's flag is not read.
ColaScan decode_scan(const ColaTelegram& telegram);
/// The payload that decode_scan() reads; an event flag of 0 at its end.
std::string encode_scan(const ColaScan& scan, ColaDialect dialect);

/// "all is well", "pollution warning", "pollution error", "device error".
const char* cola_status_words(const std::array<std::uint8_t, 2>& status);

struct ColaScanOptions {
  double max_range = 0;          ///< m, of the device; the channel may end sooner; 0: where it ends
  double ahead = radians(90.0);  ///< rad, the device's angle that looks along x
  int echo = 1;                  ///< 1 ... 5, of LMS5xx
};
void describe(OptionFields& fields, ColaScanOptions& options);

/// Raw distances below this are codes: 0 no echo, 1 dazzled, others reserved or for internal
/// errors.
inline constexpr std::uint16_t kFirstColaDistance = 16;

/// What the device measured. Bearings in the laser's frame, ranges in m: kNoReturn for no echo and
/// from max_range on, kInvalidRange for the other codes. RSSI of the same echo as intensities where
/// it was sent for the same beams. The time is that of the first beam. Throws Error when the echo
/// was not sent or the channel's scale means nothing.
Scan to_scan(const ColaScan& scan, const ColaScanOptions& options = {});

/// Degrees between beams, in 1/10000: telegrams round thirds and twelfths of a degree, whose sum
/// over 811 beams would be 0.03 deg.
double exact_cola_step(std::uint16_t angle_step);

/// From the first shot to the moment in which the telegram was sent, by the device's own clock;
/// nothing if that clock makes no sense (more than kLongestColaDelay).
std::optional<Duration> cola_delay(const ColaScan& scan);
inline constexpr Duration kLongestColaDelay = kSecond;

/// When this beam was fired, after beam 0: the mirror turns steadily. 0 if the telegram states no
/// rate.
Duration cola_beam_time(const ColaScan& scan, std::size_t beam);

}  // namespace majak::sensor
