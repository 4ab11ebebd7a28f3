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

/// A corridor 2.2 m wide round a block, `length` x `width` m in all (each at least 20). Its walls
/// are smooth, but for recesses of doors on two of its four sides: to a laser of 8 m range the
/// bare sides look the same for most of their length, and only the wheels count the way. The tours
/// begin within sight of a corner and are a lap and a quarter, and two and a quarter.
Scene bare_ring(double length = 60, double width = 40);

/// A ring of 190 m with a small one in a corner of it. The tour comes to the small ring on its way,
/// goes three times round it, and only then on to where it set off: loops within a loop. Walls as
/// in bare_ring().
Scene nested_rings();

/// An empty corridor, 60 x 2.4 m: beyond 8 m from its ends a laser of 8 m range sees two parallel
/// lines and nothing else.
Scene corridor();

/// A yard of 80 x 50 m with two sheds, trees and parked things, and a figure of eight, driven both
/// ways round in arcs of 6 m radius: for a car of full size.
Scene yard();

/// "building", "ring", "large_ring", "bare_ring", "nested_rings", "corridor", "yard", "park".
std::vector<std::string> built_in_names();

/// By name (park() is in park.hpp); "office-7" is the generated building of seed 7. Throws Error
/// that lists the names.
Scene built_in(const std::string& name);

}  // namespace majak::sim
