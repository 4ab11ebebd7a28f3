// SPDX-License-Identifier: Apache-2.0
// A log made worse, to see which method notices: worn wheels, stray returns, no wheels, its first
// part alone.
#pragma once

#include <cstdint>
#include <vector>

#include "majak/core/event.hpp"

namespace majak::eval {

/// What new wheels err by: sigma, by way and by turn.
struct WheelWear {
  double way = 0.005;    ///< m per sqrt(m), along and across
  double turn = 0.002;   ///< rad per sqrt(m) ...
  double spin = 0.005;   ///< ... and rad per sqrt(rad)
  double scale = 0.005;  ///< share of all ways, drawn once
};

/// Wheels that err `factor` times as WheelWear says, beside what they err already. Odometry, the
/// odometry in scans' own records (each with errors of its own) and the speed of WheelMotion.
std::vector<Event> with_worn_wheels(std::vector<Event> events, double factor, std::uint64_t seed,
                                    const WheelWear& wear = {});

/// That share of the returns ends anywhere before what was met, as if something passed there.
std::vector<Event> with_stray_returns(std::vector<Event> events, double share, std::uint64_t seed);

std::vector<Event> without_wheels(std::vector<Event> events);

/// Up to that share of the scans.
std::vector<Event> first_part(std::vector<Event> events, double share);

}  // namespace majak::eval
