// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/drive_log.hpp"

#include <algorithm>
#include <optional>

#include "majak/core/error.hpp"

namespace majak::motion {
namespace {

constexpr std::size_t kLeastRecords = 100;
constexpr float kLeastScore = 0.5;  // share of beams that fit the map

/// A step that was left out fits as badly as the worst that was not.
double fit_of(const Calibration& c) {
  return (c.log_likelihood - 9.0 * static_cast<double>(c.left_out)) / static_cast<double>(c.steps);
}

}  // namespace

const char* name_of(WheelSource source) {
  switch (source) {
    case WheelSource::stream:
      return "odometry records";
    case WheelSource::records:
      return "odometry in the scans' records";
    case WheelSource::ordered:
      return "odometry in the scans' records, in order only";
    case WheelSource::wheels:
      return "speed and steering";
  }
  return "";
}

void DriveLog::add(const Event& event) {
  if (const auto* odometry = std::get_if<Odometry>(&event)) stream.push_back(*odometry);
  if (const auto* motion = std::get_if<WheelMotion>(&event)) wheels.push_back(*motion);
  const auto* scan = std::get_if<Scan>(&event);
  if (scan == nullptr || scan->laser != 0) return;
  Odometry record{scan->time, scan->T_odom_robot.value_or(Pose2{}), {}, {}};
  if (!stream.empty()) record.speed = stream.back().speed;  // as last stated
  records.push_back(record);
  all_scans_have_records = all_scans_have_records && scan->T_odom_robot;
}

std::vector<Time> scan_times(const Site& site, WheelSource source) {
  std::vector<Time> out;
  for (std::size_t i = 0; i < site.scans.size(); ++i)
    out.push_back(source == WheelSource::ordered ? static_cast<Time>(i) * kSecond
                                                 : site.scans[i].scan.time);
  return out;
}

std::vector<LaserPose> laser_poses(const Site& site, WheelSource source, std::size_t first,
                                   std::size_t last) {
  const std::vector<Time> times = scan_times(site, source);
  std::vector<LaserPose> out;
  for (std::size_t i = first; i < std::min(last, site.scans.size()); ++i) {
    const PosedScan& s = site.scans[i];
    if (s.estimate.health != Health::ok || s.match_score < kLeastScore) continue;
    out.push_back({times[i], s.estimate.T_map_robot});
  }
  return out;
}

std::vector<WheelSample> samples_of(const DriveLog& log, WheelSource source, bool reversed,
                                    double wheelbase) {
  if (source == WheelSource::wheels) return wheel_samples(log.wheels, wheelbase);
  auto samples = wheel_samples(source == WheelSource::stream ? log.stream : log.records, reversed);
  if (source == WheelSource::ordered)
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i].time = static_cast<Time>(i) * kSecond;
  return samples;
}

LogCalibration calibrate_log(const DriveLog& log, const Site& site,
                             const LogCalibrationOptions& options) {
  if (site.scans.empty()) throw Error("a calibration needs scans");
  const bool reversed = site.odometry.reversed_records > 0;
  std::vector<WheelSource> sources;
  if (options.wheelbase > 0 && log.wheels.size() >= kLeastRecords) {
    sources = {WheelSource::wheels};
  } else {
    if (log.stream.size() >= kLeastRecords) sources.push_back(WheelSource::stream);
    if (log.all_scans_have_records && log.records.size() >= kLeastRecords)
      sources.insert(sources.end(), {WheelSource::records, WheelSource::ordered});
  }
  if (sources.empty())
    throw Error(log.wheels.size() >= kLeastRecords
                    ? "this log holds speed and steering: tell the wheelbase"
                    : "no odometry to calibrate");
  std::optional<LogCalibration> best;
  for (const WheelSource source : sources) {
    CalibrationOptions o;
    o.track = options.track;
    o.wheelbase = source == WheelSource::wheels ? options.wheelbase : 0;
    o.timed = source != WheelSource::ordered;
    o.start_lag = site.odometry.lag_s.value;
    o.T_robot_laser = site.scans.front().scan.T_robot_laser;
    LogCalibration found{calibrate(laser_poses(site, source, options.first, options.last),
                                   samples_of(log, source, reversed, options.wheelbase), o),
                         source};
    found.calibration.correction.reversed = reversed;
    // Odometry in the scans' own records cannot be moved in time.
    if (source != WheelSource::wheels && log.stream.size() < kLeastRecords)
      found.calibration.correction.lag = 0;
    if (!best || fit_of(found.calibration) > fit_of(best->calibration)) best = std::move(found);
  }
  return *best;
}

}  // namespace majak::motion
