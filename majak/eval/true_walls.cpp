// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/true_walls.hpp"

#include <algorithm>
#include <cmath>

#include "majak/match/scan_points.hpp"

namespace majak::eval {

void TrueWalls::add(const Scan& scan, const Pose2& T_truth_robot) {
  match::add_to(walls_, match::scan_points(scan, {.max_range = 30}, true), T_truth_robot);
}

double TrueWalls::off(const Vec2& p) const {
  const std::uint32_t wall = walls_.nearest(static_cast<float>(p.x()), static_cast<float>(p.y()));
  if (wall == map::SurfelMap::kNone) return kFar;
  const map::Surfel& s = walls_.surfel(wall);
  const Vec2 away(p.x() - s.x, p.y() - s.y), normal(s.nx, s.ny);
  return std::min(kFar, normal.isZero() ? away.norm() : std::abs(normal.dot(away)));
}

}  // namespace majak::eval
