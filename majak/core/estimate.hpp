// SPDX-License-Identifier: Apache-2.0
// Estimate: where the robot is, how sure that is, and whether it should be believed.
#pragma once

#include <cstdint>

#include "majak/core/pose2.hpp"
#include "majak/core/time.hpp"

namespace majak {

enum class Health : std::uint8_t {
  ok,
  degraded,  ///< at least one direction is held by motion prediction alone
  lost,      ///< the scan does not fit the place
};

inline const char* name_of(Health health) {
  return health == Health::ok ? "ok" : health == Health::degraded ? "degraded" : "lost";
}

struct Estimate {
  Time time = 0;
  Pose2 T_map_robot;
  Mat3 covariance = Mat3::Zero();  ///< of (x, y, theta) in the map's axes; m^2, m rad, rad^2
  Health health = Health::ok;
  Vec2 weak_direction = Vec2::Zero();  ///< unit vector in the map where degraded, else zero
};

}  // namespace majak
