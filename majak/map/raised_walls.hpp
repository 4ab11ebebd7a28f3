// SPDX-License-Identifier: Apache-2.0
// Raised walls: what one horizontal laser knows of a building, made a solid. Walls of the segment
// map stand upright on the free floor of the occupancy grid; how high they are no such laser sees,
// so an option says it.
#pragma once

#include "majak/core/site.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/map/solid.hpp"

namespace majak::map {

struct RaiseOptions {
  double height = 2.5;      ///< m, of all walls
  bool floor = true;        ///< under all that is free
  double floor_cell = 0.2;  ///< m, the floor's outline is that coarse
};

inline void describe(OptionFields& fields, RaiseOptions& o) {
  fields.add("raise.height", o.height, {"m", "of all walls", 0.01, 1000});
  fields.add("raise.floor", o.floor, {"", "a floor under all that is free"});
  fields.add("raise.floor_cell", o.floor_cell, {"m", "the floor's outline is so coarse", 0.05, 10});
}

/// Parts "walls" and "floor", those that are not empty: a rectangle a wall, seen from where it was
/// seen, and rectangles of free floor. `free`: no floor beyond what it calls free.
/// Throws Error when an option is out of its range.
Solid raise_walls(const std::vector<Segment>& walls, const KnownMap& free,
                  const RaiseOptions& options = {});

Solid raise_walls(const Site& site, const RaiseOptions& options = {},
                  const SegmentMapOptions& segments = {}, const OccupancyGridOptions& grid = {},
                  Threads threads = {});

}  // namespace majak::map
