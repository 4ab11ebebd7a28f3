// SPDX-License-Identifier: Apache-2.0
// Replies, device to host.
#include <algorithm>
#include <string>

#include "majak/core/error.hpp"
#include "majak/sensor/lms_telegrams.hpp"
#include "majak/sensor/telegram_bytes.hpp"

namespace majak::sensor {

namespace {

Telegram reply(Reply code, std::vector<std::uint8_t> data, const Sender& from) {
  Telegram telegram;
  telegram.address = from.address | kDeviceBit;
  telegram.code = static_cast<std::uint8_t>(code);
  telegram.data = std::move(data);
  telegram.status = from.status;
  return telegram;
}

bool is(Reply code, std::size_t size, const Telegram& telegram) {
  return telegram.is(code) && telegram.data.size() == size;
}

std::string text_at(std::span<const std::uint8_t> data, std::size_t from, std::size_t n) {
  return {data.begin() + static_cast<std::ptrdiff_t>(from),
          data.begin() + static_cast<std::ptrdiff_t>(from + n)};
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(' ');
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

}  // namespace

Telegram tell(Reply code, const Sender& from) { return reply(code, {}, from); }

std::optional<std::vector<std::uint8_t>> decode_raw(Reply code, const Telegram& telegram) {
  if (!telegram.is(code)) return {};
  return telegram.data;
}
Telegram tell_raw(Reply code, std::span<const std::uint8_t> data, const Sender& from) {
  return reply(code, {data.begin(), data.end()}, from);
}

LmsIdentity identity_of(std::string text) {
  LmsIdentity identity;
  const auto first = text.find(';');
  identity.model = trimmed(text.substr(0, first));
  if (first != std::string::npos) {
    const auto second = text.find(';', first + 1);
    identity.type = trimmed(text.substr(first + 1, second - first - 1));
    if (second != std::string::npos) identity.firmware = trimmed(text.substr(second + 1));
  }
  identity.text = std::move(text);
  return identity;
}

std::optional<LmsIdentity> decode_identity(const Telegram& telegram) {
  if (!telegram.is(Reply::identity) && !telegram.is(Reply::power_on_identity)) return {};
  return identity_of(text_at(telegram.data, 0, telegram.data.size()));
}
Telegram tell_identity(const LmsIdentity& identity, const Sender& from, bool power_on) {
  return reply(power_on ? Reply::power_on_identity : Reply::identity,
               {identity.text.begin(), identity.text.end()}, from);
}

std::optional<ModeResult> decode_mode_result(const Telegram& telegram) {
  if (!is(Reply::mode, 1, telegram)) return {};
  return static_cast<ModeResult>(telegram.data[0]);
}
Telegram tell_mode_result(ModeResult result, const Sender& from) {
  return reply(Reply::mode, {static_cast<std::uint8_t>(result)}, from);
}

std::optional<VariantResult> decode_variant_result(const Telegram& telegram) {
  if (!is(Reply::variant, 5, telegram)) return {};
  return VariantResult{telegram.data[0] == 1, {get_16(telegram.data, 1), get_16(telegram.data, 3)}};
}
Telegram tell_variant_result(const VariantResult& result, const Sender& from) {
  std::vector<std::uint8_t> data{static_cast<std::uint8_t>(result.accepted ? 1 : 0)};
  put_16(data, static_cast<unsigned>(result.variant.field_of_view));
  put_16(data, static_cast<unsigned>(result.variant.resolution));
  return reply(Reply::variant, std::move(data), from);
}

// ---- Status: where what stands among the 152 bytes. --------------------------------------------

namespace {

constexpr std::size_t kStatusSize = 152;
constexpr std::size_t kFirmwareAt = 0, kModeAt = 7, kDefectAt = 8, kSerialAt = 9, kPollutionAt = 18,
                      kPollutionCalibrationAt = 42, kMotorAt = 66, kMeasuringModeAt = 101,
                      kFieldOfViewAt = 106, kResolutionAt = 108, kBaudAt = 115,
                      kPermanentBaudAt = 118, kAddressAt = 119, kUnitAt = 121, kLaserOnAt = 122,
                      kBootFirmwareAt = 123;
constexpr std::size_t kVersionLength = 7, kSerialLength = 8;

/// The UART's divider: the true rate is 1 MHz / (low byte + 1).
struct BaudWord {
  int baud;
  unsigned word;
};
constexpr std::array<BaudWord, 4> kBaudWords{
    {{9600, 0x8067}, {19200, 0x8033}, {38400, 0x8019}, {500000, 0x8001}}};

int baud_of(unsigned word) {
  for (const BaudWord& b : kBaudWords) {
    if (b.word == word) return b.baud;
  }
  return 0;
}

void put_text(std::span<std::uint8_t> data, std::size_t at, std::size_t n, std::string_view text) {
  for (std::size_t i = 0; i < n; ++i) {
    data[at + i] = static_cast<std::uint8_t>(i < text.size() ? text[i] : ' ');
  }
}

}  // namespace

std::optional<LmsStatus> decode_status(const Telegram& telegram) {
  if (!is(Reply::status, kStatusSize, telegram)) return {};
  const std::vector<std::uint8_t>& data = telegram.data;
  LmsStatus s;
  s.firmware = text_at(data, kFirmwareAt, kVersionLength);
  s.mode = data[kModeAt];
  s.defect = data[kDefectAt] != 0;
  s.serial = text_at(data, kSerialAt, kSerialLength);
  for (std::size_t i = 0; i < s.pollution.size(); ++i) {
    s.pollution[i] = get_16(data, kPollutionAt + 2 * i);
    s.pollution_calibration[i] = get_16(data, kPollutionCalibrationAt + 2 * i);
  }
  s.motor = get_16(data, kMotorAt);
  s.measuring_mode = data[kMeasuringModeAt];
  s.variant = {get_16(data, kFieldOfViewAt), get_16(data, kResolutionAt)};
  s.baud = baud_of(get_16(data, kBaudAt));
  s.permanent_baud = data[kPermanentBaudAt] != 0;
  s.address = data[kAddressAt];
  s.unit = static_cast<Unit>(data[kUnitAt]);
  s.laser_on = data[kLaserOnAt] != 0;
  s.boot_firmware = text_at(data, kBootFirmwareAt, kVersionLength);
  s.raw = data;
  return s;
}

Telegram tell_status(const LmsStatus& s, const Sender& from) {
  std::vector<std::uint8_t> data = s.raw;
  data.resize(kStatusSize);
  put_text(data, kFirmwareAt, kVersionLength, s.firmware);
  data[kModeAt] = s.mode;
  // Flags keep their byte where it says the same.
  const auto put_flag = [&](std::size_t at, bool flag) {
    if ((data[at] != 0) != flag) data[at] = flag ? 1 : 0;
  };
  put_flag(kDefectAt, s.defect);
  put_text(data, kSerialAt, kSerialLength, s.serial);
  for (std::size_t i = 0; i < s.pollution.size(); ++i) {
    set_16(data, kPollutionAt + 2 * i, s.pollution[i]);
    set_16(data, kPollutionCalibrationAt + 2 * i, s.pollution_calibration[i]);
  }
  set_16(data, kMotorAt, static_cast<unsigned>(s.motor));
  data[kMeasuringModeAt] = s.measuring_mode;
  set_16(data, kFieldOfViewAt, static_cast<unsigned>(s.variant.field_of_view));
  set_16(data, kResolutionAt, static_cast<unsigned>(s.variant.resolution));
  for (const BaudWord& b : kBaudWords) {
    if (b.baud == s.baud) set_16(data, kBaudAt, b.word);
  }
  put_flag(kPermanentBaudAt, s.permanent_baud);
  data[kAddressAt] = s.address;
  data[kUnitAt] = static_cast<std::uint8_t>(s.unit);
  put_flag(kLaserOnAt, s.laser_on);
  put_text(data, kBootFirmwareAt, kVersionLength, s.boot_firmware);
  return reply(Reply::status, std::move(data), from);
}

// ---- The smaller ones. -------------------------------------------------------------------------

std::optional<std::vector<LmsErrorEntry>> decode_errors(const Telegram& telegram) {
  if (!telegram.is(Reply::errors) || telegram.data.size() % 2 != 0) return {};
  std::vector<LmsErrorEntry> errors;
  for (std::size_t i = 0; i < telegram.data.size(); i += 2) {
    const std::uint8_t type = telegram.data[i];
    errors.push_back({static_cast<LmsErrorEntry::Severity>(type & 0x7F), (type & 0x80) == 0,
                      telegram.data[i + 1]});
  }
  return errors;
}
Telegram tell_errors(std::span<const LmsErrorEntry> errors, const Sender& from) {
  std::vector<std::uint8_t> data;
  for (const LmsErrorEntry& e : errors) {
    data.push_back(
        static_cast<std::uint8_t>(static_cast<unsigned>(e.severity) | (e.current ? 0u : 0x80u)));
    data.push_back(e.number);
  }
  return reply(Reply::errors, std::move(data), from);
}

std::optional<LmsCounters> decode_counters(const Telegram& telegram) {
  if (!is(Reply::counters, 4, telegram)) return {};
  return LmsCounters{2 * get_16(telegram.data, 0), get_16(telegram.data, 2)};
}
Telegram tell_counters(const LmsCounters& counters, const Sender& from) {
  std::vector<std::uint8_t> data;
  put_16(data, static_cast<unsigned>(counters.hours / 2));
  put_16(data, static_cast<unsigned>(counters.switch_ons));
  return reply(Reply::counters, std::move(data), from);
}

std::optional<PowerOnResult> decode_power_on_result(const Telegram& telegram) {
  if (!is(Reply::power_on, 2, telegram)) return {};
  return PowerOnResult{telegram.data[0] == 1, telegram.data[1]};
}
Telegram tell_power_on_result(const PowerOnResult& result, const Sender& from) {
  return reply(Reply::power_on, {static_cast<std::uint8_t>(result.accepted ? 1 : 0), result.rule},
               from);
}

std::optional<LmsConfiguration> decode_configuration(const Telegram& telegram) {
  if (!telegram.is(Reply::configuration)) return {};
  if (!LmsConfiguration::is_size(telegram.data.size())) return {};
  return LmsConfiguration{telegram.data};
}
Telegram tell_configuration(const LmsConfiguration& configuration, const Sender& from) {
  return reply(Reply::configuration, configuration.raw, from);
}

std::optional<ConfigurationResult> decode_configuration_result(const Telegram& telegram) {
  if (!telegram.is(Reply::configuration_written) || telegram.data.empty()) return {};
  if (!LmsConfiguration::is_size(telegram.data.size() - 1)) return {};
  return ConfigurationResult{telegram.data[0] == 1,
                             LmsConfiguration{{telegram.data.begin() + 1, telegram.data.end()}}};
}
Telegram tell_configuration_result(const ConfigurationResult& result, const Sender& from) {
  std::vector<std::uint8_t> data{static_cast<std::uint8_t>(result.accepted ? 1 : 0)};
  data.insert(data.end(), result.configuration.raw.begin(), result.configuration.raw.end());
  return reply(Reply::configuration_written, std::move(data), from);
}

}  // namespace majak::sensor
