// SPDX-License-Identifier: Apache-2.0
// Topology of a building: rooms and corridors, and the doors between them, from the cells of a
// known map (docs/MATH.md, section 19).
//
//   const Topology topology = build_topology(known_map(build_occupancy_grid(site)));
//   topology.rooms[topology.room_at({3, 4})].kind;
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/pose2.hpp"
#include "majak/map/known_map.hpp"

namespace majak::map {

struct TopologyOptions {
  double narrowest_door = 0.6;  ///< m, clear width
  double widest_door = 2.1;     ///< m; wider gaps are openings
  double widest_opening = 3.8;  ///< m; wider gaps do not part rooms
  double thickest_wall = 0.45;  ///< m, beside a door
  double jamb = 0.3;            ///< m of wall that are looked at beside a gap
  double leak = 0.3;            ///< m, narrower gaps are holes in walls and no passages
  double smallest_room = 1.5;   ///< m^2 of floor
  double furniture = 2.5;       ///< m, an island of at most this size is no wall
};

inline void describe(OptionFields& fields, TopologyOptions& o) {
  fields.add("rooms.narrowest_door", o.narrowest_door, {"m", "clear width", 0.2, 10});
  fields.add("rooms.widest_door", o.widest_door, {"m", "wider gaps are openings", 0.2, 10});
  fields.add("rooms.widest_opening", o.widest_opening,
             {"m", "wider gaps do not part rooms", 0.2, 20});
  fields.add("rooms.thickest_wall", o.thickest_wall, {"m", "beside a door", 0.05, 2});
  fields.add("rooms.jamb", o.jamb, {"m", "of wall that are looked at beside a gap", 0.1, 2});
  fields.add("rooms.leak", o.leak, {"m", "narrower gaps are holes in walls", 0, 2});
  fields.add("rooms.smallest_room", o.smallest_room, {"m^2", "of floor", 0.1, 100});
  fields.add("rooms.furniture", o.furniture,
             {"m", "an island of at most this size is no wall", 0, 20});
}

enum class RoomKind : std::uint8_t { room, corridor, hall };
const char* name_of(RoomKind kind);

struct Room {
  RoomKind kind = RoomKind::room;
  double area = 0;                   ///< m^2 of floor, what stands on it included
  Vec2 centroid = Vec2::Zero();      ///< m, map frame; may lie outside of it (an L)
  Vec2 widest_spot = Vec2::Zero();   ///< m, map frame: the middle of the largest circle
  double clearance = 0;              ///< m, its radius
  double width = 0;                  ///< m: four times the mean distance to walls (MATH 19.4)
  int doors = 0;                     ///< doors and openings
  std::vector<Vec2> outline;         ///< map frame, counter-clockwise, along cells' sides
  std::vector<std::uint32_t> cells;  ///< numbers of its cells, ascending
};

struct Doorway {
  Vec2 centre = Vec2::Zero();  ///< m, map frame
  Vec2 along = Vec2::UnitX();  ///< unit, from jamb to jamb
  double width = 0;            ///< m, clear
  int from = 0, to = 0;        ///< rooms; from < to
  bool opening = false;        ///< too wide for a door
};

/// Something that stands on the floor of a room and touches no wall.
struct Furniture {
  Vec2 centre = Vec2::Zero();  ///< m, map frame
  Vec2 size = Vec2::Zero();    ///< m, of its box along the map's axes
  int room = -1;
};

struct Topology {
  double resolution = 0.05;  ///< m, side of a cell; cells are those of the known map
  double x0 = 0, y0 = 0;     ///< m, map frame
  int width = 0, height = 0;
  std::vector<std::int32_t> labels;  ///< the room of every cell, -1 for none
  std::vector<Room> rooms;
  std::vector<Doorway> doors;
  std::vector<Furniture> furniture;

  /// -1 for none.
  int room_at(const Vec2& p_map) const;
  Vec2 centre(std::uint32_t cell) const {
    const auto w = static_cast<std::uint32_t>(width);
    return {x0 + (cell % w + 0.5) * resolution, y0 + (cell / w + 0.5) * resolution};
  }
};

/// The result does not depend on the number of threads. Throws Error when an option is out of
/// range.
Topology build_topology(const KnownMap& known, const TopologyOptions& options = {},
                        Threads threads = {});

}  // namespace majak::map
