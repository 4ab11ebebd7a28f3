// SPDX-License-Identifier: Apache-2.0
#include "majak/io/carmen_writer.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "majak/core/error.hpp"

namespace majak::io {

namespace {

constexpr float kCodeCm = 81.91f, kCodeMm = 8.19f;  // m; what an LMS-2xx answers without an echo

template <class... Args>
void append(std::string& out, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
}

/// Seconds with six decimals, from the integer: exact for whole microseconds.
void append_seconds(std::string& out, Duration time) {
  const Duration micros = (std::abs(time) + 500) / 1000;
  append(out, "{}{}.{:06}", time < 0 ? "-" : "", micros / 1'000'000, micros % 1'000'000);
}

void append_pose(std::string& out, const Pose2& pose) {
  append(out, " {:.6f} {:.6f} {:.6f}", pose.x, pose.y, pose.theta);
}

/// Centimetres where that is what the device measures.
void append_ranges(std::string& out, const Scan& scan) {
  const float code = scan.max_range > kCodeMm ? std::max(kCodeCm, scan.max_range) : kCodeMm;
  append(out, " {}", scan.ranges.size());
  for (const float range : scan.ranges) {
    const float value = std::isfinite(range) ? range : (range > 0 ? code : 0.0f);
    const float hundredths = value * 100;
    if (std::abs(hundredths - std::round(hundredths)) < 0.01f) {
      append(out, " {:.2f}", value);
    } else {
      append(out, " {:.4f}", value);
    }
  }
}

bool near(double a, double b) { return std::abs(a - b) < 1e-9; }

/// FLASER and RLASER say no geometry: readers take it from the number of beams.
bool fits_old_record(const Scan& scan) {
  const std::size_t n = scan.ranges.size();
  const bool whole = (n == 180 || n == 181) && near(scan.angle_step, radians(1.0));
  const bool half = (n == 360 || n == 361) && near(scan.angle_step, radians(0.5));
  return (whole || half) && near(scan.start_angle, -kPi / 2) && scan.laser <= 1 &&
         scan.intensities.empty() && scan.T_odom_robot.has_value();
}

}  // namespace

CarmenWriter::CarmenWriter(const std::filesystem::path& path, std::string_view comment)
    : file_(path) {
  std::string head = "# CARMEN Logfile\n";
  while (!comment.empty()) {
    const std::size_t stop = std::min(comment.find('\n'), comment.size());
    append(head, "# {}\n", comment.substr(0, stop));
    comment.remove_prefix(std::min(stop + 1, comment.size()));
  }
  file_.write(head);
}

void CarmenWriter::end_line(Time time) {
  if (!first_time_) first_time_ = time;
  line_ += ' ';
  append_seconds(line_, time);
  line_ += " majak ";
  append_seconds(line_, time - *first_time_);
  line_ += '\n';
  file_.write(line_);
  line_.clear();
}

void CarmenWriter::write(const Event& event) {
  if (const auto* scan = std::get_if<Scan>(&event)) {
    write_scan(*scan);
  } else if (const auto* odometry = std::get_if<Odometry>(&event)) {
    T_odom_robot_ = odometry->T_odom_robot;
    line_ += "ODOM";
    append_pose(line_, T_odom_robot_);
    append(line_, " {:.6f} {:.6f} 0.000000", odometry->speed.value_or(0),
           odometry->turn_rate.value_or(0));
    end_line(odometry->time);
  } else if (const auto* truth = std::get_if<Truth>(&event)) {
    line_ += "TRUEPOS";
    append_pose(line_, truth->T_world_robot);
    append_pose(line_, T_odom_robot_);
    end_line(truth->time);
  } else {
    report_.count("events that a CARMEN log has no record for; left out");
  }
}

void CarmenWriter::write_parameters(const Scan& scan) {
  described_[static_cast<std::size_t>(scan.laser)] = true;
  if (scan.laser > 1) return;  // CARMEN names parameters for two lasers
  const char* const side = scan.laser == 0 ? "front" : "rear";
  append(line_, "PARAM robot_{}laser_offset {:.6f}", side, scan.T_robot_laser.x);
  end_line(scan.time);
  append(line_, "PARAM robot_{}laser_side_offset {:.6f}", side, scan.T_robot_laser.y);
  end_line(scan.time);
  append(line_, "PARAM robot_{}_laser_max {:.2f}", side, scan.max_range);
  end_line(scan.time);
  append(line_, "PARAM laser_{}_laser_resolution {:.6g}", side, degrees(scan.angle_step));
  end_line(scan.time);
}

void CarmenWriter::write_scan(const Scan& scan) {
  if (scan.laser < 0 || scan.laser > 4) {
    throw Error(
        fmt::format("a CARMEN log has no place for laser {}: it numbers 0 to 4", scan.laser));
  }
  if (!described_[static_cast<std::size_t>(scan.laser)]) write_parameters(scan);
  if (scan.T_odom_robot && scan.laser == 0) T_odom_robot_ = *scan.T_odom_robot;
  const bool located = scan.T_odom_robot.has_value() && scan.laser <= 1;
  const bool old = fits_old_record(scan);
  if (old) {
    line_ += scan.laser == 0 ? "FLASER" : "RLASER";
    append_ranges(line_, scan);
  } else {
    // laser_type (unknown) start_angle fov angular_resolution maximum_range accuracy remission_mode
    const double fov = scan.angle_step * (static_cast<double>(scan.ranges.size()) - 1);
    append(line_, "{}{} 99 {:.6f} {:.6f} {:.6f} {:.6f} 0.010000 {}",
           located ? "ROBOTLASER" : "RAWLASER", scan.laser + 1, scan.start_angle, fov,
           scan.angle_step, scan.max_range, scan.intensities.empty() ? 0 : 1);
    append_ranges(line_, scan);
    append(line_, " {}", scan.intensities.size());
    for (const float intensity : scan.intensities) append(line_, " {:.6g}", intensity);
  }
  if (located) {
    append_pose(line_, *scan.T_odom_robot * scan.T_robot_laser);
    append_pose(line_, *scan.T_odom_robot);
    // laser_tv laser_rv forward_safety_dist side_safety_dist turn_axis
    if (!old) line_ += " 0 0 0 0 0";
  }
  end_line(scan.time);
}

}  // namespace majak::io
