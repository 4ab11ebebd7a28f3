// SPDX-License-Identifier: Apache-2.0
// KnownMap: a place that is known already, as localization uses it: which cells are occupied, which
// are free. Made from a run's own grid, or read from the map files of other programs.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::map {

enum class CellState : std::uint8_t { unknown, free, occupied };

struct KnownMap {
  double resolution = 0.05;      ///< m, side of a cell
  double x0 = 0, y0 = 0;         ///< m, map frame: the corner of cell (0, 0) with the least x and y
  int width = 0, height = 0;     ///< cells
  std::vector<CellState> cells;  ///< row by row, from low y

  int column(double x) const { return static_cast<int>(std::floor((x - x0) / resolution)); }
  int row(double y) const { return static_cast<int>(std::floor((y - y0) / resolution)); }
  bool inside(int ix, int iy) const { return ix >= 0 && iy >= 0 && ix < width && iy < height; }
  std::size_t index(int ix, int iy) const {
    return static_cast<std::size_t>(iy) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(ix);
  }
  /// Unknown outside.
  CellState at(int ix, int iy) const {
    return inside(ix, iy) ? cells[index(ix, iy)] : CellState::unknown;
  }
  CellState at(const Vec2& p_map) const { return at(column(p_map.x()), row(p_map.y())); }
  Vec2 centre(int ix, int iy) const {
    return {x0 + (ix + 0.5) * resolution, y0 + (iy + 0.5) * resolution};
  }
  /// Numbers of all cells in that state, in order.
  std::vector<std::uint32_t> all(CellState state) const;
  /// m^2
  double area(CellState state) const;
};

/// Occupied from a probability of 0.65 on, free below 0.5; one margin cell of unknown around.
KnownMap known_map(const OccupancyGrid& grid);

}  // namespace majak::map
