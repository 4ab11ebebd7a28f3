// SPDX-License-Identifier: Apache-2.0
// Estimate: where the robot is, how sure that is, and whether it should be believed.
#pragma once

#include <cmath>
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

/// The direction in which a position is known least: the larger axis of its ellipse.
struct LeastKnown {
  double sigma = 0;                ///< m
  Vec2 direction = Vec2::UnitX();  ///< unit
};
inline LeastKnown least_known(const Mat3& covariance) {
  const double a = covariance(0, 0), b = covariance(0, 1), d = covariance(1, 1);
  const double variance = 0.5 * (a + d) + std::hypot(0.5 * (a - d), b);
  const double angle = 0.5 * std::atan2(2 * b, a - d);
  return {variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : 0.0,
          {std::cos(angle), std::sin(angle)}};
}

/// Not known in its weak direction.
inline void degrade(Estimate& estimate) {
  estimate.health = Health::degraded;
  estimate.weak_direction = least_known(estimate.covariance).direction;
}

}  // namespace majak
