// SPDX-License-Identifier: Apache-2.0
// What the emulated device measures and sends.
#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/sensor/lms_emulator.hpp"
#include "majak/sensor/telegram_bytes.hpp"

namespace majak::sensor {

namespace {

constexpr std::uint16_t kReflectivity = 9000;  // of everything
constexpr std::uint16_t kS14Reflectivity = 120;
constexpr double kMostInvalid = 0.2;  // share of the samples of a mean

/// An answer to a request has the request's beams; a whole scan has none.
bool has_beams(Reply code) { return code != Reply::scan && code != Reply::mean_scan; }

}  // namespace

// A scan ends when all its turns have ended.
bool LmsEmulator::begins_with(const Wish& wish, std::int64_t turn) const {
  const std::int64_t one = wish.one_turn ? 1 : variant_.turns();
  const std::int64_t all = one * wish.request.mean_of;
  return turn >= wish.turn && turn % (wish.stream ? all : one) == 0 && turn - all >= ready_turn_;
}

void LmsEmulator::send_scan(const Wish& wish, Time now) {
  ++counts_.scans;
  LmsScan scan = measure(wish, now);
  if (faults_.dazzle > 0 && random_.uniform() < faults_.dazzle) dazzle(scan);
  mouth_.send({damage(std::move(scan)), now});
}

std::vector<double> LmsEmulator::ranges(const Wish& wish, Time now) const {
  const Duration turn = options_.mirror_turn;
  if (wish.one_turn) {
    // Beams of a scan that this turn is one part of.
    const Variant shape{180, variant_.resolution};
    const auto part = static_cast<std::size_t>((turn_ - 1) % shape.turns());
    const auto all = source_(now - static_cast<Duration>(part + 1) * turn, shape);
    std::vector<double> out;
    for (std::size_t i = part; i < all.size(); i += static_cast<std::size_t>(shape.turns())) {
      out.push_back(all[i]);
    }
    return out;
  }
  const int scans = wish.request.mean_of;
  const auto beams = static_cast<std::size_t>(variant_.beams());
  std::vector<double> sum(beams);
  std::vector<int> valid(beams);
  for (int s = scans; s > 0; --s) {
    auto one = source_(now - s * variant_.turns() * turn, variant_);
    if (scans == 1) return one;
    for (std::size_t i = 0; i < std::min(beams, one.size()); ++i) {
      if (!std::isfinite(one[i])) continue;
      sum[i] += one[i];
      ++valid[i];
    }
  }
  for (std::size_t i = 0; i < beams; ++i) {
    const bool enough = valid[i] >= (1 - kMostInvalid) * scans;
    sum[i] = enough ? sum[i] / valid[i] : std::numeric_limits<double>::infinity();
  }
  return sum;
}

LmsScan LmsEmulator::measure(const Wish& wish, Time now) {
  const LmsConfiguration& configuration = options_.configuration;
  std::vector<std::uint16_t> values;
  for (const double range : ranges(wish, now)) {
    values.push_back(encode_value(range, configuration.unit(), configuration.measuring_mode()));
  }
  const int part = static_cast<int>((turn_ - 1) % variant_.turns());
  LmsScan scan;
  scan.code = wish.code;
  scan.unit = configuration.unit();
  scan.partial = wish.one_turn;
  scan.quarter = wish.one_turn ? part * 4 / variant_.turns() : 0;
  scan.mean_of = wish.request.mean_of;
  scan.status = sender().status;
  values.resize(static_cast<std::size_t>(!wish.one_turn ? variant_.beams()
                                         : part == 0    ? 181
                                                        : 180),
                encode_value(std::numeric_limits<double>::infinity(), scan.unit,
                             configuration.measuring_mode()));
  if (wish.code == Reply::s14_scan) {
    scan.values = values;
    scan.reflectivity_beams = wish.request.beams.at(0);
    scan.reflectivities.assign(static_cast<std::size_t>(scan.reflectivity_beams.size()),
                               kS14Reflectivity);
  } else if (has_beams(wish.code)) {
    scan.beams = wish.request.beams;
    for (const Subrange& b : scan.beams) {
      scan.values.insert(scan.values.end(), values.begin() + (b.first - 1),
                         values.begin() + b.last);
    }
  } else {
    scan.values = values;
  }
  if (wish.code == Reply::fields_scan) scan.fields.resize(scan.values.size());
  if (wish.code == Reply::reflectivity_scan) {
    scan.reflectivities.assign(scan.values.size(), kReflectivity);
  }
  if (configuration.real_time_indices()) {
    scan.scan_index = static_cast<std::uint8_t>(turn_ & 0xFF);
    scan.telegram_index = telegrams_;
  }
  ++telegrams_;
  return scan;
}

void LmsEmulator::dazzle(LmsScan& scan) {
  const auto layout = value_layout(options_.configuration.measuring_mode());
  if (!layout) return;
  unsigned code = layout->first_code() + static_cast<unsigned>(ValueCode::dazzled);
  if (layout->dazzle) code |= 0x8000u;
  const std::size_t first = random_.below(scan.values.size());
  const std::size_t end = std::min<std::size_t>(scan.values.size(), first + 5 + random_.below(30));
  for (std::size_t i = first; i < end; ++i) scan.values[i] = static_cast<std::uint16_t>(code);
}

// From here on the telegram is bytes, and what is wrong with it has nothing to do with the scan.
std::vector<std::uint8_t> LmsEmulator::damage(LmsScan scan) {
  const auto happens = [&](double rate) { return rate > 0 && random_.uniform() < rate; };
  if (happens(faults_.odd_count) && scan.code == Reply::scan) scan.values.pop_back();
  std::vector<std::uint8_t> frame =
      encode(tell_scan(scan, static_cast<std::uint8_t>(kDeviceBit | options_.address)));
  if (happens(faults_.wrong_length)) {
    set_16(frame, 2, get_16(frame, 2) + 1 + static_cast<unsigned>(random_.below(50)));
    const std::size_t end = frame.size() - 2;
    set_16(frame, end, telegram_crc(std::span(frame).first(end)));
  }
  if (happens(faults_.truncate)) frame.resize(1 + random_.below(frame.size() - 1));
  std::vector<std::uint8_t> before;
  if (happens(faults_.noise)) before = noise();
  if (happens(faults_.handshakes)) before.push_back(random_.below(2) == 0 ? kAck : kNak);
  frame.insert(frame.begin(), before.begin(), before.end());
  return frame;
}

std::vector<std::uint8_t> LmsEmulator::noise() {
  std::vector<std::uint8_t> bytes;
  for (std::uint64_t n = random_.below(20); n > 0; --n) {
    bytes.push_back(static_cast<std::uint8_t>(random_.below(256)));
  }
  const auto length = static_cast<unsigned>(2 + random_.below(800));
  bytes.insert(bytes.end(), {kStx, static_cast<std::uint8_t>(kDeviceBit | options_.address)});
  put_16(bytes, length);
  bytes.push_back(static_cast<std::uint8_t>(Reply::scan));
  return bytes;
}

}  // namespace majak::sensor
