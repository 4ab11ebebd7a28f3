// SPDX-License-Identifier: Apache-2.0
#include "majak/map/raised_walls.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/map/rectangles.hpp"

namespace majak::map {
namespace {

constexpr Rgb kWall{222, 214, 196}, kFloor{150, 158, 166};

void check(const RaiseOptions& o) {
  if (!(o.height > 0 && std::isfinite(o.height)) || !(o.floor_cell >= 0.01 && o.floor_cell <= 10))
    throw Error("raise: height must be more than 0 m and floor_cell 0.01 ... 10 m");
}

SolidPart walls_of(const std::vector<Segment>& walls, double height) {
  SolidPart part{.name = "walls"};
  const Eigen::Vector3d up{0, 0, height};
  for (const Segment& wall : walls) {
    // Seen from the left of the way from a to b: a is at the right hand.
    const Vec2 along = wall.a - wall.b;
    add_rectangle(part, {wall.b.x(), wall.b.y(), 0}, {along.x(), along.y(), 0}, up, kWall);
  }
  return part;
}

/// `times` x `times` cells as one, free where more than half of them are.
CellMask coarse_free(const KnownMap& map, int times) {
  CellMask coarse{(map.width + times - 1) / times, (map.height + times - 1) / times, {}};
  std::vector<int> free(static_cast<std::size_t>(coarse.width) * coarse.height);
  for (const std::uint32_t cell : map.all(CellState::free)) {
    const auto width = static_cast<std::uint32_t>(map.width);
    const int x = static_cast<int>(cell % width), y = static_cast<int>(cell / width);
    ++free[coarse.index(x / times, y / times)];
  }
  coarse.cells.resize(free.size());
  std::transform(free.begin(), free.end(), coarse.cells.begin(),
                 [&](int n) { return static_cast<std::uint8_t>(2 * n > times * times); });
  return coarse;
}

SolidPart floor_of(const KnownMap& map, double cell) {
  SolidPart part{.name = "floor"};
  const int times = std::max(1, static_cast<int>(std::lround(cell / map.resolution)));
  const double side = times * map.resolution;
  for (const CellBox& box : rectangles_of(coarse_free(map, times)))
    add_rectangle(part, {map.x0 + box.x0 * side, map.y0 + box.y0 * side, 0},
                  {box.width * side, 0, 0}, {0, box.height * side, 0}, kFloor);
  return part;
}

}  // namespace

Solid raise_walls(const std::vector<Segment>& walls, const KnownMap& free,
                  const RaiseOptions& options) {
  check(options);
  Solid solid;
  if (!walls.empty()) solid.parts.push_back(walls_of(walls, options.height));
  if (!options.floor) return solid;
  SolidPart floor = floor_of(free, options.floor_cell);
  if (!floor.cloud()) solid.parts.push_back(std::move(floor));
  return solid;
}

Solid raise_walls(const Site& site, const RaiseOptions& options, const SegmentMapOptions& segments,
                  const OccupancyGridOptions& grid, Threads threads) {
  check(options);
  const KnownMap free =
      options.floor ? known_map(build_occupancy_grid(site, grid, threads)) : KnownMap{};
  return raise_walls(build_segments(site, segments).walls(), free, options);
}

}  // namespace majak::map
