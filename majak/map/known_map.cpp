// SPDX-License-Identifier: Apache-2.0
#include "majak/map/known_map.hpp"

#include <algorithm>

namespace majak::map {
namespace {

constexpr double kOccupied = 0.619;  // log-odds of 0.65

CellState state_of(std::int16_t stored) {
  if (stored == OccupancyGrid::kUnknown) return CellState::unknown;
  const double log_odds = stored * OccupancyGrid::kUnit;
  return log_odds >= kOccupied ? CellState::occupied
         : log_odds < 0        ? CellState::free
                               : CellState::unknown;
}

}  // namespace

std::vector<std::uint32_t> KnownMap::all(CellState state) const {
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i] == state) found.push_back(static_cast<std::uint32_t>(i));
  return found;
}

double KnownMap::area(CellState state) const {
  return static_cast<double>(std::count(cells.begin(), cells.end(), state)) * resolution *
         resolution;
}

KnownMap known_map(const OccupancyGrid& grid) {
  const CellBox box = grid.bounds();
  KnownMap map;
  map.resolution = grid.resolution();
  map.width = box.width + 2;
  map.height = box.height + 2;
  map.x0 = (box.x0 - 1) * map.resolution;
  map.y0 = (box.y0 - 1) * map.resolution;
  map.cells.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height),
                   CellState::unknown);
  std::vector<std::int16_t> row(static_cast<std::size_t>(box.width));
  for (int iy = 0; iy < box.height; ++iy) {
    grid.copy_row(box.x0, box.y0 + iy, box.width, row.data());
    std::transform(row.begin(), row.end(),
                   map.cells.begin() + static_cast<std::ptrdiff_t>(map.index(1, iy + 1)), state_of);
  }
  return map;
}

}  // namespace majak::map
