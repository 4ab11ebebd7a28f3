// SPDX-License-Identifier: Apache-2.0
#include "majak/map/distance_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "majak/map/distance_transform.hpp"

namespace majak::map {
namespace {

// A floor lies next to it. What has none no beam ever met: the inside and the far side of a drawn
// wall.
bool can_be_seen(const KnownMap& map, int ix, int iy) {
  if (map.at(ix, iy) != CellState::occupied) return false;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (map.at(ix + dx, iy + dy) == CellState::free) return true;
  return false;
}

}  // namespace

DistanceField::DistanceField(const KnownMap& map, double reach)
    : resolution_(map.resolution),
      x0_(map.x0),
      y0_(map.y0),
      width_(map.width),
      height_(map.height),
      reach_(static_cast<float>(reach)),
      distances_(map.cells.size()) {
  CellMask walls{width_, height_, std::vector<std::uint8_t>(map.cells.size())};
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) walls.cells[walls.index(x, y)] = can_be_seen(map, x, y);
  const auto squares = squared_distances(walls);
  std::transform(squares.begin(), squares.end(), distances_.begin(), [&](std::int32_t square) {
    const double metres = std::sqrt(static_cast<float>(square)) * resolution_;
    return square == kNoneMarked ? reach_ : std::min(reach_, static_cast<float>(metres));
  });
}

double DistanceField::cast(const Vec2& p_map, const Vec2& direction, double max_range) const {
  // The nearest occupied centre is d off this cell's centre: a disc of d less half a cell's
  // diagonal at either end is empty.
  const double slack = std::sqrt(2.0) * resolution_, least = 0.2 * resolution_;
  for (double way = 0; way <= max_range;) {
    const double d = at(p_map + way * direction);
    if (d <= 0) return way;
    way += std::max(least, d - slack);
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace majak::map
