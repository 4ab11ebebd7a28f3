// SPDX-License-Identifier: Apache-2.0
// Obstacle inflation: a robot has a size, a planner wants a point. A cell is blocked where the
// robot, its point in the middle of the cell, would meet an obstacle; then the point goes wherever
// it is not blocked. Exact, and as quick for large robots as for small ones where they are round.
//
//   inflate(known_map(grid), Disc{0.3}, {.meaning = InflationMeaning::touch});
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/pose2.hpp"
#include "majak/map/distance_transform.hpp"
#include "majak/map/known_map.hpp"

namespace majak::map {

/// The robot without its border: what it only just touches it does not meet.
struct Disc {
  double radius = 0;  ///< m, 0 or more, about the robot's point
};
struct Polygon {
  /// m, robot frame, in order, three or more; sides do not cross. Need not be convex, and the
  /// robot's point may be anywhere.
  std::vector<Vec2> corners;
  /// rad, of the robot against the map's x; empty: it may turn as it likes, which is the disc about
  /// its point through the farthest corner.
  std::optional<double> heading{};
};
using Footprint = std::variant<Disc, Polygon>;

/// Which part of an obstacle's cell the robot may not meet. An obstacle's own cell is blocked in
/// either meaning, whatever the footprint.
enum class InflationMeaning : std::uint8_t {
  centre,  ///< its middle: where the middle is nearer than the radius, or inside the polygon
  touch,   ///< any of it: where the square is nearer than the radius, or shares area with the
           ///< polygon
};

struct InflationOptions {
  InflationMeaning meaning = InflationMeaning::touch;
  /// Unknown cells are obstacles, and so is all that lies outside the map; else neither is.
  bool unknown_blocks = false;
};

inline void describe(OptionFields& fields, InflationOptions& o) {
  fields.add("inflation.unknown_blocks", o.unknown_blocks,
             {"", "unknown cells are obstacles, and what lies outside the map"});
}

/// Cells blocked by `obstacles`; outside the grid there are none. Sizes that differ by less than
/// 1e-9 of a cell, or of a disc's radius by 1e-12 of it, are the same. Throws Error when footprint,
/// resolution (m) or mask make no sense, or a side of the grid is longer than 32767 cells.
CellMask inflate(const CellMask& obstacles, double resolution, const Footprint& footprint,
                 InflationMeaning meaning, Threads threads = {});

CellMask inflate(const KnownMap& map, const Footprint& footprint,
                 const InflationOptions& options = {}, Threads threads = {});

}  // namespace majak::map
