// SPDX-License-Identifier: Apache-2.0
// A segment map as the cells that localization looks up: occupied where a segment lies, free
// between segments that face each other. MATH 15.6.
#pragma once

#include <span>

#include "majak/map/known_map.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

struct SegmentRasterOptions {
  double resolution = 0.05;  ///< m, side of a cell
  double reach = 30;         ///< m; segments that face each other are no farther apart
  double before = 0.3;       ///< m of free space before a segment that faces no other
};

/// In the segments' frame, one margin cell of unknown around; empty without segments. Free is what
/// a ray from a segment's front crosses until it meets another segment's front, for rays straight
/// out of it and at 45 degrees to both sides. Throws Error where it would be larger than 2^28
/// cells.
KnownMap known_map(std::span<const Segment> segments, const SegmentRasterOptions& options = {});

}  // namespace majak::map
