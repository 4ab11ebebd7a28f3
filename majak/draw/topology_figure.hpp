// SPDX-License-Identifier: Apache-2.0
// Rooms in colours, their names, doors, and the graph over them.
#pragma once

#include <span>
#include <string>

#include "majak/draw/figure.hpp"
#include "majak/map/room_labels.hpp"
#include "majak/map/route.hpp"
#include "majak/map/topology.hpp"

namespace majak::draw {

/// A pixel a cell, the highest row first: walls black, corridors grey, other rooms in light
/// colours.
io::Image topology_image(const map::KnownMap& known, const map::Topology& topology);

/// `names`: one a room. With the route, if there is one, instead of the graph.
Figure topology_figure(const map::KnownMap& known, const map::Topology& topology,
                       std::span<const std::string> names, const map::Route* route = nullptr);

}  // namespace majak::draw
