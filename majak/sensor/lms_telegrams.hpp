// SPDX-License-Identifier: Apache-2.0
// What the telegrams of a SICK LMS-2xx say, both sides: a host encodes commands and decodes
// replies, an emulated device the other way round. Scans are in lms_scan.hpp.
// Source: SICK telegram listing, 2006; checked against recorded traffic.
//
// Encoders throw Error for what no telegram can say; decoders give nothing for a telegram that is
// another one or does not have the right length.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "majak/sensor/lms291.hpp"
#include "majak/sensor/lms_configuration.hpp"
#include "majak/sensor/telegram.hpp"

namespace majak::sensor {

inline constexpr std::string_view kFactoryPassword = "SICK_LMS";
inline constexpr std::array<int, 4> kBauds{9600, 19200, 38400, 500000};

/// What follows 20: how the device works from now on.
enum class Mode : std::uint8_t {
  installation = 0x00,  ///< with the password; the configuration can be written
  diagnosis = 0x10,
  minimum_on_change = 0x20,  ///< 20 ... 23: nearest values by segment
  continuous = 0x24,         ///< every scan that the line has room for
  on_request = 0x25,         ///< silent, as after power-on
  continuous_mean = 0x26,
  continuous_subrange = 0x27,
  continuous_mean_subrange = 0x28,
  continuous_fields = 0x29,
  interlaced = 0x2A,  ///< every turn of the mirror by itself, one value a degree
  continuous_reflectivity = 0x2B,
  test_password = 0x30,
  baud_38400 = 0x40,
  baud_19200 = 0x41,
  baud_9600 = 0x42,
  baud_500000 = 0x48,
};

/// Which scan one request gives.
enum class ScanKind : std::uint8_t {
  whole = 0x01,
  minimum_vertical = 0x02,
  every_second = 0x06,
  every_twentieth = 0x07,
  partial = 0x08,
};

/// Beams by number, counted from 1, both ends belong to it.
struct Subrange {
  std::uint16_t first = 1;
  std::uint16_t last = 1;
  bool direct = false;  ///< send it before the scan is finished

  int size() const { return last - first + 1; }
  bool operator==(const Subrange&) const = default;
};

// ---- What a host asks. -------------------------------------------------------------------------

/// A command without parameters: reset, status, errors, counters, type, outputs, configuration,
/// configuration_2.
Telegram ask(Command command);

Telegram ask_mode(Mode mode);
Telegram ask_installation(std::string_view password = kFactoryPassword);  ///< 20 00
Telegram ask_test_password(std::string_view password);                    ///< 20 30
Telegram ask_baud(int baud);                                              ///< 20 4x; one of kBauds
Telegram ask_mean_stream(int scans);
Telegram ask_subrange_stream(const Subrange& beams);
Telegram ask_mean_subrange_stream(int scans, const Subrange& beams);
Telegram ask_fields_stream(const Subrange& beams);
Telegram ask_reflectivity_stream(std::span<const Subrange> beams);  ///< 1 ... 5 of them

Telegram ask_scan(ScanKind kind = ScanKind::whole);                       ///< 30
Telegram ask_mean_scan(int scans);                                        ///< 36
Telegram ask_subrange_scan(const Subrange& beams);                        ///< 37
Telegram ask_fields_scan(const Subrange& beams);                          ///< 3E
Telegram ask_mean_subrange_scan(int scans, const Subrange& beams);        ///< 3F
Telegram ask_active_fields(std::uint8_t set = 0);                         ///< 41
Telegram ask_s14_scan(const Subrange& reflectivities);                    ///< 44
Telegram ask_reflectivity_scan(std::span<const Subrange> beams);          ///< 75
Telegram ask_cartesian_scan(const Subrange& beams);                       ///< 76
Telegram ask_variant(const Variant& variant);                             ///< 3B
Telegram ask_write_configuration(const LmsConfiguration& configuration);  ///< 77
Telegram ask_write_configuration_2(std::span<const std::uint8_t> raw);    ///< 7C, 84 bytes

/// 66: the baud at power-on. 0: 9600. 1: whatever is set now - the device is deaf to everybody who
/// does not know it.
Telegram ask_power_on(std::uint8_t rule);

// ---- What a device reads out of it. ------------------------------------------------------------

std::optional<Mode> decode_mode(const Telegram& command);
/// The eight characters behind 20 00 and 20 30.
std::optional<std::string> decode_password(const Telegram& command);
/// Of 20 40, 41, 42, 48.
std::optional<int> decode_baud(const Telegram& command);
/// Of 3B, even if no device has such a variant.
std::optional<Variant> decode_variant(const Telegram& command);
/// Of 77.
std::optional<LmsConfiguration> decode_write_configuration(const Telegram& command);

/// How many scans to take the mean of, and the beams, of 36 37 3E 3F 75 and of 20 26 ... 20 2B.
struct ScanRequest {
  int mean_of = 1;
  std::vector<Subrange> beams;  ///< empty: all
};
std::optional<ScanRequest> decode_scan_request(const Telegram& command);

// ---- What a device says. -----------------------------------------------------------------------

/// Who speaks, and how it feels.
struct Sender {
  std::uint8_t address = kDeviceBit;  ///< 80 ... FF
  std::uint8_t status = kStatusFine;
};

/// 90 and BA: "LMS200;301063;V02.10 ".
struct LmsIdentity {
  std::string model;     ///< "LMS291"
  std::string type;      ///< "S05"
  std::string firmware;  ///< "V02.19"
  std::string text;      ///< as it came; what is encoded
  bool operator==(const LmsIdentity&) const = default;
};
LmsIdentity identity_of(std::string text);
std::optional<LmsIdentity> decode_identity(const Telegram& reply);  ///< 90 and BA
Telegram tell_identity(const LmsIdentity& identity, const Sender& from, bool power_on = false);

/// A0.
enum class ModeResult : std::uint8_t { done = 0, wrong_password = 1, fault = 2 };
std::optional<ModeResult> decode_mode_result(const Telegram& reply);
Telegram tell_mode_result(ModeResult result, const Sender& from);

/// BB.
struct VariantResult {
  bool accepted = false;
  Variant variant{180, 50};  ///< the one in force
};
std::optional<VariantResult> decode_variant_result(const Telegram& reply);
Telegram tell_variant_result(const VariantResult& result, const Sender& from);

/// B1.
struct LmsStatus {
  std::string firmware;  ///< "V02.19 "
  std::uint8_t mode = static_cast<std::uint8_t>(Mode::on_request);
  bool defect = false;
  std::string serial;                                    ///< eight characters
  std::array<std::uint16_t, 8> pollution{};              ///< of the window, by channel
  std::array<std::uint16_t, 8> pollution_calibration{};  ///< what a clean window has
  int motor = 148;                                       ///< us for 1/90 turn of the mirror
  std::uint8_t measuring_mode = 0;
  Variant variant{180, 50};
  int baud = 9600;  ///< 0 if the word is unknown
  bool permanent_baud = false;
  std::uint8_t address = 0;
  Unit unit = Unit::centimetre;
  bool laser_on = true;
  std::string boot_firmware;      ///< "V02.02 "
  std::vector<std::uint8_t> raw;  ///< 152 bytes as they came; the rest of what is encoded
};
std::optional<LmsStatus> decode_status(const Telegram& reply);
Telegram tell_status(const LmsStatus& status, const Sender& from);

/// B2.
struct LmsErrorEntry {
  enum class Severity : std::uint8_t { none, info, warning, error, fatal };
  Severity severity = Severity::none;
  bool current = true;  ///< false: it was once so
  std::uint8_t number = 0;
  bool operator==(const LmsErrorEntry&) const = default;
};
std::optional<std::vector<LmsErrorEntry>> decode_errors(const Telegram& reply);
Telegram tell_errors(std::span<const LmsErrorEntry> errors, const Sender& from);

/// B5.
struct LmsCounters {
  int hours = 0;  ///< of operation, in steps of two
  int switch_ons = 0;
};
std::optional<LmsCounters> decode_counters(const Telegram& reply);
Telegram tell_counters(const LmsCounters& counters, const Sender& from);

/// E6.
struct PowerOnResult {
  bool accepted = false;
  std::uint8_t rule = 0;  ///< the one in force, as ask_power_on() has it
};
std::optional<PowerOnResult> decode_power_on_result(const Telegram& reply);
Telegram tell_power_on_result(const PowerOnResult& result, const Sender& from);

/// F4.
std::optional<LmsConfiguration> decode_configuration(const Telegram& reply);
Telegram tell_configuration(const LmsConfiguration& configuration, const Sender& from);

/// F7.
struct ConfigurationResult {
  bool accepted = false;
  LmsConfiguration configuration;  ///< the one in force
};
std::optional<ConfigurationResult> decode_configuration_result(const Telegram& reply);
Telegram tell_configuration_result(const ConfigurationResult& result, const Sender& from);

/// FB (84 bytes), C0, CA and others whose content nothing here depends on.
std::optional<std::vector<std::uint8_t>> decode_raw(Reply code, const Telegram& reply);
Telegram tell_raw(Reply code, std::span<const std::uint8_t> data, const Sender& from);

/// A reply that says nothing but its code: 91 (reset comes), 92 (command refused).
Telegram tell(Reply code, const Sender& from);

}  // namespace majak::sensor
