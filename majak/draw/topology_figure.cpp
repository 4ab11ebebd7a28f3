// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/topology_figure.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "majak/draw/face_figure.hpp"

namespace majak::draw {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

// Light, so that walls and words stay readable.
constexpr std::array<Rgb, 9> kRooms{{{178, 212, 240},
                                     {250, 214, 165},
                                     {190, 228, 190},
                                     {240, 190, 190},
                                     {214, 198, 236},
                                     {245, 240, 170},
                                     {176, 228, 224},
                                     {236, 200, 220},
                                     {214, 220, 190}}};
constexpr Rgb kCorridor{226, 230, 235}, kUnknown{255, 255, 255}, kFree{244, 244, 244},
    kWall{31, 35, 40};

Point at(const Vec2& p) { return {p.x(), p.y()}; }

Rgb colour_of(const map::Topology& t, map::CellState state, int room) {
  if (state == map::CellState::occupied) return kWall;
  if (room < 0) return state == map::CellState::free ? kFree : kUnknown;
  return t.rooms[room].kind == map::RoomKind::corridor ? kCorridor : kRooms[room % kRooms.size()];
}

void add_doors(std::vector<Mark>& marks, const map::Topology& t) {
  for (const map::Doorway& d : t.doors) {
    const Vec2 half = 0.5 * d.width * d.along;
    marks.emplace_back(Polyline{{at(d.centre - half), at(d.centre + half)},
                                {d.opening ? ink::orange : ink::red, 4}});
  }
}

/// From each door to the widest spots of its two rooms.
void add_graph(std::vector<Mark>& marks, const map::Topology& t) {
  Dots rooms{{}, 4, ink::blue};
  for (const map::Room& room : t.rooms) rooms.at.push_back(at(room.widest_spot));
  for (const map::Doorway& d : t.doors)
    marks.emplace_back(
        Polyline{{at(t.rooms[d.from].widest_spot), at(d.centre), at(t.rooms[d.to].widest_spot)},
                 {ink::blue.faint(0.6), 1.4}});
  marks.emplace_back(std::move(rooms));
}

void add_route(std::vector<Mark>& marks, const map::Route& route) {
  Polyline way{{}, {ink::blue, 3}};
  for (const Vec2& p : route.way) way.points.push_back(at(p));
  if (way.points.empty()) return;
  Dots ends{{way.points.front(), way.points.back()}, 5, ink::blue};
  marks.emplace_back(std::move(way));
  marks.emplace_back(std::move(ends));
}

}  // namespace

io::Image topology_image(const map::KnownMap& known, const map::Topology& t) {
  io::Image image(known.width, known.height, 3);
  for (int iy = 0; iy < known.height; ++iy)
    for (int ix = 0; ix < known.width; ++ix) {
      const std::size_t i = known.index(ix, iy);
      const Rgb c = colour_of(t, known.cells[i], t.labels[i]);
      std::copy(c.begin(), c.end(), image.row(known.height - 1 - iy) + 3 * ix);
    }
  return image;
}

Figure topology_figure(const map::KnownMap& known, const map::Topology& t,
                       std::span<const std::string> names, const map::Route* route) {
  std::vector<Mark> marks;
  if (known.width > 0 && known.height > 0)
    marks.emplace_back(Picture{topology_image(known, t), {known.x0, known.y0}, known.resolution});
  add_doors(marks, t);
  if (route != nullptr)
    add_route(marks, *route);
  else
    add_graph(marks, t);
  for (std::size_t i = 0; i < t.rooms.size(); ++i)
    marks.emplace_back(Label{at(t.rooms[i].widest_spot), names[i], 0, 7, Anchor::middle, 10});
  std::vector<LegendEntry> legend{{"door", Pen{ink::red, 4}}, {"opening", Pen{ink::orange, 4}}};
  legend.push_back(route != nullptr ? LegendEntry{"way", Pen{ink::blue, 3}}
                                    : LegendEntry{"graph", Pen{ink::blue.faint(0.6), 1.4}});
  return map_sheet(route != nullptr ? "Route" : "Rooms", std::move(marks), std::move(legend));
}

}  // namespace majak::draw
