// SPDX-License-Identifier: Apache-2.0
// Scans of a site that tell something new: a robot that stands still says the same again and again.
#pragma once

#include <cmath>
#include <optional>

#include "majak/core/site.hpp"

namespace majak::map {

/// Calls visit(posed) for each scan, in log order, that is `spacing` (m) or more away from the last
/// one visited or turned by `turn` (rad) or more. Lost scans and poses that are none are left out.
template <class Visit>
void for_spaced_scans(const Site& site, double spacing, double turn, const Visit& visit) {
  constexpr double kFarthest = 1e7;  // m; poses beyond this are no poses
  std::optional<Pose2> last;
  for (const PosedScan& posed : site.scans) {
    const Pose2& pose = posed.estimate.T_map_robot;
    if (posed.estimate.health == Health::lost || !pose.finite()) continue;
    if (pose.translation().cwiseAbs().maxCoeff() > kFarthest) continue;
    if (last) {
      const Pose2 step = between(*last, pose);
      if (step.translation().norm() < spacing && std::abs(step.theta) < turn) continue;
    }
    last = pose;
    visit(posed);
  }
}

}  // namespace majak::map
