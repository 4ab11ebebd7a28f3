// SPDX-License-Identifier: Apache-2.0
// The face of rooms and doors.
#include <algorithm>

#include "majak/draw/face.hpp"
#include "majak/draw/topology_figure.hpp"
#include "majak/io/topology_files.hpp"

namespace majak::draw {
namespace {

std::size_t bytes_of(const map::Topology& t) {
  std::size_t bytes = t.labels.size() * sizeof(t.labels[0]) +
                      t.doors.size() * sizeof(map::Doorway) +
                      t.furniture.size() * sizeof(map::Furniture);
  for (const map::Room& room : t.rooms)
    bytes += sizeof(room) + room.cells.size() * sizeof(room.cells[0]) +
             room.outline.size() * sizeof(Vec2);
  return bytes;
}

}  // namespace

FacePage rooms_face(const Site& site, const FaceOptions& o) {
  const map::KnownMap known = map::known_map(map::build_occupancy_grid(site, o.grid, o.threads));
  const map::Topology topology = map::build_topology(known, o.rooms, o.threads);
  const std::vector<std::string> names = map::room_names(topology, o.labels);
  FacePage page;
  page.lead =
      "Rooms and corridors are what hangs together when doors are shut; doors are gaps in thin, "
      "straight walls. A door that was closed, or whose wall is hidden by furniture on both sides, "
      "is not found, and its two rooms are apart or one.";
  page.bytes = bytes_of(topology);
  const auto count = [&](map::RoomKind kind) {
    return static_cast<double>(std::count_if(topology.rooms.begin(), topology.rooms.end(),
                                             [&](const map::Room& r) { return r.kind == kind; }));
  };
  const auto openings = std::count_if(topology.doors.begin(), topology.doors.end(),
                                      [](const map::Doorway& d) { return d.opening; });
  double area = 0;
  for (const map::Room& room : topology.rooms) area += room.area;
  page.figures = {{"rooms", count(map::RoomKind::room)},
                  {"corridors", count(map::RoomKind::corridor)},
                  {"halls", count(map::RoomKind::hall)},
                  {"doors", static_cast<double>(topology.doors.size()) - double(openings)},
                  {"openings", static_cast<double>(openings)},
                  {"furniture", static_cast<double>(topology.furniture.size())},
                  {"area_m2", area}};
  page.figure = topology_figure(known, topology, names);
  page.files = {{"rooms.graphml", io::topology_graphml(topology, names)},
                {"rooms.json", io::topology_json(topology, names)}};
  return page;
}

}  // namespace majak::draw
