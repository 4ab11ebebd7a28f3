// SPDX-License-Identifier: Apache-2.0
// Worlds that need no file.
#pragma once

#include <string>
#include <vector>

#include "majak/sim/world.hpp"

namespace majak::sim {

/// 40 x 25 m: corridors that form two loops, rooms with doors, pillars and furniture.
Scene building();

/// A corridor around a block of 26 x 16 m, with door recesses.
Scene ring();

/// A corridor 2.2 m wide around a block of 55.6 x 35.6 m, with uneven things along its walls. The
/// short tour is a lap and a quarter, 235 m: matching alone goes astray there.
Scene large_ring();

/// An empty corridor, 60 x 2.4 m: beyond 8 m from its ends a laser of 8 m range sees two parallel
/// lines and nothing else.
Scene corridor();

/// A yard of 80 x 50 m with two sheds, trees and parked things, and a figure of eight, driven both
/// ways round in arcs of 6 m radius: for a car of full size.
Scene yard();

/// "building", "ring", "large_ring", "corridor", "yard", "park".
std::vector<std::string> built_in_names();

/// By name (park() is in park.hpp); "office-7" is the generated building of seed 7. Throws Error
/// that lists the names.
Scene built_in(const std::string& name);

}  // namespace majak::sim
