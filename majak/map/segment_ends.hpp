// SPDX-License-Identifier: Apache-2.0
// Where walls end, from beams that meet a wall and beams that pass it by: a beam's bearing is known
// far better than its range, so that many scans tell a free end to millimetres. MATH 15.4.
#pragma once

#include <vector>

#include "majak/core/site.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

struct SegmentEndOptions {
  double band = 0.04;         ///< m; a return so near to the line is on it, twice as far not
  double reach = 0.15;        ///< m; ends are sought so far from where they are now
  double grazing = 0.17;      ///< rad; beams that meet the line at less tell nothing
  double max_range = 30;      ///< m
  double key_spacing = 0.15;  ///< m, a scan nearer than this to the last one taken and
  double key_turn = 0.15;     ///< rad, turned less is left out
};

/// Moves the ends of segments to where beams that pass follow on beams that meet them, and states
/// how well that is known (sigma_a, sigma_b); ends that no beam passed stay as they are.
void sharpen_ends(const Site& site, std::vector<Segment>& segments,
                  const SegmentEndOptions& options);

/// States a segment's covariance `way` (m) farther along it.
void shift_middle(Segment& segment, double way);

}  // namespace majak::map
