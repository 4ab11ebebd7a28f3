// SPDX-License-Identifier: Apache-2.0
// The border of a room as a polygon along the sides of its cells.
#pragma once

#include <vector>

#include "majak/map/topology.hpp"

namespace majak::map {

/// Map frame, counter-clockwise, without points in the middle of straight pieces; of the largest
/// border where a room has several (holes are left out).
std::vector<Vec2> region_outline(const Topology& topology, int room);

/// m^2, positive where the points go round counter-clockwise.
double polygon_area(const std::vector<Vec2>& points);

}  // namespace majak::map
