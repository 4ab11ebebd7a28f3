// SPDX-License-Identifier: Apache-2.0
#include "majak/io/log_summary.hpp"

#include <algorithm>
#include <cmath>

namespace majak::io {

void StampSummary::add(Time time) {
  if (count++ == 0) {
    first = last = earliest = latest = time;
    return;
  }
  const Duration step = time - last;
  backwards += step < 0 ? 1 : 0;
  repeated += step == 0 ? 1 : 0;
  gaps += step > kGap ? 1 : 0;
  worst_backwards = std::max(worst_backwards, -step);
  if (step > kGap && step > longest_gap) {
    longest_gap = step;
    longest_gap_after = last;
  }
  last = time;
  earliest = std::min(earliest, time);
  latest = std::max(latest, time);
}

double StampSummary::rate() const {
  return duration() > 0 ? static_cast<double>(count - 1) / to_seconds(duration()) : 0.0;
}

void LaserSummary::add(const Scan& scan) {
  const std::size_t n = scan.ranges.size();
  fewest_beams = stamps.count == 0 ? n : std::min(fewest_beams, n);
  most_beams = std::max(most_beams, n);
  stamps.add(scan.time);
  start_angle = scan.start_angle;
  angle_step = scan.angle_step;
  max_range = scan.max_range;
  T_robot_laser = scan.T_robot_laser;
  beams += static_cast<std::int64_t>(n);
  with_odometry += scan.T_odom_robot ? 1 : 0;
  with_intensities += scan.intensities.empty() ? 0 : 1;
  std::int32_t none = 0, bad = 0;
  float longest = longest_return;
  for (const float range : scan.ranges) {
    none += range == kNoReturn ? 1 : 0;
    bad += range != range ? 1 : 0;
    longest = range > longest && range < kNoReturn ? range : longest;
  }
  no_returns += none;
  invalid += bad;
  longest_return = longest;
}

double LaserSummary::field_of_view() const {
  return most_beams > 0 ? angle_step * static_cast<double>(most_beams - 1) : 0.0;
}

void PathSummary::add(const Pose2& pose) {
  if (last) {
    length += (pose.translation() - last->translation()).norm();
    turned += std::abs(angle_diff(pose.theta, last->theta));
  }
  last = pose;
}

void LogSummary::add(const Event& event) {
  if (const auto* scan = std::get_if<Scan>(&event)) {
    add_scan(*scan);
  } else if (const auto* record = std::get_if<Odometry>(&event)) {
    if (odometry.count == 0) odometry_path = {};
    odometry.add(record->time);
    odometry_path.add(record->T_odom_robot);
    odometry_with_speed += record->speed ? 1 : 0;
  } else if (const auto* motion = std::get_if<WheelMotion>(&event)) {
    add_wheels(*motion);
  } else if (const auto* fix = std::get_if<GpsFix>(&event)) {
    add_fix(*fix);
  } else if (const auto* real = std::get_if<Truth>(&event)) {
    truth.add(real->time);
    truth_path.add(real->T_world_robot);
  }
}

void LogSummary::add_scan(const Scan& scan) {
  lasers[scan.laser].add(scan);
  if (scan.T_odom_robot && odometry.count == 0 && scan.laser == lasers.begin()->first) {
    odometry_path.add(*scan.T_odom_robot);
  }
}

void LogSummary::add_wheels(const WheelMotion& motion) {
  if (wheels.count > 0) wheel_path += std::abs(last_speed_ * to_seconds(motion.time - wheels.last));
  wheels.add(motion.time);
  last_speed_ = motion.speed;
}

void LogSummary::add_fix(const GpsFix& fix) {
  const bool first = gps.count == 0;
  gps_east[0] = first ? fix.east : std::min(gps_east[0], fix.east);
  gps_east[1] = first ? fix.east : std::max(gps_east[1], fix.east);
  gps_north[0] = first ? fix.north : std::min(gps_north[0], fix.north);
  gps_north[1] = first ? fix.north : std::max(gps_north[1], fix.north);
  gps.add(fix.time);
}

std::int64_t LogSummary::scans() const {
  std::int64_t sum = 0;
  for (const auto& [number, laser] : lasers) sum += laser.stamps.count;
  return sum;
}

std::int64_t LogSummary::events() const {
  return scans() + odometry.count + wheels.count + gps.count + truth.count;
}

namespace {

template <class Visit>
void each_sensor(const LogSummary& s, Visit visit) {
  for (const auto& [number, laser] : s.lasers) visit(laser.stamps);
  for (const StampSummary* stamps : {&s.odometry, &s.wheels, &s.gps, &s.truth}) {
    if (stamps->count > 0) visit(*stamps);
  }
}

}  // namespace

Time LogSummary::earliest() const {
  std::optional<Time> best;
  each_sensor(*this, [&](const StampSummary& s) {
    best = std::min(best.value_or(s.earliest), s.earliest);
  });
  return best.value_or(0);
}

Time LogSummary::latest() const {
  std::optional<Time> best;
  each_sensor(*this,
              [&](const StampSummary& s) { best = std::max(best.value_or(s.latest), s.latest); });
  return best.value_or(0);
}

}  // namespace majak::io
