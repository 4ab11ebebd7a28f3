// SPDX-License-Identifier: Apache-2.0
// Office buildings made up from a number, with the truth about their rooms and doors.
//
//   const GeneratedBuilding office = generated_building(1);
//   plan_tour(World(office.scene));   // goes into every room
//   office.place_at({3, 4});          // the number of the room there, or -1
#pragma once

#include <cstdint>
#include <vector>

#include "majak/sim/world.hpp"

namespace majak::sim {

enum class TruePlaceKind : std::uint8_t { room, corridor, hall };

/// Axes-parallel, world frame, m.
struct Rectangle {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
  bool contains(const Vec2& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
};

struct TrueDoor {
  Vec2 centre;           ///< world frame, m, in the middle of the wall
  Vec2 along;            ///< unit, from jamb to jamb
  double width = 0;      ///< m, clear
  int from = 0, to = 0;  ///< places
  bool opening = false;  ///< a wide gap without a door, as halls have them
};

struct GeneratedBuilding {
  Scene scene;
  std::vector<TruePlaceKind> places;  ///< by number
  std::vector<TrueDoor> doors;
  double wall = 0.15;  ///< m, thickness

  // The plan: a grid of uneven lines in the middle of the walls.
  std::vector<double> xs, ys;  ///< m, ascending
  std::vector<int> owner;      ///< of the field between lines, row by row; -1 is solid

  /// Number of the place whose floor, furniture included, is at p; -1 in walls, in the passages
  /// through them and outside.
  int place_at(const Vec2& p) const;
};

/// Equal seeds give equal buildings. 20 to 46 m long; one of five kinds of corridor (straight, L,
/// T, ring, ring around a hall); doors of 0.72 to 1.2 m, double doors to 1.9 m, leaves that stand
/// open, niches, shafts, open-plan halls, pillars, desks, shelves, tables on legs, chairs.
GeneratedBuilding generated_building(std::uint64_t seed);

}  // namespace majak::sim
