// SPDX-License-Identifier: Apache-2.0
// The pose that brings points onto points best.
#pragma once

#include <cassert>
#include <cmath>
#include <span>

#include "majak/core/pose2.hpp"

namespace majak {

/// T_b_a with the least sum of |T_b_a * a_i - b_i|^2 over points in m (MATH 7.13; Arun, Huang and
/// Blostein 1987, in the plane). As many of one as of the other, and not none.
inline Pose2 rigid_fit(std::span<const Vec2> a, std::span<const Vec2> b) {
  assert(a.size() == b.size() && !a.empty());
  Vec2 a_mean = Vec2::Zero(), b_mean = Vec2::Zero();
  const auto n = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) a_mean += a[i] / n, b_mean += b[i] / n;
  double dots = 0, crosses = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 p = a[i] - a_mean, q = b[i] - b_mean;
    dots += p.dot(q);
    crosses += p.x() * q.y() - p.y() * q.x();
  }
  const Pose2 turn{0, 0, std::atan2(crosses, dots)};
  const Vec2 t = b_mean - turn * a_mean;
  return {t.x(), t.y(), turn.theta};
}

}  // namespace majak
