// SPDX-License-Identifier: Apache-2.0
// One line of a CARMEN log -> one record, without any knowledge of the other lines.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "majak/core/event.hpp"

namespace majak::io {

/// How a laser message came to be; the same scan may be in a log more than once.
enum class CarmenLaser : std::uint8_t {
  none,
  raw,      ///< RAWLASERn, LASERn: from the device
  located,  ///< FLASER, RLASER, ROBOTLASERn: the same with the robot's odometry
};

enum class CarmenFix : std::uint8_t { none, gga, rmc };

/// What one line says.
struct CarmenRecord {
  enum class Kind : std::uint8_t {
    event,    ///< one of the fields below
    param,    ///< name and value
    nothing,  ///< comment, blank line or a message that has no use here
    unknown,  ///< no CARMEN message
    damaged,  ///< `problem` says why
  };
  Kind kind = Kind::nothing;
  const char* problem = nullptr;

  Event event;  ///< stamped with the time of the sensor (ipc)
  std::optional<Time> logger_time;
  CarmenLaser laser = CarmenLaser::none;
  bool geometry_stated = false;       ///< else the scan's angles follow from the number of beams
  std::optional<Pose2> T_odom_laser;  ///< as the log states it
  std::int64_t bad_ranges = 0;  ///< values that are no positive number (a plain 0 is not counted)
  CarmenFix fix = CarmenFix::none;
  double latitude = 0, longitude = 0, altitude = 0;  ///< degrees, m

  std::string_view name, value;  ///< of a PARAM; inside the line
};

/// `line` must be followed by one readable byte that is no digit. With `cut_off` the file ended
/// inside the line, so its last number cannot be trusted.
void parse_carmen_line(std::string_view line, bool cut_off, CarmenRecord& record);

/// Does this text contain a line that only a CARMEN log would?
bool looks_like_carmen(std::string_view text);

/// Angles for a message that states none, by its number of beams.
struct BeamGeometry {
  double start_angle = 0;  ///< rad
  double angle_step = 0;   ///< rad
};
BeamGeometry geometry_by_count(std::size_t beams);
/// The same when a parameter states the step; rad.
BeamGeometry geometry_by_step(std::size_t beams, double step);

}  // namespace majak::io
