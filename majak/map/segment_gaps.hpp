// SPDX-License-Identifier: Apache-2.0
// A wall that was seen in parts may have been joined over a window or a door: what beams mostly
// went through is taken out again.
#pragma once

#include <vector>

#include "majak/map/occupancy_grid.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

/// Is a cell at p (m, map frame), or one of its eight neighbours, occupied?
bool beside_occupied(const OccupancyGrid& grid, const Vec2& p);

/// The segments without stretches of `longest_gap` (m) or more whose cells are free and beside no
/// occupied one; unknown cells are no gap. Parts shorter than `min_length` (m) are left out. New
/// ends are as sure as a cell is small.
std::vector<Segment> without_gaps(const std::vector<Segment>& segments, const OccupancyGrid& grid,
                                  double longest_gap, double min_length);

}  // namespace majak::map
