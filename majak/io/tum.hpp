// SPDX-License-Identifier: Apache-2.0
// A trajectory as TUM lines: `time x y z qx qy qz qw`, one for every scan, the robot's pose in the
// map; z, qx and qy are 0. The time has the log's own digits (6 decimals of a second).
#pragma once

#include <string>

#include "majak/core/site.hpp"

namespace majak::io {

/// Seconds with exactly 6 decimals, rounded to the nearest microsecond, halves away from zero.
std::string format_stamp(Time time);

/// The whole file, in the order of the scans.
std::string tum_text(const Site& site);

}  // namespace majak::io
