// SPDX-License-Identifier: Apache-2.0
// Pose2: a pose in the plane, an element of SE(2). Frames are in the names:
//   T_map_robot * p_robot -> p_map,   T_map_robot * T_robot_laser -> T_map_laser.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "majak/core/angle.hpp"

namespace majak {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

struct Pose2 {
  double x = 0;      ///< m
  double y = 0;      ///< m
  double theta = 0;  ///< rad, counter-clockwise, in (-pi, pi] after any operation below

  bool operator==(const Pose2&) const = default;

  Vec2 translation() const { return {x, y}; }
  Vec3 vector() const { return {x, y, theta}; }
  bool finite() const { return std::isfinite(x) && std::isfinite(y) && std::isfinite(theta); }

  Pose2 inverse() const {
    const double c = std::cos(theta), s = std::sin(theta);
    return {-c * x - s * y, s * x - c * y, wrap_angle(-theta)};
  }
};

inline Pose2 operator*(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.theta), s = std::sin(a.theta);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y, wrap_angle(a.theta + b.theta)};
}

inline Vec2 operator*(const Pose2& a, const Vec2& p) {
  const double c = std::cos(a.theta), s = std::sin(a.theta);
  return {a.x + c * p.x() - s * p.y(), a.y + s * p.x() + c * p.y()};
}

/// T_a_b from T_w_a and T_w_b.
inline Pose2 between(const Pose2& a, const Pose2& b) { return a.inverse() * b; }

inline Pose2 from_vector(const Vec3& v) { return {v.x(), v.y(), wrap_angle(v.z())}; }

/// sin(t)/t and (1-cos(t))/t with their series at the straight limit.
struct ArcFactors {
  double sinc, cosc;
};
inline ArcFactors arc_factors(double t) {
  if (std::abs(t) < 1e-4) return {1.0 - t * t / 6.0, t / 2.0 - t * t * t / 24.0};
  return {std::sin(t) / t, (1.0 - std::cos(t)) / t};
}

/// Exponential map: a twist (vx, vy, omega) held for one unit of time gives a pose.
inline Pose2 exp(const Vec3& twist) {
  const auto [a, b] = arc_factors(twist.z());
  return {a * twist.x() - b * twist.y(), b * twist.x() + a * twist.y(), wrap_angle(twist.z())};
}

/// Logarithm: the twist with exp(log(T)) == T, turn in (-pi, pi].
inline Vec3 log(const Pose2& p) {
  const auto [a, b] = arc_factors(p.theta);
  const double n = a * a + b * b;
  return {(a * p.x + b * p.y) / n, (a * p.y - b * p.x) / n, p.theta};
}

/// Right Jacobian: exp(v + d) = exp(v) * exp(right_jacobian(v) * d) to first order (MATH 1.9).
inline Mat3 right_jacobian(const Vec3& twist) {
  const double t = twist.z(), t2 = t * t, half = std::sin(t / 2);
  const auto [a, b] = arc_factors(t);
  const double c = t2 < 1e-8 ? 0.5 - t2 / 24 : 2 * half * half / t2;  // (1 - cos t) / t^2
  const double d =  // (t - sin t) / t^2, which loses digits long before t is 0
      t2 < 0.09 ? t / 6 * (1 - t2 / 20 * (1 - t2 / 42 * (1 - t2 / 72 * (1 - t2 / 110))))
                : (t - std::sin(t)) / t2;
  Mat3 m;
  m << a, b, d * twist.x() - c * twist.y(), -b, a, c * twist.x() + d * twist.y(), 0, 0, 1;
  return m;
}

/// Adjoint: T * exp(v) * T^-1 == exp(adjoint(T) * v).
inline Mat3 adjoint(const Pose2& p) {
  const double c = std::cos(p.theta), s = std::sin(p.theta);
  Mat3 m;
  m << c, -s, p.y, s, c, -p.x, 0, 0, 1;
  return m;
}

/// The pose a fraction of the way along the arc from a (0) to b (1).
inline Pose2 interpolate(const Pose2& a, const Pose2& b, double fraction) {
  return a * exp(fraction * log(between(a, b)));
}

}  // namespace majak
