// SPDX-License-Identifier: Apache-2.0
#include "majak/map/occupancy_grid.hpp"

#include <cmath>

namespace majak::map {

void OccupancyGrid::set_log_odds(int ix, int iy, float log_odds) {
  tiles_(ix, iy) = static_cast<std::int16_t>(std::lround(log_odds / kUnit));
}

double OccupancyGrid::known_area() const {
  std::ptrdiff_t cells = 0;
  tiles_.for_each([&](int, int, std::int16_t value) { cells += value != kUnknown; });
  return static_cast<double>(cells) * resolution_ * resolution_;
}

OccupancyGrid coarser(const OccupancyGrid& grid, int factor) {
  OccupancyGrid coarse(grid.resolution() * factor);
  const auto down = [factor](int i) { return (i >= 0 ? i : i - factor + 1) / factor; };
  grid.for_each([&](int ix, int iy, float log_odds) {
    const int x = down(ix), y = down(iy);
    if (!coarse.known(x, y) || log_odds > coarse.log_odds(x, y))
      coarse.set_log_odds(x, y, log_odds);
  });
  return coarse;
}

}  // namespace majak::map
