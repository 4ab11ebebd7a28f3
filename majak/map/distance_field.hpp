// SPDX-License-Identifier: Apache-2.0
// DistanceField: how far the nearest wall that a beam can see is, for every cell of a known map;
// exact (map/distance_transform). Rays are cast by it: from a cell whose nearest wall is 2 m off a
// ray may step 2 m at once.
#pragma once

#include <vector>

#include "majak/map/known_map.hpp"

namespace majak::map {

class DistanceField {
 public:
  /// Distances beyond `reach` (m) are not told apart.
  explicit DistanceField(const KnownMap& map, double reach = 5.0);

  /// m, from the cell's centre to that of the nearest occupied cell that can be seen, at most
  /// reach(); reach() outside the map. Seen can be what lies next to a free cell.
  float at(int ix, int iy) const {
    return ix >= 0 && iy >= 0 && ix < width_ && iy < height_
               ? distances_[static_cast<std::size_t>(iy) * static_cast<std::size_t>(width_) +
                            static_cast<std::size_t>(ix)]
               : reach_;
  }
  float at(const Vec2& p_map) const {
    return at(static_cast<int>(std::floor((p_map.x() - x0_) / resolution_)),
              static_cast<int>(std::floor((p_map.y() - y0_) / resolution_)));
  }
  /// Row by row, from low y.
  const std::vector<float>& distances() const { return distances_; }
  float reach() const { return reach_; }

  /// m along `direction` (unit, map frame) from p_map to the first occupied cell; infinite where
  /// there is none within max_range. 0 in one.
  double cast(const Vec2& p_map, const Vec2& direction, double max_range) const;

 private:
  double resolution_, x0_, y0_;
  int width_, height_;
  float reach_;
  std::vector<float> distances_;
};

}  // namespace majak::map
