// SPDX-License-Identifier: Apache-2.0
// Angles in radians. Angles are subtracted by angle_diff() and by nothing else.
#pragma once

#include <cmath>
#include <numbers>

namespace majak {

inline constexpr double kPi = std::numbers::pi;

inline constexpr double radians(double degrees) { return degrees * (kPi / 180.0); }
inline constexpr double degrees(double radians) { return radians * (180.0 / kPi); }

/// The same direction in (-pi, pi]. NaN stays NaN.
inline double wrap_angle(double angle) {
  if (angle > -kPi && angle <= kPi) return angle;
  const double r = std::remainder(angle, 2.0 * kPi);  // [-pi, pi]
  return r <= -kPi ? r + 2.0 * kPi : r;
}

/// The shortest turn from b to a, in (-pi, pi].
inline double angle_diff(double a, double b) { return wrap_angle(a - b); }

}  // namespace majak
