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

/// An empty corridor, 60 x 2.4 m: beyond 8 m from its ends a laser of 8 m range sees two parallel
/// lines and nothing else.
Scene corridor();

/// "building", "ring", "corridor".
std::vector<std::string> built_in_names();

/// By name; throws Error that lists the names.
Scene built_in(const std::string& name);

}  // namespace majak::sim
