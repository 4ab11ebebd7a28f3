// SPDX-License-Identifier: Apache-2.0
// Source: where events come from, one at a time and in the order of the file. Memory is bounded by
// one record (plus a short look ahead); what was skipped or mended is counted in the report.
//
//   auto log = io::open_log("intel.clf.bz2");
//   while (auto event = log->next()) use(*event);
//   print(log->report());
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "majak/core/event.hpp"
#include "majak/core/report.hpp"

namespace majak::io {

class Source {
 public:
  virtual ~Source();
  /// The next event, or nothing at the end. Throws majak::Error when the medium fails.
  virtual std::optional<Event> next() = 0;
  /// What was noticed so far; complete after next() has returned nothing.
  virtual const Report& report() const = 0;
  /// What it is, for people: "CARMEN log, bzip2", "Victoria Park folder".
  virtual const std::string& format() const = 0;
};

/// What to believe instead of what a log says, or beside it.
struct SourceOptions {
  std::string topic;                     ///< of the laser, where a ROS recording has more than one
  double angle_step = 0;                 ///< degrees between beams; 0: as stated
  std::optional<Pose2> T_robot_laser{};  ///< where the laser stands on the robot; absent: as stated
  std::filesystem::path gps{};           ///< another log whose fixes belong to this one, by time
};

/// Throws Error when angle_step is no such step.
void check_angle_step(const SourceOptions& options);

/// Opens a log; its format is found by what is inside, never by its name: a CARMEN log (plain, gzip
/// or bzip2), a Victoria Park folder, a ROS 1 bag, an MCAP file, a ROS 2 bag (SQLite file or
/// folder), a Player log, NMEA sentences. Throws majak::Error, one line that names the file, when
/// it cannot be read or is none of these, or when an option is given that means nothing to it.
std::unique_ptr<Source> open_log(const std::filesystem::path& path,
                                 const SourceOptions& options = {});

}  // namespace majak::io
