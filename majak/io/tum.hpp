// SPDX-License-Identifier: Apache-2.0
// A trajectory as TUM lines: `time x y z qx qy qz qw`, one for every scan, the robot's pose in the
// map; z, qx and qy are 0. The time has the log's own digits (6 decimals of a second).
#pragma once

#include <span>
#include <string>

#include "majak/core/estimate.hpp"
#include "majak/core/site.hpp"

namespace majak::io {

/// Seconds with exactly 6 decimals, rounded to the nearest microsecond, halves away from zero.
std::string format_stamp(Time time);

/// The whole file, in the order of the scans.
std::string tum_text(const Site& site);

/// The same of any estimates, one line each.
std::string estimates_tum(std::span<const Estimate> estimates);

/// A line for each estimate: time, then the covariance of (x, y, theta) in the map's axes as
/// xx, xy, xt, yy, yt, tt (m^2, m rad, rad^2); the first line names the columns.
std::string covariance_csv(std::span<const Estimate> estimates);

}  // namespace majak::io
