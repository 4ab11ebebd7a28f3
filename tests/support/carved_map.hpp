// SPDX-License-Identifier: Apache-2.0
// Buildings as a mason would leave them: floors carved out of the unknown, a surface around each.
#pragma once

#include <algorithm>
#include <vector>

#include "majak/map/known_map.hpp"

namespace majak::fixture {

/// m; low x, low y, high x, high y.
struct Area {
  double x0, y0, x1, y1;
};

/// `solid` stands on the floors, and is drawn after them. One margin of 1 m.
inline map::KnownMap carved_map(const std::vector<Area>& floors,
                                const std::vector<Area>& solid = {}, double resolution = 0.05) {
  double width = 0, height = 0;
  for (const Area& a : floors) width = std::max(width, a.x1), height = std::max(height, a.y1);
  map::KnownMap map;
  map.resolution = resolution;
  map.x0 = map.y0 = -1;
  map.width = static_cast<int>((width + 2) / resolution);
  map.height = static_cast<int>((height + 2) / resolution);
  map.cells.assign(static_cast<std::size_t>(map.width) * map.height, map::CellState::unknown);
  const auto fill = [&](const Area& a, map::CellState state) {
    for (int iy = 0; iy < map.height; ++iy)
      for (int ix = 0; ix < map.width; ++ix) {
        const Vec2 p = map.centre(ix, iy);
        if (p.x() > a.x0 && p.x() < a.x1 && p.y() > a.y0 && p.y() < a.y1)
          map.cells[map.index(ix, iy)] = state;
      }
  };
  for (const Area& a : floors) fill(a, map::CellState::free);
  for (const Area& a : solid) fill(a, map::CellState::unknown);
  map::KnownMap faced = map;
  for (int iy = 0; iy < map.height; ++iy)
    for (int ix = 0; ix < map.width; ++ix) {
      if (map.at(ix, iy) == map::CellState::free) continue;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          if (map.at(ix + dx, iy + dy) == map::CellState::free)
            faced.cells[map.index(ix, iy)] = map::CellState::occupied;
    }
  return faced;
}

}  // namespace majak::fixture
