// SPDX-License-Identifier: Apache-2.0
// CarmenHabits: what a single line of a CARMEN log does not say but the lines together do: the
// no-return code, the mounting of the lasers, which clock ticks, which messages repeat others.
// It watches the records of a window at the start of the log, settles, and then completes every
// record, those of the window included.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "majak/beacon/local_frame.hpp"
#include "majak/core/report.hpp"
#include "majak/io/carmen_record.hpp"
#include "majak/io/no_return.hpp"

namespace majak::io {

class CarmenHabits {
 public:
  /// Looks at a record of the window (events and parameters).
  void observe(const CarmenRecord& record);
  /// True when watching longer would not tell more, or would need too much memory.
  bool enough() const;
  /// Decides; to be called once, at the end of the window.
  void settle();
  /// Completes a record: time, angles, limits, mounting. False when it is to be left out.
  bool complete(CarmenRecord& record, std::int64_t line, Report& report);

 private:
  static constexpr int kLasers = 5;

  struct Laser {
    SaturationFinder finder;
    bool located = false;  ///< comes with odometry, so the raw message is the same scan again
    std::int64_t stated = 0;
    bool constant = true;       ///< the stated mounting never changed
    Pose2 T_robot_laser_first;  ///< as the first record stated it
    Vec2 offset_sum = Vec2::Zero();
    Pose2 T_robot_laser;  ///< decided
    // Parameters of the log.
    std::optional<double> forward_offset, side_offset, max_range, resolution;
  };

  void read_parameter(std::string_view name, std::string_view value);
  void observe_scan(const Scan& scan, const CarmenRecord& record);
  void observe_path(const Pose2& T_odom_robot);
  void observe_clock(const CarmenRecord& record);
  float limit(const Scan& scan, bool stated) const;
  Pose2 mounting(const Laser& laser, bool rear) const;
  bool complete_scan(Scan& scan, const CarmenRecord& record, std::int64_t line, Report& report);
  void complete_geometry(Scan& scan, std::int64_t line, Report& report) const;
  void complete_odometry(Odometry& odometry);
  bool complete_fix(GpsFix& fix, const CarmenRecord& record, std::int64_t line, Report& report);
  void watch_stamp(const Event& event, std::int64_t line, Report& report);

  std::array<Laser, kLasers> lasers_;
  std::size_t records_ = 0, scans_ = 0, ranges_ = 0;
  std::size_t from_window_ = 0;  ///< scans that were observed and are still to be completed
  std::optional<Pose2> T_odom_last_;
  bool path_from_scans_ = false;
  double path_ = 0;  ///< m, within the window
  std::optional<Time> first_ipc_, first_logger_;
  bool ipc_ticks_ = false, logger_ticks_ = false;
  bool use_logger_time_ = false;
  bool velocity_seen_ = false, velocity_missing_ = false;
  bool gga_seen_ = false;
  beacon::FirstFixFrame frame_;
  std::array<std::optional<Time>, kLasers + 3> last_stamp_;
};

}  // namespace majak::io
