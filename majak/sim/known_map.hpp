// SPDX-License-Identifier: Apache-2.0
// A world as a known map: what a perfect survey of it would leave.
#pragma once

#include "majak/map/known_map.hpp"
#include "majak/sim/world.hpp"

namespace majak::sim {

/// Cells that a surface crosses are occupied, those that can be reached from the start without
/// crossing one are free, all others unknown. Map frame: the world's. resolution: m.
map::KnownMap known_map(const World& world, double resolution = 0.05);

}  // namespace majak::sim
