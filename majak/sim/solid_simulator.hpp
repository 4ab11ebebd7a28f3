// SPDX-License-Identifier: Apache-2.0
// A simulated robot with a second laser, out of the plane: upright, tilted down or nodding.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "majak/map/laser_mounting.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/solid_world.hpp"

namespace majak::sim {

struct SecondLaserOptions {
  map::LaserMounting mounting;
  int beams = 181;        ///< 181, 361, 101, 201 or 401
  double nod = 0;         ///< rad, the tilt swings by this to either side; 0: it stands still
  double nod_period = 4;  ///< s, of a swing to and fro
};

/// The events of a Simulator, and after each scan one of the second laser with the same stamp. Its
/// ranges err like the first one's, by draws of their own.
class SolidSimulator {
 public:
  /// Keeps references to both worlds; they should be of one place. Throws Error as Simulator does.
  SolidSimulator(const World& world, const SolidWorld& solid, const Path& path,
                 const SimulationOptions& options, const SecondLaserOptions& second = {});

  std::optional<Event> next();

  /// How the second laser nods: 0 at the run's begin.
  map::TiltTrack tilt() const;
  const Simulator& first() const { return simulator_; }
  const RobotRun& run() const { return simulator_.run(); }

 private:
  double tilt_at(Duration time) const;
  Scan make_scan(std::int64_t number, Time stamp) const;

  const SolidWorld& solid_;
  SimulationOptions options_;
  SecondLaserOptions second_;
  sensor::Variant variant_;
  sensor::RangeNoise noise_;
  Simulator simulator_;
  std::int64_t scans_ = 0;
  std::optional<Event> waiting_;
};

/// Two rooms and a corridor of 12 x 8 m under one ceiling, with doors and their lintels, a table, a
/// cupboard, a round pillar. The first laser should stand below the table's top.
struct SolidRooms {
  Scene plan;
  SolidScene solid;
};
SolidRooms solid_rooms();

/// Outdoors: ground of 24 x 14 m with a ramp of 10 degrees up to a terrace of 0.7 m, a step of 0.15
/// m, a kerb of 0.06 m, and a beam across at 1.2 m; a fence around.
SolidRooms solid_yard();

}  // namespace majak::sim
