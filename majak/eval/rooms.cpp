// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/rooms.hpp"

#include <algorithm>
#include <numeric>

#include "majak/sim/known_map.hpp"

namespace majak::eval {
namespace {

std::vector<double> overlaps(const map::Topology& found, const Pose2& T_world_map,
                             const sim::GeneratedBuilding& truth) {
  const map::KnownMap floor = sim::known_map(sim::World(truth.scene));
  const Pose2 T_map_world = T_world_map.inverse();
  const std::size_t places = truth.places.size(), rooms = found.rooms.size();
  std::vector<std::vector<double>> both(places, std::vector<double>(rooms, 0));
  std::vector<double> place_cells(places, 0), room_cells(rooms, 0);
  for (const std::uint32_t cell : floor.all(map::CellState::free)) {
    const auto w = static_cast<std::uint32_t>(floor.width);
    const Vec2 p = floor.centre(static_cast<int>(cell % w), static_cast<int>(cell / w));
    const int place = truth.place_at(p);
    if (place < 0) continue;
    ++place_cells[place];
    const int room = found.room_at(T_map_world * p);
    if (room < 0) continue;
    ++room_cells[room];
    ++both[place][room];
  }
  std::vector<double> best(places, 0);
  for (std::size_t p = 0; p < places; ++p)
    for (std::size_t r = 0; r < rooms; ++r)
      best[p] = std::max(best[p], both[p][r] / (place_cells[p] + room_cells[r] - both[p][r]));
  return best;
}

}  // namespace

double RoomScore::mean_overlap() const {
  return overlap.empty() ? 0
                         : std::accumulate(overlap.begin(), overlap.end(), 0.0) /
                               static_cast<double>(overlap.size());
}

RoomScore score_rooms(const map::Topology& found, const Pose2& T_world_map,
                      const sim::GeneratedBuilding& truth) {
  RoomScore score;
  score.overlap = overlaps(found, T_world_map, truth);
  score.rooms = static_cast<int>(found.rooms.size());
  const auto at = [&](const map::Doorway& d) { return T_world_map * d.centre; };
  for (const sim::TrueDoor& door : truth.doors) {
    if (door.opening) continue;
    ++score.true_doors;
    const bool hit = std::any_of(found.doors.begin(), found.doors.end(), [&](const auto& d) {
      return !d.opening && (at(d) - door.centre).norm() <= kDoorReach;
    });
    if (hit)
      ++score.doors_found;
    else
      score.missed.push_back(door.centre);
  }
  for (const map::Doorway& d : found.doors) {
    if (d.opening) continue;
    ++score.doors;
    const bool real = std::any_of(truth.doors.begin(), truth.doors.end(), [&](const auto& t) {
      return (at(d) - t.centre).norm() <= std::max(kDoorReach, t.opening ? t.width / 2 : 0.0);
    });
    if (real) continue;
    ++score.false_doors;
    score.invented.push_back(at(d));
  }
  return score;
}

}  // namespace majak::eval
