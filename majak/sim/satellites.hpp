// SPDX-License-Identifier: Apache-2.0
// Satellites: when a receiver on the simulated robot has a fix, and how wrong it is. Fixes come in
// bursts with outages between them; within a burst they share a bias (MATH.md "Simulated fixes").
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/sim/robot.hpp"

namespace majak::sim {

struct SatelliteOptions {
  bool on = false;
  double rate = 5;           ///< Hz, fixes within a burst
  double antenna_x = 0;      ///< m ahead of the robot's point
  double antenna_y = 0;      ///< m to its left
  double sigma = 0.08;       ///< m, each axis, from fix to fix
  double bias_sigma = 0.35;  ///< m, each axis, drawn anew for each burst
  double burst = 8;    ///< s, mean length; the first begins with the run, the last ends with it
  double outage = 55;  ///< s, mean length; 0: a burst follows the other
  // Faults, off by default. Times are counted from the start of the run.
  double jump = 0;           ///< m by which fixes are off, in a direction drawn once a run
  double jump_begin = 60;    ///< s; in an outage: when the next burst begins
  double jump_duration = 5;  ///< s
  double missing_until = 0;  ///< s, no fix before
};
void describe(OptionFields& fields, SatelliteOptions& options);

class Satellites {
 public:
  struct Burst {
    Duration begin = 0, end = 0;  ///< from the start of the run
    Vec2 bias = Vec2::Zero();     ///< m, world
  };

  /// Throws Error when an option is out of its range.
  Satellites(const SatelliteOptions& options, Duration run, std::uint64_t seed);

  /// When the `number`-th fix is due, burst or not, from the start of the run.
  Duration time(std::int64_t number) const;
  /// The fix as the receiver states it: east is the world's x, north its y, relative to the world's
  /// origin; how sure it is it does not say (sigma 0). Nothing in an outage. The stamp is time().
  std::optional<GpsFix> fix(std::int64_t number, const Pose2& T_world_robot) const;

  const std::vector<Burst>& bursts() const { return bursts_; }

 private:
  SatelliteOptions options_;
  std::uint64_t seed_;
  std::vector<Burst> bursts_;  ///< in order of time, apart
  Vec2 jump_ = Vec2::Zero();   ///< m
  Duration jump_at_ = 0;       ///< from the start of the run
};

}  // namespace majak::sim
