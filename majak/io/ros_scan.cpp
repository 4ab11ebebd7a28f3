// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace majak::io {

namespace {

constexpr float kAssumedRange = 100.0F;  // m, where a message states no limit

const char* const kNoBeams = "scans without beams; left out";
const char* const kNoAngles = "scans whose angles are no numbers; left out";
const char* const kIncrement =
    "scans whose angle_increment disagrees with angle_min, angle_max and the number of beams; the "
    "increment is believed (--angle-step DEGREES overrides it)";
const char* const kNoIncrement =
    "scans without an angle_increment; taken from angle_min and angle_max (--angle-step DEGREES "
    "overrides it)";
const char* const kSpread180 =
    "scans of 180 beams that are said to end at +90 degrees; a SICK's beams are 1 degree apart and "
    "end at +89: --angle-step 1 corrects it if this is one";
const char* const kSpread360 =
    "scans of 360 beams that are said to end at +90 degrees; a SICK's beams are 0.5 degrees apart "
    "and end at +89.5: --angle-step 0.5 corrects it if this is one";
const char* const kNoLimit = "scans without a range_max; 100 m assumed";
const char* const kTilted = "scans of a laser that is tilted; taken as level";
const char* const kIntensities = "scans with another number of intensities than ranges; left out";

/// Messages have 32 bits for an angle. Where one is a whole ten-thousandth of a degree but for its
/// rounding, that is what was meant.
double meant_angle(float stated) {
  const double rounded = std::round(degrees(static_cast<double>(stated)) * 1e4) / 1e4;
  const double quarters = rounded / 90.0;
  const double angle = quarters == std::round(quarters) ? quarters * (kPi / 2) : radians(rounded);
  return static_cast<float>(angle) == stated ? angle : static_cast<double>(stated);
}

/// The angle between neighbouring beams, with what is odd about it.
double step_of(const ros::LaserScan& m, std::int64_t record, Report& report) {
  const auto beams = static_cast<double>(m.ranges.size());
  const double span = static_cast<double>(m.angle_max) - static_cast<double>(m.angle_min);
  const double stated = m.angle_increment;
  if (!std::isfinite(stated) || stated == 0) {
    report.count(kNoIncrement, record);
    return beams > 1 ? span / (beams - 1) : 0;
  }
  // Off by one beam at the end already blurs a map.
  const bool agrees =
      !std::isfinite(span) || std::abs(span - stated * (beams - 1)) < 0.5 * std::abs(stated);
  if (!agrees) report.count(kIncrement, record);
  const bool half_circle = agrees && std::abs(std::abs(span) - kPi) < 0.1 * std::abs(stated);
  if (half_circle && beams == 180) report.count(kSpread180, record);
  if (half_circle && beams == 360) report.count(kSpread360, record);
  return meant_angle(m.angle_increment);
}

void read_ranges(const ros::LaserScan& m, Scan& scan) {
  const bool sound = m.range_min > 0 && m.range_min < scan.max_range;
  const float least = sound ? m.range_min : 0.0F;
  scan.ranges.reserve(m.ranges.size());
  for (const float range : m.ranges) {
    const bool known = range > 0 && range >= least;  // neither of them for not-a-numbers
    scan.ranges.push_back(!known ? kInvalidRange : range >= scan.max_range ? kNoReturn : range);
  }
}

/// The same beams from the other end.
void reverse(Scan& scan) {
  scan.start_angle += scan.angle_step * static_cast<double>(scan.ranges.size() - 1);
  scan.angle_step = -scan.angle_step;
  std::reverse(scan.ranges.begin(), scan.ranges.end());
  std::reverse(scan.intensities.begin(), scan.intensities.end());
}

}  // namespace

std::optional<Scan> scan_of(const ros::LaserScan& m, const Mounting& mounting,
                            const RosScanOptions& options, std::int64_t record, Report& report) {
  if (m.ranges.empty()) {
    report.count(kNoBeams, record);
    return std::nullopt;
  }
  Scan scan;
  scan.time = m.header.stamp;
  scan.start_angle = meant_angle(m.angle_min);
  const bool clockwise = m.angle_increment < 0;
  if (options.angle_step) {
    scan.angle_step = clockwise ? -*options.angle_step : *options.angle_step;
  } else {
    scan.angle_step = step_of(m, record, report);
  }
  if (!std::isfinite(scan.start_angle) || !std::isfinite(scan.angle_step)) {
    report.count(kNoAngles, record);
    return std::nullopt;
  }
  scan.max_range = m.range_max;
  if (!(m.range_max > 0) || !std::isfinite(m.range_max)) {
    report.count(kNoLimit, record);
    scan.max_range = kAssumedRange;
  }
  if (options.code) scan.max_range = std::min(scan.max_range, *options.code - 0.005F);
  read_ranges(m, scan);
  if (m.intensities.size() == m.ranges.size()) {
    scan.intensities = m.intensities;
  } else if (!m.intensities.empty()) {
    report.count(kIntensities, record);
  }
  scan.T_robot_laser = mounting.T_robot_laser;
  if (mounting.tilted) report.count(kTilted, record);
  if (mounting.upside_down) {  // left and right change places
    scan.start_angle = -scan.start_angle;
    scan.angle_step = -scan.angle_step;
  }
  if (scan.angle_step < 0) reverse(scan);
  return scan;
}

ros::LaserScan message_of(const Scan& scan, std::string frame) {
  ros::LaserScan m;
  m.header.stamp = scan.time;
  m.header.frame = std::move(frame);
  const std::size_t last = scan.ranges.empty() ? 0 : scan.ranges.size() - 1;
  m.angle_min = static_cast<float>(scan.start_angle);
  m.angle_max = static_cast<float>(scan.angle(last));
  m.angle_increment = static_cast<float>(scan.angle_step);
  m.range_max = scan.max_range;
  m.ranges = scan.ranges;
  m.intensities = scan.intensities;
  return m;
}

}  // namespace majak::io
