// SPDX-License-Identifier: Apache-2.0
// A mask of cells as few rectangles.
#pragma once

#include <vector>

#include "majak/map/distance_transform.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::map {

/// Rectangles that cover each set cell once and no other, in the order of their lowest, then
/// leftmost cells: from that cell as far to the right as all is set, then as far up. Not the fewest
/// there are. Throws Error when the mask is not valid.
std::vector<CellBox> rectangles_of(CellMask mask);

}  // namespace majak::map
