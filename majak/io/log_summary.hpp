// SPDX-License-Identifier: Apache-2.0
// LogSummary: what is in a log, gathered event by event in memory that does not grow with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "majak/core/event.hpp"

namespace majak::io {

/// The stamps of one sensor, in the order of the file.
struct StampSummary {
  static constexpr Duration kGap = kSecond;  ///< a longer pause is a gap

  std::int64_t count = 0;
  Time first = 0, last = 0;  ///< in the order of the file
  Time earliest = 0, latest = 0;
  std::int64_t backwards = 0, repeated = 0, gaps = 0;
  Duration worst_backwards = 0, longest_gap = 0;
  Time longest_gap_after = 0;

  void add(Time time);
  Duration duration() const { return latest - earliest; }
  /// Records a second, 0 when there is no time between them.
  double rate() const;
};

struct LaserSummary {
  StampSummary stamps;
  std::size_t fewest_beams = 0, most_beams = 0;
  double start_angle = 0, angle_step = 0;  ///< rad, of the last scan
  float max_range = 0;                     ///< m, of the last scan
  float longest_return = 0;                ///< m
  Pose2 T_robot_laser;
  std::int64_t beams = 0, no_returns = 0, invalid = 0;
  std::int64_t with_odometry = 0, with_intensities = 0;

  void add(const Scan& scan);
  double field_of_view() const;  ///< rad, from the first beam to the last
};

/// How far a sequence of poses goes.
struct PathSummary {
  std::optional<Pose2> last;
  double length = 0;  ///< m
  double turned = 0;  ///< rad, left and right alike

  void add(const Pose2& pose);
};

struct LogSummary {
  std::map<int, LaserSummary> lasers;  ///< by number
  StampSummary odometry, wheels, gps, truth;
  std::int64_t odometry_with_speed = 0;
  PathSummary odometry_path;  ///< of the odometry records, else of the scans' own odometry
  PathSummary truth_path;
  double wheel_path = 0;                               ///< m, backwards counted too
  double gps_east[2] = {0, 0}, gps_north[2] = {0, 0};  ///< m, smallest and largest

  void add(const Event& event);
  std::int64_t events() const;
  std::int64_t scans() const;
  /// First and last time of all sensors; 0 without events.
  Time earliest() const;
  Time latest() const;

 private:
  void add_scan(const Scan& scan);
  void add_wheels(const WheelMotion& motion);
  void add_fix(const GpsFix& fix);

  double last_speed_ = 0;
};

}  // namespace majak::io
