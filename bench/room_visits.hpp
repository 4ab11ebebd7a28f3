// SPDX-License-Identifier: Apache-2.0
// Visits to the furnished room, each as a snapshot with poses as wrong as a localizer's.
#pragma once

#include <cstdint>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/map/known_map.hpp"
#include "majak/sim/furnished_room.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::bench {

struct VisitErrors {
  double offset = 0.015;       ///< m, each axis, one sigma; the same all through a visit
  double turn = radians(0.2);  ///< rad
  double scan_offset = 0.005;  ///< m, from scan to scan
  double scan_turn = radians(0.1);
};

inline Pose2 wrong_by(RandomStream& random, double offset, double turn) {
  return {offset * random.normal(), offset * random.normal(), turn * random.normal()};
}

/// The site that a visit leaves: what an LMS-291 saw on the round.
inline Site visit(const sim::Furnishing& furnishing, std::uint64_t seed,
                  const VisitErrors& errors = {}) {
  const sim::World world(sim::furnished_room(furnishing));
  sim::SimulationOptions options;
  options.seed = static_cast<int>(seed & 0x7fffffff);
  RandomStream random(seed, 1);
  const Pose2 offset = wrong_by(random, errors.offset, errors.turn);
  Site site;
  for (const Event& event : sim::simulate(world, sim::plan_tour(world), options)) {
    if (const auto* scan = std::get_if<Scan>(&event)) {
      site.scans.emplace_back();
      site.scans.back().scan = *scan;
    }
    if (const auto* truth = std::get_if<Truth>(&event)) {
      const Pose2 wrong = wrong_by(random, errors.scan_offset, errors.scan_turn);
      site.scans.back().estimate.T_map_robot = offset * truth->T_world_robot * wrong;
    }
  }
  return site;
}

inline map::KnownMap snapshot(const sim::Furnishing& furnishing, std::uint64_t seed,
                              const VisitErrors& errors = {}) {
  return map::known_map(map::build_occupancy_grid(visit(furnishing, seed, errors)));
}

}  // namespace majak::bench
