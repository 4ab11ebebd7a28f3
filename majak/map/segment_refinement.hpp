// SPDX-License-Identifier: Apache-2.0
// The second pass of a segment map, when all scans and final poses are there: walls fitted anew to
// every return on them, ends where the returns end or where two walls meet, short pieces found in
// what the walls leave over, and what explains too few returns dropped. MATH 15.4.
#pragma once

#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/site.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

struct SegmentRefinementOptions {
  bool enabled = true;         ///< false: build_segments leaves the walls as the scans left them
  double cell = 0.02;          ///< m; returns are gathered in squares of this side
  double min_band = 0.025;     ///< m; a wall owns what lies within 2.5 of its own standard
  double max_band = 0.06;      ///< m; deviations, but no less and no more than these
  double min_length = 0.06;    ///< m, of a piece found in what the walls leave over
  double max_gap = 0.15;       ///< m, within such a piece
  int min_returns = 20;        ///< fewer make no segment
  double open_gap = 0.3;       ///< m; so much of a wall that beams mostly go through is taken out
  double corner_slack = 0.06;  ///< m; ends so near to where their lines meet end there
};

inline void describe(OptionFields& fields, SegmentRefinementOptions& o) {
  fields.add("refinement.enabled", o.enabled, {"", "walls are fitted to all returns", 0, 1});
  fields.add("refinement.cell", o.cell, {"m", "returns are gathered in such squares", 0.005, 0.1});
  fields.add("refinement.min_band", o.min_band,
             {"m", "a wall owns returns so near, whatever its noise", 0.005, 1});
  fields.add("refinement.max_band", o.max_band, {"m", "and none farther than this", 0.005, 1});
  fields.add("refinement.min_length", o.min_length,
             {"m", "of a piece found in what the walls leave over", 0.02, 100});
  fields.add("refinement.max_gap", o.max_gap, {"m", "within such a piece", 0.02, 10});
  fields.add("refinement.min_returns", o.min_returns, {"1", "fewer make no segment", 3, 1000000});
  fields.add("refinement.open_gap", o.open_gap,
             {"m", "so much of a wall that beams mostly go through is taken out", 0.05, 100});
  fields.add("refinement.corner_slack", o.corner_slack,
             {"m", "ends so near to where their lines meet end there", 0, 1});
}

struct SegmentMapOptions;

/// The walls of a map of the site's scans, refined. Returns of lost scans and those that do not lie
/// in or beside an occupied cell of the site's grid are not used. Covariances hold the noise of the
/// returns and the poses' own, as the site states it.
std::vector<Segment> refined(const Site& site, std::vector<Segment> walls,
                             const SegmentMapOptions& options);

}  // namespace majak::map
