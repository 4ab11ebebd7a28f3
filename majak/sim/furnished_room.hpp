// SPDX-License-Identifier: Apache-2.0
// A room of 9 x 7 m that is visited again and again: walls, a cabinet, a pillar stay; a box, a bin,
// a corner desk and a bench stand elsewhere each time, and now and then one of them is not there.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/sim/tour.hpp"
#include "majak/sim/world.hpp"

namespace majak::sim {

inline constexpr std::size_t kMovables = 4;
/// "box", "bin", "desk", "bench".
const char* movable_name(std::size_t movable);

/// Where each movable stands, T_world_thing; nothing: it is not in the room.
using Furnishing = std::array<std::optional<Pose2>, kMovables>;

/// A furnishing drawn at random in which the robot can drive its round: things keep 0.3 m from each
/// other and 0.15 m from what stays. `absent`: share of things that are not there.
Furnishing furnish(std::uint64_t seed, std::uint64_t visit, double absent = 0);
/// The same, but that one of the things stands anywhere else, half a metre off at least.
Furnishing moved_one(const Furnishing& before, std::size_t movable, std::uint64_t seed);

/// The room, and a round past its four corners.
Scene furnished_room(const Furnishing& furnishing);

/// How wrong a localizer's poses are, one sigma.
struct VisitErrors {
  double offset = 0.015;       ///< m, each axis; the same all through a visit
  double turn = radians(0.2);  ///< rad
  double scan_offset = 0.005;  ///< m, from scan to scan
  double scan_turn = radians(0.1);
};

/// What an LMS-291 saw on one round, at such poses. Map frame: the world's, but for the errors.
Site visit_room(const Furnishing& furnishing, std::uint64_t seed, const VisitErrors& errors = {});

}  // namespace majak::sim
