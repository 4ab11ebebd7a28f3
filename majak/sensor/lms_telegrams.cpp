// SPDX-License-Identifier: Apache-2.0
// Commands, host to device.
#include "majak/sensor/lms_telegrams.hpp"

#include <algorithm>

#include "majak/core/error.hpp"
#include "majak/sensor/telegram_bytes.hpp"

namespace majak::sensor {

namespace {

constexpr std::size_t kPasswordLength = 8, kConfiguration2Size = 84;
constexpr int kMostBeams = 401;

Telegram command(Command code, std::vector<std::uint8_t> data) {
  Telegram telegram;
  telegram.code = static_cast<std::uint8_t>(code);
  telegram.data = std::move(data);
  return telegram;
}

std::vector<std::uint8_t> mode_byte(Mode mode) { return {static_cast<std::uint8_t>(mode)}; }

Telegram with_password(Mode mode, std::string_view password) {
  const auto allowed = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
  };
  if (password.size() != kPasswordLength ||
      !std::all_of(password.begin(), password.end(), allowed)) {
    throw Error("the password of an LMS-2xx has 8 characters out of 0-9 A-Z a-z _");
  }
  auto data = mode_byte(mode);
  data.insert(data.end(), password.begin(), password.end());
  return command(Command::mode, std::move(data));
}

std::uint8_t scans_of(int scans) {
  if (scans < 2 || scans > 250) {
    throw Error("a mean of " + std::to_string(scans) + " scans: choose 2 ... 250");
  }
  return static_cast<std::uint8_t>(scans);
}

void put_beams(std::vector<std::uint8_t>& data, const Subrange& beams) {
  if (beams.first < 1 || beams.last < beams.first || beams.last > kMostBeams) {
    throw Error("beams " + std::to_string(beams.first) + " ... " + std::to_string(beams.last) +
                ": they count from 1 to 401");
  }
  put_16(data, beams.first);
  put_16(data, beams.last | (beams.direct ? 0x8000u : 0u));
}

void put_list(std::vector<std::uint8_t>& data, std::span<const Subrange> beams) {
  if (beams.empty() || beams.size() > 5) {
    throw Error("a scan with reflectivities has 1 ... 5 ranges of beams, not " +
                std::to_string(beams.size()));
  }
  const auto count = static_cast<unsigned>(beams.size());
  put_16(data, count);
  for (const Subrange& b : beams) put_beams(data, b);
}

Telegram with_beams(Command code, std::vector<std::uint8_t> data, const Subrange& beams) {
  put_beams(data, beams);
  return command(code, std::move(data));
}

}  // namespace

Telegram ask(Command code) { return command(code, {}); }
Telegram ask_mode(Mode mode) { return command(Command::mode, mode_byte(mode)); }
Telegram ask_installation(std::string_view password) {
  return with_password(Mode::installation, password);
}
Telegram ask_test_password(std::string_view password) {
  return with_password(Mode::test_password, password);
}

Telegram ask_baud(int baud) {
  switch (baud) {
    case 9600:
      return ask_mode(Mode::baud_9600);
    case 19200:
      return ask_mode(Mode::baud_19200);
    case 38400:
      return ask_mode(Mode::baud_38400);
    case 500000:
      return ask_mode(Mode::baud_500000);
  }
  throw Error("an LMS-2xx has no " + std::to_string(baud) +
              " baud: choose 9600, 19200, 38400 or 500000");
}

Telegram ask_mean_stream(int scans) {
  return command(Command::mode,
                 {static_cast<std::uint8_t>(Mode::continuous_mean), scans_of(scans)});
}
Telegram ask_subrange_stream(const Subrange& beams) {
  return with_beams(Command::mode, mode_byte(Mode::continuous_subrange), beams);
}
Telegram ask_mean_subrange_stream(int scans, const Subrange& beams) {
  auto data = mode_byte(Mode::continuous_mean_subrange);
  data.push_back(scans_of(scans));
  return with_beams(Command::mode, std::move(data), beams);
}
Telegram ask_fields_stream(const Subrange& beams) {
  return with_beams(Command::mode, mode_byte(Mode::continuous_fields), beams);
}
Telegram ask_reflectivity_stream(std::span<const Subrange> beams) {
  auto data = mode_byte(Mode::continuous_reflectivity);
  put_list(data, beams);
  return command(Command::mode, std::move(data));
}

Telegram ask_scan(ScanKind kind) {
  return command(Command::scan, {static_cast<std::uint8_t>(kind)});
}
Telegram ask_mean_scan(int scans) { return command(Command::mean_scan, {scans_of(scans)}); }
Telegram ask_subrange_scan(const Subrange& beams) {
  return with_beams(Command::subrange_scan, {}, beams);
}
Telegram ask_fields_scan(const Subrange& beams) {
  return with_beams(Command::fields_scan, {}, beams);
}
Telegram ask_mean_subrange_scan(int scans, const Subrange& beams) {
  return with_beams(Command::mean_subrange_scan, {scans_of(scans)}, beams);
}
Telegram ask_active_fields(std::uint8_t set) { return command(Command::active_fields, {set}); }
Telegram ask_s14_scan(const Subrange& reflectivities) {
  return with_beams(Command::s14_scan, {}, reflectivities);
}
Telegram ask_reflectivity_scan(std::span<const Subrange> beams) {
  std::vector<std::uint8_t> data;
  put_list(data, beams);
  return command(Command::reflectivity_scan, std::move(data));
}
Telegram ask_cartesian_scan(const Subrange& beams) {
  return with_beams(Command::cartesian_scan, {}, beams);
}

Telegram ask_variant(const Variant& variant) {
  std::vector<std::uint8_t> data;
  put_16(data, static_cast<unsigned>(variant.field_of_view));
  put_16(data, static_cast<unsigned>(variant.resolution));
  return command(Command::variant, std::move(data));
}
Telegram ask_write_configuration(const LmsConfiguration& configuration) {
  if (!LmsConfiguration::is_size(configuration.raw.size())) {
    throw Error("a configuration of " + std::to_string(configuration.raw.size()) +
                " bytes: the device's own block has 34 or 32; read it first");
  }
  return command(Command::write_configuration, configuration.raw);
}
Telegram ask_write_configuration_2(std::span<const std::uint8_t> raw) {
  if (raw.size() != kConfiguration2Size) {
    throw Error("a second configuration of " + std::to_string(raw.size()) + " bytes: it has 84");
  }
  return command(Command::write_configuration_2, {raw.begin(), raw.end()});
}
Telegram ask_power_on(std::uint8_t rule) { return command(Command::power_on, {rule}); }

// ---- The device's side. ------------------------------------------------------------------------

std::optional<Mode> decode_mode(const Telegram& telegram) {
  if (!telegram.is(Command::mode) || telegram.data.empty()) return {};
  return static_cast<Mode>(telegram.data[0]);
}

std::optional<std::string> decode_password(const Telegram& telegram) {
  if (!telegram.is(Command::mode) || telegram.data.size() != 1 + kPasswordLength) return {};
  return std::string(telegram.data.begin() + 1, telegram.data.end());
}

std::optional<int> decode_baud(const Telegram& telegram) {
  const auto mode = decode_mode(telegram);
  if (!mode || telegram.data.size() != 1) return {};
  switch (*mode) {
    case Mode::baud_9600:
      return 9600;
    case Mode::baud_19200:
      return 19200;
    case Mode::baud_38400:
      return 38400;
    case Mode::baud_500000:
      return 500000;
    default:
      return {};
  }
}

std::optional<Variant> decode_variant(const Telegram& telegram) {
  if (!telegram.is(Command::variant) || telegram.data.size() != 4) return {};
  return Variant{get_16(telegram.data, 0), get_16(telegram.data, 2)};
}

std::optional<LmsConfiguration> decode_write_configuration(const Telegram& telegram) {
  if (!telegram.is(Command::write_configuration)) return {};
  if (!LmsConfiguration::is_size(telegram.data.size())) return {};
  return LmsConfiguration{telegram.data};
}

namespace {

/// What follows the code, or the mode's byte: a number of scans, ranges of beams, or both.
struct RequestLayout {
  bool mean = false, beams = false, list = false;
};

std::optional<RequestLayout> layout_of(const Telegram& telegram) {
  if (telegram.is(Command::mode)) {
    switch (decode_mode(telegram).value_or(Mode::on_request)) {
      case Mode::continuous_mean:
        return RequestLayout{true, false, false};
      case Mode::continuous_subrange:
      case Mode::continuous_fields:
        return RequestLayout{false, true, false};
      case Mode::continuous_mean_subrange:
        return RequestLayout{true, true, false};
      case Mode::continuous_reflectivity:
        return RequestLayout{false, false, true};
      default:
        return {};
    }
  }
  switch (static_cast<Command>(telegram.code)) {
    case Command::mean_scan:
      return RequestLayout{true, false, false};
    case Command::subrange_scan:
    case Command::fields_scan:
    case Command::s14_scan:
    case Command::cartesian_scan:
      return RequestLayout{false, true, false};
    case Command::mean_subrange_scan:
      return RequestLayout{true, true, false};
    case Command::reflectivity_scan:
      return RequestLayout{false, false, true};
    default:
      return {};
  }
}

std::optional<Subrange> beams_at(std::span<const std::uint8_t> data, std::size_t i) {
  const std::uint16_t last = get_16(data, i + 2);
  const Subrange beams{get_16(data, i), static_cast<std::uint16_t>(last & 0x7FFF),
                       (last & 0x8000) != 0};
  if (beams.first < 1 || beams.last < beams.first || beams.last > kMostBeams) return {};
  return beams;
}

}  // namespace

std::optional<ScanRequest> decode_scan_request(const Telegram& telegram) {
  const auto layout = layout_of(telegram);
  if (!layout) return {};
  std::span<const std::uint8_t> data(telegram.data);
  if (telegram.is(Command::mode)) data = data.subspan(1);
  ScanRequest request;
  if (layout->mean) {
    if (data.empty() || data[0] < 2 || data[0] > 250) return {};
    request.mean_of = data[0];
    data = data.subspan(1);
  }
  std::size_t ranges = layout->beams ? 1 : 0;
  if (layout->list) {
    if (data.size() < 2) return {};
    ranges = get_16(data, 0);
    if (ranges < 1 || ranges > 5) return {};
    data = data.subspan(2);
  }
  if (data.size() != 4 * ranges) return {};
  for (std::size_t i = 0; i < ranges; ++i) {
    const auto beams = beams_at(data, 4 * i);
    if (!beams) return {};
    request.beams.push_back(*beams);
  }
  return request;
}

}  // namespace majak::sensor
