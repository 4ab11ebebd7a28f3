// SPDX-License-Identifier: Apache-2.0
// All returns of a run as points in the map, found by place. Sorted by cell, so that memory follows
// the points and not the area.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::eval {

struct MapPoint {
  float x = 0, y = 0;            ///< m, map frame
  float view_x = 0, view_y = 0;  ///< unit vector from the laser to the point
  std::int32_t scan = 0;         ///< index into Site::scans
};

class PointIndex {
 public:
  PointIndex(std::vector<MapPoint> points, double cell);

  const std::vector<MapPoint>& points() const { return points_; }

  /// visit(point) for each point at most `radius` from `centre`, in a fixed order.
  template <class Visit>
  void for_each_near(const Vec2& centre, double radius, Visit visit) const {
    const auto cell = [&](double v) { return static_cast<std::int32_t>(std::floor(v / cell_)); };
    const std::int32_t x_low = cell(centre.x() - radius), x_high = cell(centre.x() + radius);
    const std::int32_t y_high = cell(centre.y() + radius);
    for (std::int32_t y = cell(centre.y() - radius); y <= y_high; ++y) {
      for (std::size_t i = first_at({y, x_low}); i < cells_.size(); ++i) {
        if (cells_[i].y != y || cells_[i].x > x_high) break;
        const double dx = points_[i].x - centre.x(), dy = points_[i].y - centre.y();
        if (dx * dx + dy * dy <= radius * radius) visit(points_[i]);
      }
    }
  }

 private:
  struct Cell {
    std::int32_t y, x;
    auto operator<=>(const Cell&) const = default;
  };
  /// The first point whose cell is not before this one.
  std::size_t first_at(Cell cell) const;

  double cell_;
  std::vector<MapPoint> points_;  ///< by cell, rows of cells one after another
  std::vector<Cell> cells_;       ///< of each point
};

}  // namespace majak::eval
