// SPDX-License-Identifier: Apache-2.0
// Ways through a building: from place to place through doors, and along cells with room to the
// walls.
//
//   const Route route = find_route(known, topology, {2, 3}, {30, 12});
//   route.found, route.length, route.rooms, route.doors, route.way;
#pragma once

#include <vector>

#include "majak/core/options.hpp"
#include "majak/map/topology.hpp"

namespace majak::map {

struct RouteOptions {
  double radius = 0.25;  ///< m, of the robot as a disc
  double comfort = 0.7;  ///< m from walls: a wider berth is not worth a detour
  double wall_cost = 3;  ///< so many metres more does one along a wall cost
  double snap = 1.0;     ///< m, by which the ends may be moved to where the robot has room
};

inline void describe(OptionFields& fields, RouteOptions& o) {
  fields.add("route.radius", o.radius, {"m", "of the robot as a disc", 0, 10});
  fields.add("route.comfort", o.comfort, {"m", "a wider berth is not worth a detour", 0, 10});
  fields.add("route.wall_cost", o.wall_cost, {"1", "more does a metre along a wall cost", 0, 100});
  fields.add("route.snap", o.snap, {"m", "the ends may be moved so far", 0, 10});
}

struct Route {
  bool found = false;
  std::vector<int> rooms;  ///< in the order in which they are entered
  std::vector<int> doors;  ///< between them, one fewer; -1 where no door is known
  std::vector<Vec2> way;   ///< map frame, centres of cells
  double length = 0;       ///< m, along the way
  double narrowest = 0;    ///< m, least distance of the way to a wall
};

/// The cheapest way over free cells (MATH 19.6).
Route find_route(const KnownMap& known, const Topology& topology, const Vec2& from, const Vec2& to,
                 const RouteOptions& options = {});

/// From room to room by the graph alone, without any cells: the shortest sum of straight lines from
/// door to door, from the first room's widest spot to the last one's. Empty where there is none.
struct GraphRoute {
  std::vector<int> rooms, doors;
  double length = 0;  ///< m, of the straight lines
};
GraphRoute graph_route(const Topology& topology, int from, int to);

}  // namespace majak::map
