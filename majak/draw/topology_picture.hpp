// SPDX-License-Identifier: Apache-2.0
// Rooms in colours, walls black, doors red, a pixel a cell.
#pragma once

#include "majak/io/png.hpp"
#include "majak/map/topology.hpp"

namespace majak::draw {

io::Image topology_image(const map::KnownMap& known, const map::Topology& topology);

}  // namespace majak::draw
