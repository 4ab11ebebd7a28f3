// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms_scan.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "majak/core/error.hpp"

namespace majak::sensor {

LmsHealth health_of(std::uint8_t status) {
  LmsHealth health;
  health.severity = static_cast<LmsHealth::Severity>(status & 7);
  health.restart = (status & 0x20) != 0;
  health.implausible = (status & 0x40) != 0;
  health.pollution = (status & 0x80) != 0;
  return health;
}

std::optional<ValueLayout> value_layout(int measuring_mode) {
  switch (measuring_mode) {
    case 0x00:
      return ValueLayout{13, 2, 0, true};
    case 0x01:
      return ValueLayout{13, 0, 3, false};
    case 0x02:
      return ValueLayout{13, 3, 0, false};
    case 0x03:
      return ValueLayout{14, 0, 2, false};
    case 0x04:
      return ValueLayout{14, 2, 0, false};
    case 0x05:
      return ValueLayout{15, 0, 1, false};
    case 0x06:
      return ValueLayout{15, 1, 0, false};
    case 0x0D:  // with reflectivities; no flags
    case 0x0E:
      return ValueLayout{13, 0, 0, false};
    case 0x0F:
      return ValueLayout{15, 0, 0, false};
    default:
      return {};
  }
}

namespace {

std::string hex_byte(int value) {
  const char* digits = "0123456789ABCDEF";
  return {digits[value >> 4 & 15], digits[value & 15]};
}

/// No echo is what a free beam gives. An echo too weak to be measured is not free.
float range_of_code(unsigned offset) {
  const auto code = static_cast<ValueCode>(offset);
  return code == ValueCode::no_echo || code == ValueCode::too_far ? kNoReturn : kInvalidRange;
}

}  // namespace

LmsValues decode_values(const LmsScan& scan, int measuring_mode) {
  const auto layout = value_layout(measuring_mode);
  if (!layout) {
    throw Error("the device is in measuring mode " + hex_byte(measuring_mode) +
                ", whose values are no distances: set 00 ... 06");
  }
  const double step = metres(scan.unit);
  if (step <= 0) throw Error("the device sends values in an unknown unit");
  const unsigned mask = (1u << layout->distance_bits) - 1, first_code = layout->first_code();
  const unsigned field_mask = (1u << layout->fields) - 1;
  const unsigned reflector_mask = (1u << layout->reflector) - 1;
  LmsValues out;
  out.max_range = static_cast<float>(first_code * step);
  for (const unsigned value : scan.values) {
    const unsigned distance = value & mask, above = value >> layout->distance_bits;
    unsigned flags = above & field_mask;
    const bool dazzled = layout->dazzle && (value & 0x8000u) != 0;
    const bool code = distance >= first_code;
    if (dazzled || (code && distance - first_code == static_cast<unsigned>(ValueCode::dazzled))) {
      flags |= LmsValues::kDazzled;
    }
    float range = static_cast<float>(distance * step);
    if (code) range = range_of_code(distance - first_code);
    if (distance == 0 || (flags & LmsValues::kDazzled) != 0) range = kInvalidRange;
    out.ranges.push_back(range);
    out.flags.push_back(static_cast<std::uint8_t>(flags));
    out.reflector.push_back(static_cast<std::uint8_t>(above >> layout->fields & reflector_mask));
  }
  return out;
}

std::uint16_t encode_value(double range, Unit unit, int measuring_mode) {
  const auto layout = value_layout(measuring_mode);
  if (!layout) return 0;
  const unsigned first_code = layout->first_code();
  const auto code = [&](ValueCode c) {
    return static_cast<std::uint16_t>(first_code + static_cast<unsigned>(c));
  };
  if (std::isnan(range)) return code(ValueCode::too_weak);
  if (std::isinf(range)) return code(ValueCode::no_echo);
  const double steps = std::max(1.0, std::round(range / metres(unit)));
  return steps < first_code ? static_cast<std::uint16_t>(steps) : code(ValueCode::too_far);
}

namespace {

/// One turn of the mirror: a value a degree, whatever the variant.
bool one_turn(const LmsScan& scan) { return scan.partial && scan.beams.empty(); }

/// The turns between whole degrees have one beam fewer.
int partial_beams(int quarter) { return quarter == 0 ? 181 : 180; }

/// Each value to its beam; the others are not known.
std::vector<float> spread(const std::vector<float>& values, const std::vector<Subrange>& beams,
                          int count) {
  std::vector<float> all(static_cast<std::size_t>(count), kInvalidRange);
  auto value = values.begin();
  for (const Subrange& b : beams) {
    for (int beam = b.first; beam <= b.last; ++beam) {
      all[static_cast<std::size_t>(beam - 1)] = *value++;
    }
  }
  return all;
}

}  // namespace

bool fits(const LmsScan& scan, const Variant& variant) {
  const int count = static_cast<int>(scan.values.size());
  if (one_turn(scan)) return count == partial_beams(scan.quarter);
  if (scan.beams.empty()) return count == variant.beams();
  int sum = 0;
  for (const Subrange& beams : scan.beams) {
    if (beams.first < 1 || beams.last < beams.first || beams.last > variant.beams()) return false;
    sum += beams.size();
  }
  return sum == count;
}

int turns(const LmsScan& scan, const Variant& variant) {
  return scan.mean_of * (one_turn(scan) ? 1 : variant.turns());
}

Scan to_scan(const LmsScan& lms, const LmsConfiguration& configuration, const Variant& variant,
             Time first_byte) {
  if (!fits(lms, variant)) {
    throw Error("a scan of " + std::to_string(lms.values.size()) +
                " values does not fit a device that is set to " + std::to_string(variant.beams()));
  }
  const LmsValues values = decode_values(lms, configuration.measuring_mode());
  const Variant shape = one_turn(lms) ? Variant{180, 100} : variant;
  const int quarter = one_turn(lms) ? lms.quarter : 0;
  Scan scan;
  scan.time = first_byte - turns(lms, variant) * kMirrorTurn + quarter * kMirrorTurn / (4 * 360);
  scan.start_angle = shape.start_angle() + radians(quarter * 0.25);
  scan.angle_step = shape.angle_step();
  scan.max_range = values.max_range;
  const std::vector<float> reflected(lms.reflectivities.begin(), lms.reflectivities.end());
  const bool all = lms.beams.empty();
  scan.ranges = all ? values.ranges : spread(values.ranges, lms.beams, variant.beams());
  if (lms.code == Reply::reflectivity_scan) {
    scan.intensities = spread(reflected, lms.beams, variant.beams());
  } else if (lms.code == Reply::s14_scan && lms.reflectivity_beams.last <= variant.beams()) {
    scan.intensities = spread(reflected, {lms.reflectivity_beams}, variant.beams());
  }
  return scan;
}

}  // namespace majak::sensor
