// SPDX-License-Identifier: Apache-2.0
// Tour: a way through a world that keeps clear of its walls.
#pragma once

#include <vector>

#include "majak/sim/world.hpp"

namespace majak::sim {

struct TourOptions {
  double clearance = 0.32;  ///< m, kept to every wall
  double spacing = 4.0;     ///< m between places to visit where the world names none
  int laps = 1;             ///< 1 ...: the tour is repeated
  bool short_tour = false;  ///< the world's tour of about 100 m
};

/// A way to drive: points about kPathStep apart.
struct Path {
  Pose2 start;  ///< T_world_robot
  std::vector<Vec2> points;
};
inline constexpr double kPathStep = 0.1;  // m

/// Through the world's own tour, or, where it has none, through places all over the reachable
/// floor, nearest first, and back to the start. Throws Error when the start is inside a wall or a
/// place of the tour cannot be reached.
Path plan_tour(const World& world, const TourOptions& options = {});

/// Length of the polyline, m.
double length(const std::vector<Vec2>& points);

}  // namespace majak::sim
