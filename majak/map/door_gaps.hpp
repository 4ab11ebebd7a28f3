// SPDX-License-Identifier: Apache-2.0
// Gaps in thin walls: where doors are. A gap is a straight line over free cells whose both ends
// meet a wall that goes on along the line and is thin across it.
#pragma once

#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/map/distance_transform.hpp"
#include "majak/map/topology.hpp"

namespace majak::map {

struct DoorGap {
  int ix = 0, iy = 0;    ///< the cell in its middle
  int dx0 = 0, dy0 = 0;  ///< from there to the last free cell at one end
  int dx1 = 0, dy1 = 0;  ///< and at the other
  double angle = 0;      ///< rad, 0 ... pi, of the line
  double width = 0;      ///< m
  double score = 0;      ///< 0 ... 1: how much of both jambs is thin wall, less for wide gaps
};

/// In `walls`, all that is no floor; `surfaces` are those of its cells in which something was seen.
/// Cells have sides of `resolution` m. The best gaps first; none overlaps a better one.
std::vector<DoorGap> find_door_gaps(const CellMask& walls, const CellMask& surfaces,
                                    double resolution, const TopologyOptions& options,
                                    Threads threads = {});

}  // namespace majak::map
