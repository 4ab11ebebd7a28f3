// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/known_map.hpp"

#include <cmath>
#include <vector>

namespace majak::sim {
namespace {

using map::CellState;

void occupy(map::KnownMap& map, const Vec2& p) {
  const int ix = map.column(p.x()), iy = map.row(p.y());
  if (map.inside(ix, iy)) map.cells[map.index(ix, iy)] = CellState::occupied;
}

/// Free are the unknown cells that are connected to the one at `p` by their sides.
void flood(map::KnownMap& map, const Vec2& p) {
  std::vector<std::pair<int, int>> open{{map.column(p.x()), map.row(p.y())}};
  while (!open.empty()) {
    const auto [ix, iy] = open.back();
    open.pop_back();
    if (!map.inside(ix, iy) || map.at(ix, iy) != CellState::unknown) continue;
    map.cells[map.index(ix, iy)] = CellState::free;
    for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}})
      open.emplace_back(ix + dx, iy + dy);
  }
}

}  // namespace

map::KnownMap known_map(const World& world, double resolution) {
  constexpr int kMargin = 4;  // cells
  map::KnownMap map;
  map.resolution = resolution;
  map.x0 = world.low().x() - kMargin * resolution;
  map.y0 = world.low().y() - kMargin * resolution;
  const Vec2 size = (world.high() - world.low()) / resolution;
  map.width = static_cast<int>(std::ceil(size.x())) + 2 * kMargin;
  map.height = static_cast<int>(std::ceil(size.y())) + 2 * kMargin;
  map.cells.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height),
                   CellState::unknown);
  const double step = resolution / 4;
  for (const Segment& s : world.scene().segments) {
    const int n = static_cast<int>(std::ceil((s.b - s.a).norm() / step)) + 1;
    for (int k = 0; k <= n; ++k) occupy(map, s.a + (s.b - s.a) * (double(k) / n));
  }
  for (const Disc& d : world.scene().discs) {
    const int n = static_cast<int>(std::ceil(2 * kPi * d.radius / step)) + 1;
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * kPi * k / n;
      occupy(map, d.centre + d.radius * Vec2(std::cos(angle), std::sin(angle)));
    }
  }
  flood(map, world.scene().start.translation());
  return map;
}

}  // namespace majak::sim
