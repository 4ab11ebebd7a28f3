// SPDX-License-Identifier: Apache-2.0
// Cells over time: what stays, what passed, doors with their states, and the map as it was.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/draw/report_page.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/io/map_files.hpp"

namespace majak::draw {
namespace {

constexpr Colour kColours[] = {ink::light, ink::white, ink::black, ink::sky, ink::red};

const char* name_of(map::DoorState state) {
  return state == map::DoorState::open     ? "open"
         : state == map::DoorState::closed ? "closed"
                                           : "unknown";
}

Colour colour_of(map::DoorState state) {
  return state == map::DoorState::open     ? ink::green
         : state == map::DoorState::closed ? ink::purple
                                           : ink::grey;
}

/// m^2, by kind.
std::array<double, 5> areas(const map::DynamicsMap& dynamics) {
  std::array<double, 5> area{};
  const map::CellBox box = dynamics.bounds();
  for (int y = box.y0; y < box.y0 + box.height; ++y)
    for (int x = box.x0; x < box.x0 + box.width; ++x)
      area[static_cast<std::size_t>(dynamics.kind(x, y))] +=
          dynamics.resolution() * dynamics.resolution();
  return area;
}

std::string door_table(const std::vector<map::DoorHistory>& doors, Time begin) {
  std::string text = "door,x0_m,y0_m,x1_m,y1_m,from_s,state\n";
  for (std::size_t i = 0; i < doors.size(); ++i)
    for (const map::DoorStay& stay : doors[i].stays)
      text += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.3f},{:.2f},{}\n", i + 1, doors[i].where.a.x(),
                          doors[i].where.a.y(), doors[i].where.b.x(), doors[i].where.b.y(),
                          to_seconds(stay.begin - begin), name_of(stay.state));
  return text;
}

/// The state stated last before `time` (s); at the end for less than 0.
map::DoorState state_at(const map::DoorHistory& door, Time begin, double time) {
  map::DoorState state = map::DoorState::unknown;
  for (const map::DoorStay& stay : door.stays)
    if (time < 0 || to_seconds(stay.begin - begin) <= time) state = stay.state;
  return state;
}

void add_doors(std::vector<Mark>& marks, const std::vector<map::DoorHistory>& doors, Time begin,
               double time) {
  for (std::size_t i = 0; i < doors.size(); ++i) {
    const Colour colour = colour_of(state_at(doors[i], begin, time));
    const map::DoorSpan& d = doors[i].where;
    marks.emplace_back(Polyline{{point(d.a), point(d.b)}, {colour, 3}});
    marks.emplace_back(
        Label{.at = point((d.a + d.b) / 2), .text = std::to_string(i + 1), .dx = 4, .dy = 4});
  }
}

}  // namespace

FacePage dynamics_face(const Site& site, const FaceOptions& o) {
  map::DynamicsOptions options = o.dynamics;
  options.grid = o.grid;
  const map::DynamicsMap dynamics = map::build_dynamics(site, options, o.threads);
  const auto doors = map::doors_that_moved(site, dynamics, o.doors);
  const double time = o.map_at.time;
  const auto area = areas(dynamics);
  FacePage page;
  std::vector<Mark> marks;
  std::vector<LegendEntry> legend;
  if (time < 0) {
    page.lead = fmt::format(
        "Black stayed occupied and white stayed free; blue was occupied for less than {} s "
        "(people, and cells of walls that errors of poses touched), red stood long and was free "
        "long. Doors are numbered as in dynamics_doors.csv, in their last state. A door that was "
        "never seen in both states is not among them.",
        number(options.stay));
    if (auto picture = cells_picture(dynamics.bounds(), dynamics.resolution(), [&](int x, int y) {
          return kColours[static_cast<std::size_t>(dynamics.kind(x, y))];
        }))
      marks.emplace_back(std::move(*picture));
    legend = {{"passed", {}, ink::sky}, {"switching", {}, ink::red}};
  } else {
    page.lead = fmt::format("The map as it was {} s after the first scan, {}.", number(time),
                            o.map_at.hindsight ? "as is known by now" : "as was believed then");
    const map::OccupancyGrid grid = map::map_at(dynamics, time, o.map_at.hindsight);
    if (grid.known_area() > 0) marks.emplace_back(grid_picture(grid));
    const io::MapFrame frame = io::frame_of(grid);
    page.files = {{"map_at.pgm", io::pgm_text(io::trinary_map(grid, frame))},
                  {"map_at.yaml", io::map_yaml(frame, "map_at.pgm")}};
  }
  add_doors(marks, doors, dynamics.begin(), time);
  for (const auto state : {map::DoorState::open, map::DoorState::closed})
    if (!doors.empty())
      legend.push_back({fmt::format("door, {}", name_of(state)), Pen{colour_of(state), 3}});
  page.figure = map_sheet("Cells over time", std::move(marks), std::move(legend));
  page.figures = {{"duration_s", dynamics.duration()},
                  {"free_m2", area[1]},
                  {"occupied_m2", area[2]},
                  {"passed_m2", area[3]},
                  {"switching_m2", area[4]},
                  {"doors", static_cast<double>(doors.size())}};
  page.files.push_back({"dynamics_doors.csv", door_table(doors, dynamics.begin())});
  page.bytes = dynamics.bytes();
  return page;
}

}  // namespace majak::draw
