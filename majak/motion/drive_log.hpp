// SPDX-License-Identifier: Apache-2.0
// DriveLog: what a log says of its wheels, kept for a calibration after the mapping.
//
//   motion::DriveLog drive;                       while reading: drive.add(event);
//   auto calibration = motion::calibrate_log(drive, site);
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/site.hpp"
#include "majak/motion/calibration.hpp"

namespace majak::motion {

/// Who tells of the wheels.
enum class WheelSource {
  stream,   ///< odometry records with stamps of their own
  records,  ///< the odometry in the scans' own records, by the scans' stamps
  ordered,  ///< the same, and the stamps tell only the order (scans stamped in bursts)
  wheels,   ///< speed and steering
};
const char* name_of(WheelSource source);

struct DriveLog {
  std::vector<Odometry> stream, records;  ///< records: one for each scan of the front laser
  std::vector<WheelMotion> wheels;
  bool all_scans_have_records = true;

  void add(const Event& event);
};

struct LogCalibrationOptions {
  double track = 0;      ///< m, as the odometry believes; 0: not known
  double wheelbase = 0;  ///< m, of a log with speed and steering
  /// Only these scans, [first, last) of the site's.
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();
};

struct LogCalibration {
  Calibration calibration;
  WheelSource source = WheelSource::stream;
};

/// Compares the final poses of a site, as mapped from this log, with its wheels. The source that
/// fits the laser best is taken. Throws Error if the log has no odometry or too little of it.
LogCalibration calibrate_log(const DriveLog& log, const Site& site,
                             const LogCalibrationOptions& options = {});

/// The samples of a source, and the times by which it knows the scans of the site.
std::vector<WheelSample> samples_of(const DriveLog& log, WheelSource source, bool reversed,
                                    double wheelbase);
std::vector<Time> scan_times(const Site& site, WheelSource source);
/// Of scans [first, last) that are placed well, by those times.
std::vector<LaserPose> laser_poses(const Site& site, WheelSource source, std::size_t first = 0,
                                   std::size_t last = std::numeric_limits<std::size_t>::max());

}  // namespace majak::motion
