// SPDX-License-Identifier: Apache-2.0
// Telegrams of measured values, to and fro.
#include <string>

#include "majak/core/error.hpp"
#include "majak/sensor/lms_scan.hpp"
#include "majak/sensor/telegram_bytes.hpp"

namespace majak::sensor {

namespace {

constexpr unsigned kCountMask = 0x03FF, kWideCountMask = 0x3FFF, kPartialBit = 0x2000;
constexpr std::size_t kMostValues = 511;

/// Reads on until something is missing; then everything else is missing, too.
class Cursor {
 public:
  explicit Cursor(std::span<const std::uint8_t> data) : data_(data) {}

  unsigned byte() {
    if (!has(1)) return 0;
    return data_[at_++];
  }
  unsigned word() {
    if (!has(2)) return 0;
    at_ += 2;
    return get_16(data_, at_ - 2);
  }
  bool has(std::size_t n) { return good_ = good_ && left() >= n; }
  std::size_t left() const { return data_.size() - at_; }
  bool good() const { return good_; }

 private:
  std::span<const std::uint8_t> data_;
  std::size_t at_ = 0;
  bool good_ = true;
};

/// What stands between the code and the values.
struct Layout {
  bool mean, beams, partial;  // a number of scans; first and last beam; count with partial bits
};

std::optional<Layout> layout_of(std::uint8_t code) {
  switch (static_cast<Reply>(code)) {
    case Reply::scan:
      return Layout{false, false, true};
    case Reply::mean_scan:
      return Layout{true, false, false};
    case Reply::subrange_scan:
      return Layout{false, true, true};
    case Reply::mean_subrange_scan:
      return Layout{true, true, false};
    case Reply::fields_scan:
    case Reply::reflectivity_scan:
      return Layout{false, true, false};
    case Reply::s14_scan:
      return Layout{false, false, true};
    default:
      return {};
  }
}

Subrange read_beams(Cursor& in) {
  Subrange beams;
  beams.first = static_cast<std::uint16_t>(in.word());
  const unsigned last = in.word();
  beams.last = static_cast<std::uint16_t>(last & 0x7FFF);
  beams.direct = (last & 0x8000) != 0;
  return beams;
}

/// Count, unit and number of the partial scan, then as many values.
bool read_values(Cursor& in, const Layout& layout, LmsScan& scan) {
  if (layout.beams) scan.beams.push_back(read_beams(in));
  const unsigned info = in.word();
  const std::size_t count = info & (layout.partial ? kCountMask : kWideCountMask);
  scan.unit = static_cast<Unit>(info >> 14);
  if (layout.partial) {
    scan.partial = (info & kPartialBit) != 0;
    scan.quarter = static_cast<int>(info >> 11 & 3);
  }
  if (!in.good() || count < 1 || count > kMostValues) return false;
  if (layout.beams) {
    const Subrange& beams = scan.beams.back();
    if (beams.first < 1 || beams.size() != static_cast<int>(count)) return false;
  }
  for (std::size_t i = 0; i < count && in.good(); ++i) {
    scan.values.push_back(static_cast<std::uint16_t>(in.word()));
    if (scan.code == Reply::reflectivity_scan) {
      scan.reflectivities.push_back(static_cast<std::uint16_t>(in.word()));
    }
    if (scan.code == Reply::fields_scan) {
      auto& fields = scan.fields.emplace_back();
      for (std::uint16_t& f : fields) f = static_cast<std::uint16_t>(in.word());
    }
  }
  return in.good();
}

bool read_s14_reflectivities(Cursor& in, LmsScan& scan) {
  const std::size_t count = in.word();
  scan.reflectivity_beams = read_beams(in);
  if (!in.good() || scan.reflectivity_beams.first < 1 ||
      scan.reflectivity_beams.size() != static_cast<int>(count) || !in.has(count)) {
    return false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    scan.reflectivities.push_back(static_cast<std::uint16_t>(in.byte()));
  }
  return true;
}

}  // namespace

std::optional<LmsScan> decode_scan(const Telegram& telegram) {
  const auto layout = layout_of(telegram.code);
  if (!layout || !telegram.status) return {};
  LmsScan scan;
  scan.code = static_cast<Reply>(telegram.code);
  scan.status = *telegram.status;
  Cursor in(telegram.data);
  if (layout->mean) scan.mean_of = static_cast<int>(in.byte());
  const bool list = scan.code == Reply::reflectivity_scan;
  const unsigned blocks = list ? in.word() : 1;
  if (!in.good() || scan.mean_of < 1 || blocks < 1 || blocks > 5) return {};
  for (unsigned i = 0; i < blocks; ++i) {
    if (!read_values(in, *layout, scan)) return {};
  }
  if (scan.code == Reply::s14_scan && !read_s14_reflectivities(in, scan)) return {};
  if (in.left() == 2) {
    scan.scan_index = static_cast<std::uint8_t>(in.byte());
    scan.telegram_index = static_cast<std::uint8_t>(in.byte());
  }
  if (in.left() != 0) return {};
  return scan;
}

namespace {

void check(bool right, const char* what) {
  if (!right) throw Error(std::string("a telegram of measured values cannot be made: ") + what);
}

void put_beam_range(std::vector<std::uint8_t>& data, const Subrange& beams) {
  put_16(data, beams.first);
  put_16(data, beams.last | (beams.direct ? 0x8000u : 0u));
}

void put_values(std::vector<std::uint8_t>& data, const Layout& layout, const LmsScan& scan,
                std::size_t first, std::size_t count) {
  check(count >= 1 && count <= kMostValues, "it has 1 ... 511 values");
  auto info = static_cast<unsigned>(count) | static_cast<unsigned>(scan.unit) << 14;
  if (layout.partial) {
    info |= (scan.partial ? kPartialBit : 0u) | static_cast<unsigned>(scan.quarter & 3) << 11;
  }
  put_16(data, info);
  for (std::size_t i = first; i < first + count; ++i) {
    put_16(data, scan.values[i]);
    if (scan.code == Reply::reflectivity_scan) put_16(data, scan.reflectivities[i]);
    if (scan.code == Reply::fields_scan) {
      for (const std::uint16_t f : scan.fields[i]) put_16(data, f);
    }
  }
}

void put_s14_reflectivities(std::vector<std::uint8_t>& data, const LmsScan& scan) {
  const std::size_t count = scan.reflectivities.size();
  check(scan.reflectivity_beams.size() == static_cast<int>(count), "count of reflectivities");
  put_16(data, static_cast<unsigned>(count));
  put_beam_range(data, scan.reflectivity_beams);
  for (const std::uint16_t r : scan.reflectivities) data.push_back(static_cast<std::uint8_t>(r));
}

}  // namespace

Telegram tell_scan(const LmsScan& scan, std::uint8_t address) {
  Telegram telegram;
  telegram.address = address | kDeviceBit;
  telegram.code = static_cast<std::uint8_t>(scan.code);
  telegram.status = scan.status;
  const auto layout = layout_of(telegram.code);
  check(layout.has_value(), "its code is none of theirs");
  const bool list = scan.code == Reply::reflectivity_scan;
  check(!list || scan.reflectivities.size() == scan.values.size(), "a reflectivity a value");
  check(scan.code != Reply::fields_scan || scan.fields.size() == scan.values.size(),
        "fields A, B, C of each value");
  std::vector<std::uint8_t>& data = telegram.data;
  if (layout->mean) data.push_back(static_cast<std::uint8_t>(scan.mean_of));
  if (list) put_16(data, static_cast<unsigned>(scan.beams.size()));
  std::size_t first = 0;
  if (layout->beams) {
    for (const Subrange& beams : scan.beams) {
      const auto count = static_cast<std::size_t>(beams.size());
      check(first + count <= scan.values.size(), "fewer values than beams");
      put_beam_range(data, beams);
      put_values(data, *layout, scan, first, count);
      first += count;
    }
  } else {
    first = scan.values.size();
    put_values(data, *layout, scan, 0, first);
  }
  check(first == scan.values.size(), "more values than beams");
  if (scan.code == Reply::s14_scan) put_s14_reflectivities(data, scan);
  if (scan.scan_index && scan.telegram_index) {
    data.push_back(*scan.scan_index);
    data.push_back(*scan.telegram_index);
  }
  return telegram;
}

}  // namespace majak::sensor
