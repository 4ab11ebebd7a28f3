// SPDX-License-Identifier: Apache-2.0
// Trunks and poles in a scan: short arcs that stand before everything around them (Guivant, Nebot
// and Baiker 2000).
#pragma once

#include <vector>

#include "majak/beacon/landmark.hpp"
#include "majak/core/event.hpp"
#include "majak/core/options.hpp"

namespace majak::beacon {

struct TrunkOptions {
  double max_range = 45;       ///< m
  double min_range = 1;        ///< m
  double max_diameter = 1.0;   ///< m
  double gap = 0.3;            ///< m, between the ranges of neighbouring beams on one trunk
  double clearance = 1.0;      ///< m, by which everything beside it must be farther
  double lone = 1.2;           ///< m, within which nothing else may be seen: no hedge, no crowd
  int least_beams = 2;         ///< that see it
  double spot = 0.006;         ///< rad, by which the beam's width makes it look wider
  double range_sigma = 0.05;   ///< m, of the range to the bark
  double bearing_sigma = 0.3;  ///< of an angle step
};

void describe(OptionFields& fields, TrunkOptions& options);

/// Those of a scan, from the first beam to the last. A beam that is lost in the midst of a trunk is
/// passed over (MATH "Landmarks").
std::vector<LandmarkSighting> find_trunks(const Scan& scan, const TrunkOptions& options = {});

}  // namespace majak::beacon
