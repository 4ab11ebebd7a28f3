// SPDX-License-Identifier: Apache-2.0
// Rooms and doors that were found against those of a generated building.
#pragma once

#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/map/topology.hpp"
#include "majak/sim/floor_plans.hpp"

namespace majak::eval {

struct RoomScore {
  std::vector<double>
      overlap;  ///< of every true place with the room that fits it best: IoU, 0 ... 1
  int true_doors = 0, doors_found = 0;  ///< true ones with one found within kDoorReach
  int doors = 0, false_doors = 0;       ///< found ones without a true door or opening so near
  int rooms = 0;                        ///< found
  std::vector<Vec2> missed, invented;   ///< doors, world frame

  double mean_overlap() const;
};

inline constexpr double kDoorReach = 0.5;  ///< m, centre to centre

/// Over the cells of the world's own map whose middle is on the floor of a place and truly free, so
/// that walls, passages and furniture belong to nobody. Openings are neither asked for nor wrong.
RoomScore score_rooms(const map::Topology& found, const Pose2& T_world_map,
                      const sim::GeneratedBuilding& truth);

}  // namespace majak::eval
