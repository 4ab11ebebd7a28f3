// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/topology_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace majak::draw {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

// Light, so that walls and words stay readable; neighbours in number differ much.
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
    kWall{31, 35, 40}, kDoor{200, 62, 32};

}  // namespace

io::Image topology_image(const map::KnownMap& known, const map::Topology& t) {
  io::Image image(known.width, known.height, 3);
  const auto put = [&](int ix, int iy, const Rgb& c) {
    if (!known.inside(ix, iy)) return;
    std::copy(c.begin(), c.end(), image.row(known.height - 1 - iy) + 3 * ix);
  };
  for (int iy = 0; iy < known.height; ++iy)
    for (int ix = 0; ix < known.width; ++ix) {
      const std::size_t i = known.index(ix, iy);
      const int room = t.labels[i];
      const bool corridor = room >= 0 && t.rooms[room].kind == map::RoomKind::corridor;
      put(ix, iy,
          known.cells[i] == map::CellState::occupied ? kWall
          : corridor                                 ? kCorridor
          : room >= 0                                ? kRooms[room % kRooms.size()]
          : known.cells[i] == map::CellState::free   ? kFree
                                                     : kUnknown);
    }
  for (const map::Doorway& d : t.doors) {
    if (d.opening) continue;
    for (double at = -d.width / 2; at <= d.width / 2; at += known.resolution / 2) {
      const Vec2 p = d.centre + at * d.along;
      const int ix = known.column(p.x()), iy = known.row(p.y());
      for (int dx = 0; dx < 2; ++dx)
        for (int dy = 0; dy < 2; ++dy) put(ix + dx, iy + dy, kDoor);
    }
  }
  return image;
}

}  // namespace majak::draw
