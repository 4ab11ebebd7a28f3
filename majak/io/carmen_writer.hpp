// SPDX-License-Identifier: Apache-2.0
// CarmenWriter: events as an ordinary CARMEN log, which any program of this field reads.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "majak/core/event.hpp"
#include "majak/core/report.hpp"
#include "majak/io/atomic_file.hpp"

namespace majak::io {

/// Scans of a half circle in steps of 1 or 0.5 degrees become FLASER or RLASER, others ROBOTLASERn,
/// those without odometry RAWLASERn; before the first scan of a laser stand the PARAM lines with
/// its mounting, range and resolution. Odometry becomes ODOM, Truth TRUEPOS. Stamps and poses have
/// six decimals; a no-return is written as the device's own code, 81.91 or 8.19 m, an invalid range
/// as 0.
class CarmenWriter {
 public:
  /// Throws Error when the file cannot be made. `comment` (lines without '#') goes to its head.
  explicit CarmenWriter(const std::filesystem::path& path, std::string_view comment = {});

  /// Throws Error when the disk is full, or for a scan that CARMEN has no place for (laser > 4).
  void write(const Event& event);

  /// The log appears under its name. Without it, there is none.
  void commit() { file_.commit(); }

  /// Events for which a CARMEN log has no record (wheel motion, fixes in a local frame).
  const Report& report() const { return report_; }

 private:
  void write_scan(const Scan& scan);
  void write_parameters(const Scan& scan);
  void end_line(Time time);

  AtomicFile file_;
  std::string line_;
  Report report_;
  std::optional<Time> first_time_;
  Pose2 T_odom_robot_;  ///< the last one told, for TRUEPOS
  std::array<bool, 5> described_{};
};

}  // namespace majak::io
