// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/point_index.hpp"

#include <algorithm>
#include <numeric>

namespace majak::eval {

PointIndex::PointIndex(std::vector<MapPoint> points, double cell) : cell_(cell) {
  std::vector<Cell> cells;
  cells.reserve(points.size());
  for (const MapPoint& p : points) {
    cells.push_back({static_cast<std::int32_t>(std::floor(p.y / cell_)),
                     static_cast<std::int32_t>(std::floor(p.x / cell_))});
  }
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return cells[a] != cells[b] ? cells[a] < cells[b] : a < b;
  });
  points_.reserve(points.size());
  cells_.reserve(points.size());
  for (const std::uint32_t i : order) {
    points_.push_back(points[i]);
    cells_.push_back(cells[i]);
  }
}

std::size_t PointIndex::first_at(Cell cell) const {
  return static_cast<std::size_t>(std::lower_bound(cells_.begin(), cells_.end(), cell) -
                                  cells_.begin());
}

}  // namespace majak::eval
