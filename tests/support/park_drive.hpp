// SPDX-License-Identifier: Apache-2.0
// A short drive by car through the simulated park, with satellites: some 60 s.
#pragma once

#include <vector>

#include "majak/sim/park.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::test {

inline const sim::World& the_park() {
  static const sim::World world(sim::park());
  return world;
}

inline std::vector<Vec2> park_trunks() {
  std::vector<Vec2> trunks;
  for (const sim::Disc& disc : the_park().scene().discs) trunks.push_back(disc.centre);
  return trunks;
}

inline constexpr double kParkWheelbase = 2.7;  // m

/// With the truth of each scan; bursts of fixes of some 6 s every 14 s.
inline std::vector<Event> park_drive(int seed = 1) {
  sim::SimulationOptions options;
  sim::make_car(options);
  options.seed = seed;
  options.beams = 361, options.scan_rate = 2.5;
  options.robot.reports_steering = true;
  options.robot.speed = 5;
  options.satellites.on = true;
  options.satellites.burst = 6, options.satellites.outage = 8;
  sim::Path path = sim::plan_tour(the_park());
  path.points.resize(static_cast<std::size_t>(300 / sim::kPathStep));
  return sim::simulate(the_park(), path, options);
}

}  // namespace majak::test
