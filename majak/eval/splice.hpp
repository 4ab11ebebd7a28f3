// SPDX-License-Identifier: Apache-2.0
// A robot that is carried to another place, made from an ordinary log: a stretch of it is cut out.
// The wheels go on counting as if nothing had been, the scans jump.
#pragma once

#include <optional>
#include <vector>

#include "majak/eval/trajectory.hpp"

namespace majak::eval {

/// Where the wheels say that the robot was, from odometry records, or from those in the scans.
Trajectory wheels_of(const std::vector<Event>& events);

struct Splice {
  std::vector<Event> events;
  Time jump = 0;       ///< of the first scan at the other place, in the new log
  Time last = 0;       ///< of the scan before it
  Duration later = 0;  ///< ns: what comes after the jump was stamped so much later in the old log

  /// A path of the old log, as it is stamped in the new one.
  Trajectory spliced(const Trajectory& path) const;
};

/// From a third of the scans to two thirds, or to the first scan after these (else before these) at
/// which `way` lies `apart` m off; where `way` does not reach, it is not asked. Nothing: the log is
/// shorter than six scans, or goes nowhere else.
std::optional<Splice> splice(const std::vector<Event>& events, const Trajectory& way, double apart);

}  // namespace majak::eval
