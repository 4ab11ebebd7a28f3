// SPDX-License-Identifier: Apache-2.0
// Doors of a simulated building that open and close during a run, each at times of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "majak/core/time.hpp"
#include "majak/sim/tour.hpp"
#include "majak/sim/world.hpp"

namespace majak::sim {

/// A leaf on its hinge; a door that stands open stands across its doorway, or has slid into the
/// wall where it would be in the robot's way.
struct Door {
  Segment closed;          ///< the leaf when shut, hinge first
  double swing = kPi / 2;  ///< rad, how far the leaf turns as it opens
  bool slides = false;     ///< open, it is not seen at all
  bool open_at_first = false;
  std::vector<Duration> changes;  ///< from the start of the run: it begins to move, ascending

  static constexpr Duration kMoves = kSecond;  ///< so long it is ajar
  bool open_at(Duration time) const;           ///< or on its way to be
  /// 0 shut ... 1 open.
  double opening(Duration time) const;
};

/// The doors of the scene's doorways that the path keeps away from, each open or closed at first
/// and changed at random times, `period` (s) apart in the mean, for `run`.
std::vector<Door> draw_doors(const Scene& scene, const Path& path, double period, Duration run,
                             std::uint64_t seed);

/// What the laser may see of the doors.
std::vector<Segment> leaves(const std::vector<Door>& doors, Duration time);

}  // namespace majak::sim
