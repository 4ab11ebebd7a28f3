// SPDX-License-Identifier: Apache-2.0
// How good is a map when nobody knows the truth? Three measures of the returns themselves, drawn
// from the final poses. They compare runs of one log; they do not compare places.
#pragma once

#include <cstddef>

#include "majak/core/site.hpp"
#include "majak/eval/statistics.hpp"

namespace majak::eval {

struct MapQualityOptions {
  double max_range = 20.0;       ///< m; longer beams are not looked at
  double radius = 0.15;          ///< m; neighbourhood of a point, for thickness and entropy
  double doubled_from = 0.08;    ///< m; a second wall nearer than this is thickness
  double doubled_to = 0.40;      ///< m; and further than this is another wall
  double revisit_radius = 0.30;  ///< m; a later visit's point looks so far for earlier ones
  Duration revisit_after = 30 * kSecond;  ///< ns; what is seen so much later is another visit
  std::size_t max_points = 600'000;       ///< scans are thinned evenly beyond
  std::size_t samples = 20'000;           ///< points that are examined, spread evenly
};

struct MapQuality {
  std::size_t points = 0;   ///< returns drawn
  std::size_t samples = 0;  ///< returns examined

  /// Crispness. Small is crisp; the sensor's own noise is the floor.
  double wall_thickness = 0;  ///< m, one sigma across the wall, median over points on walls
  double entropy =
      0;  ///< nats, mean differential entropy of the neighbourhoods (Droeschel et al. 2017)

  /// Doubled walls: share of the examined points on walls that have a second wall beside them which
  /// faces the same way and which no scan saw together with the first, 0 ... 1.
  double doubled_share = 0;

  /// Revisits: distance of a return from the wall as it was seen at least revisit_after earlier.
  ErrorStats revisit;          ///< m
  double revisit_beyond = 0;   ///< share of those further than 0.1 m, 0 ... 1
  double revisited_share = 0;  ///< share of the examined points that have an earlier visit, 0 ... 1
};

/// Uses the key scans, or all scans when none is marked; scans that are lost draw nothing. A site
/// without returns gives zeros.
MapQuality measure_map_quality(const Site& site, const MapQualityOptions& options = {});

}  // namespace majak::eval
