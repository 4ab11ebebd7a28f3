// SPDX-License-Identifier: Apache-2.0
// A park: trunks as landmarks, hardly a wall, for a car of full size.
#pragma once

#include "majak/sim/world.hpp"

namespace majak::sim {

/// 250 x 200 m with about 200 trunks in groves, in rows along the ways and alone, always the same
/// ones; some bushes, a hut, a low wall and parked cars. No fence: most beams meet nothing. Every
/// disc is a trunk (radius 0.1 to 0.5 m) and every trunk a disc. The tour, some 1.8 km, goes round
/// nested loops and comes by most ways again, in both directions; it ends where it began, heading
/// the same way.
Scene park();

}  // namespace majak::sim
