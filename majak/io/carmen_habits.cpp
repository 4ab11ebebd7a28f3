// SPDX-License-Identifier: Apache-2.0
#include "majak/io/carmen_habits.hpp"

#include <cmath>

#include "majak/io/number.hpp"

namespace majak::io {

namespace {

// The window: long enough for the robot to have driven some metres, short enough for 4 MB.
constexpr std::size_t kLeastScans = 200;
constexpr std::size_t kScansWithoutPath = 2000;
constexpr std::size_t kMostRecords = 20000;
constexpr std::size_t kMostRanges = std::size_t{1} << 20;
constexpr double kPathToSee = 10.0;  // m

const char* const kBadRanges = "range values that are no positive number; marked invalid";
const char* const kRepeats = "raw laser messages that repeat a scan with odometry; left out";
const char* const kRmcRepeats = "NMEARMC fixes beside NMEAGGA; left out";
const char* const kLateCode = "no-return codes recognised late; earlier scans keep them as ranges";
const char* const kStepIgnored =
    "scans whose number of beams contradicts the resolution parameter; it was ignored";
const char* const kLoggerClock = "the sensor clock stands still; logger times used";

constexpr std::array<const char*, 8> kBackwards = {
    "scan stamps that run backwards; order of the file kept (front laser)",
    "scan stamps that run backwards; order of the file kept (rear laser)",
    "scan stamps that run backwards; order of the file kept (laser 3)",
    "scan stamps that run backwards; order of the file kept (laser 4)",
    "scan stamps that run backwards; order of the file kept (laser 5)",
    "odometry stamps that run backwards; order of the file kept",
    "GPS stamps that run backwards; order of the file kept",
    "truth stamps that run backwards; order of the file kept"};

bool same_mounting(const Pose2& a, const Pose2& b) {
  return std::abs(a.x - b.x) < 0.005 && std::abs(a.y - b.y) < 0.005 &&
         std::abs(angle_diff(a.theta, b.theta)) < 0.005;
}

double round_to(double value, double unit) {
  return std::round(value / unit) * unit + 0.0;
}  // no -0

}  // namespace

void CarmenHabits::read_parameter(std::string_view name, std::string_view value) {
  Fields f(value);
  double number = 0;
  if (!f.number(number) || !std::isfinite(number)) return;
  Laser& front = lasers_[0];
  Laser& rear = lasers_[1];
  if (name == "robot_frontlaser_offset") front.forward_offset = number;
  if (name == "robot_rearlaser_offset") rear.forward_offset = number;
  if (name == "robot_frontlaser_side_offset") front.side_offset = number;
  if (name == "robot_rearlaser_side_offset") rear.side_offset = number;
  if (name == "robot_front_laser_max" && number > 0) front.max_range = number;
  if (name == "robot_rear_laser_max" && number > 0) rear.max_range = number;
  const bool step = number >= 0.01 && number <= 10;  // degrees
  if (name == "laser_front_laser_resolution" && step) front.resolution = radians(number);
  if (name == "laser_rear_laser_resolution" && step) rear.resolution = radians(number);
}

void CarmenHabits::observe(const CarmenRecord& record) {
  if (record.kind == CarmenRecord::Kind::param) return read_parameter(record.name, record.value);
  ++records_;
  observe_clock(record);
  gga_seen_ |= record.fix == CarmenFix::gga;
  if (const auto* scan = std::get_if<Scan>(&record.event)) observe_scan(*scan, record);
  if (const auto* odometry = std::get_if<Odometry>(&record.event)) {
    velocity_seen_ |= odometry->speed.value_or(0) != 0 || odometry->turn_rate.value_or(0) != 0;
    if (!path_from_scans_) observe_path(odometry->T_odom_robot);
  }
}

void CarmenHabits::observe_scan(const Scan& scan, const CarmenRecord& record) {
  ++scans_;
  ranges_ += scan.ranges.size();
  Laser& laser = lasers_[static_cast<std::size_t>(scan.laser)];
  laser.located |= record.laser == CarmenLaser::located;
  if (scan.T_odom_robot && scan.laser == 0) {
    if (!path_from_scans_) T_odom_last_.reset();
    path_from_scans_ = true;
    observe_path(*scan.T_odom_robot);
  }
  if (record.T_odom_laser && scan.T_odom_robot) {
    const Pose2 T_robot_laser = between(*scan.T_odom_robot, *record.T_odom_laser);
    if (laser.stated++ == 0) laser.T_robot_laser_first = T_robot_laser;
    laser.constant &= same_mounting(laser.T_robot_laser_first, T_robot_laser);
    laser.offset_sum += T_robot_laser.translation();
  }
  Scan limited = scan;
  limited.max_range = limit(scan, record.geometry_stated);
  laser.finder.add(limited);
}

void CarmenHabits::observe_path(const Pose2& T_odom_robot) {
  if (T_odom_last_) path_ += (T_odom_robot.translation() - T_odom_last_->translation()).norm();
  T_odom_last_ = T_odom_robot;
}

void CarmenHabits::observe_clock(const CarmenRecord& record) {
  const Time ipc = time_of(record.event);
  if (!first_ipc_) first_ipc_ = ipc;
  ipc_ticks_ |= ipc != *first_ipc_;
  if (!record.logger_time) return;
  if (!first_logger_) first_logger_ = record.logger_time;
  logger_ticks_ |= *record.logger_time != *first_logger_;
}

bool CarmenHabits::enough() const {
  if (records_ >= kMostRecords || ranges_ >= kMostRanges) return true;
  return scans_ >= kLeastScans && (path_ >= kPathToSee || scans_ >= kScansWithoutPath);
}

void CarmenHabits::settle() {
  use_logger_time_ = !ipc_ticks_ && first_logger_ && (logger_ticks_ || first_ipc_ == Time{0});
  velocity_missing_ = !velocity_seen_ && path_ > 0.1;
  from_window_ = scans_;
  for (std::size_t i = 0; i < lasers_.size(); ++i)
    lasers_[i].T_robot_laser = mounting(lasers_[i], i == 1);
}

/// The two pose triples where they agree on one constant mounting that makes sense; else the
/// parameters; else the laser stands on the robot's centre. A rear laser looks backwards.
Pose2 CarmenHabits::mounting(const Laser& laser, bool rear) const {
  if (laser.stated > 0 && laser.constant) {
    const Vec2 mean = laser.offset_sum / static_cast<double>(laser.stated);
    Pose2 T{round_to(mean.x(), 1e-4), round_to(mean.y(), 1e-4), laser.T_robot_laser_first.theta};
    const bool ahead = std::abs(T.theta) < 1e-3, behind = std::abs(angle_diff(T.theta, kPi)) < 1e-3;
    if (ahead) T.theta = 0;
    if (behind) T.theta = kPi;
    const bool says_something = T.x != 0 || T.y != 0 || !ahead;
    // A robot that stands still lets the poses of a corrected log look constant, too.
    const bool credible = mean.norm() < 3.0 && (path_ > 1.0 || ahead || behind);
    if (says_something && credible) {
      if (rear && ahead) T.theta = kPi;
      return T;
    }
  }
  const double forward = laser.forward_offset.value_or(0), side = laser.side_offset.value_or(0);
  // Old CARMEN counts the rear offset along the laser's own heading, newer along the robot's.
  return rear ? Pose2{-std::abs(forward), side, kPi} : Pose2{forward, side, 0};
}

float CarmenHabits::limit(const Scan& scan, bool stated) const {
  const Laser& laser = lasers_[static_cast<std::size_t>(scan.laser)];
  float most = scan.max_range;
  if (!stated && laser.max_range) most = static_cast<float>(*laser.max_range);
  most = sick_limit(most);
  if (const auto code = laser.finder.code()) {
    const float from = sick_limit(*code);
    most = std::min(most, from < *code ? from : *code - 0.005f);
  }
  return most;
}

bool CarmenHabits::complete(CarmenRecord& record, std::int64_t line, Report& report) {
  if (use_logger_time_ && record.logger_time) {
    std::visit([&](auto& event) { event.time = *record.logger_time; }, record.event);
    report.count(kLoggerClock, line);
  }
  if (auto* scan = std::get_if<Scan>(&record.event)) {
    if (!complete_scan(*scan, record, line, report)) return false;
  } else if (auto* odometry = std::get_if<Odometry>(&record.event)) {
    complete_odometry(*odometry);
  } else if (auto* fix = std::get_if<GpsFix>(&record.event)) {
    if (!complete_fix(*fix, record, line, report)) return false;
  }
  watch_stamp(record.event, line, report);
  return true;
}

bool CarmenHabits::complete_scan(Scan& scan, const CarmenRecord& record, std::int64_t line,
                                 Report& report) {
  Laser& laser = lasers_[static_cast<std::size_t>(scan.laser)];
  const bool observed = from_window_ > 0;
  if (observed) --from_window_;
  laser.located |= record.laser == CarmenLaser::located;
  if (record.laser == CarmenLaser::raw && laser.located) {
    report.count(kRepeats, line);
    return false;
  }
  if (record.bad_ranges > 0) report.add(kBadRanges, {record.bad_ranges, line});
  if (!record.geometry_stated && laser.resolution) complete_geometry(scan, line, report);
  scan.T_robot_laser = laser.T_robot_laser;
  scan.max_range = limit(scan, record.geometry_stated);
  if (!observed && !laser.finder.code()) {
    laser.finder.add(scan);
    if (laser.finder.code()) {
      report.count(kLateCode, line);
      scan.max_range = limit(scan, record.geometry_stated);
    }
  }
  for (float& range : scan.ranges) range = range >= scan.max_range ? kNoReturn : range;
  return true;
}

/// The parameter says the step, unless that would give more than half a circle to a laser whose
/// number of beams tells what it is.
void CarmenHabits::complete_geometry(Scan& scan, std::int64_t line, Report& report) const {
  const double step = *lasers_[static_cast<std::size_t>(scan.laser)].resolution;
  if (std::abs(step - scan.angle_step) < 1e-6) return;
  if (step * static_cast<double>(scan.ranges.size() - 1) > kPi + 1e-6)
    return report.count(kStepIgnored, line);
  const BeamGeometry geometry = geometry_by_step(scan.ranges.size(), step);
  scan.start_angle = geometry.start_angle;
  scan.angle_step = geometry.angle_step;
}

/// Some logs write zero velocities while the robot drives: then they say nothing.
void CarmenHabits::complete_odometry(Odometry& odometry) {
  if (!velocity_missing_) return;
  if (odometry.speed.value_or(0) != 0 || odometry.turn_rate.value_or(0) != 0) {
    velocity_missing_ = false;
    return;
  }
  odometry.speed.reset();
  odometry.turn_rate.reset();
}

bool CarmenHabits::complete_fix(GpsFix& fix, const CarmenRecord& record, std::int64_t line,
                                Report& report) {
  gga_seen_ |= record.fix == CarmenFix::gga;
  if (record.fix == CarmenFix::rmc && gga_seen_) {
    report.count(kRmcRepeats, line);
    return false;
  }
  const Vec2 p = frame_.east_north({record.latitude, record.longitude, record.altitude});
  fix.east = p.x();
  fix.north = p.y();
  return true;
}

void CarmenHabits::watch_stamp(const Event& event, std::int64_t line, Report& report) {
  std::size_t sensor = kLasers;
  if (const auto* scan = std::get_if<Scan>(&event)) sensor = static_cast<std::size_t>(scan->laser);
  if (std::holds_alternative<GpsFix>(event)) sensor = kLasers + 1;
  if (std::holds_alternative<Truth>(event)) sensor = kLasers + 2;
  const Time time = time_of(event);
  std::optional<Time>& last = last_stamp_[sensor];
  if (last && time < *last) report.count(kBackwards[sensor], line);
  last = time;
}

}  // namespace majak::io
