// SPDX-License-Identifier: Apache-2.0
// From cells to segments and back: the walls of a map that is nothing but a picture, and the cells
// that segments run through. MATH 15.5.
#pragma once

#include <vector>

#include "majak/map/distance_transform.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/segments.hpp"

namespace majak::map {

struct ContourOptions {
  double split_cells = 1.0;  ///< cells; a wall's cell farther off a chord splits it
  double min_length = 0.2;   ///< m; shorter pieces are left out
};

/// The border between free and occupied cells as straight pieces through the middles of the
/// occupied ones, free cells to the left. Where unknown cells lie, there is no border.
std::vector<Segment> contour_segments(const KnownMap& map, const ContourOptions& options = {});

/// The cells of the map's frame that segments run through.
CellMask cells_of(const std::vector<Segment>& segments, const KnownMap& frame);

/// What a conversion lost and what it made up.
struct ConversionError {
  double missed = 0;  ///< share of occupied cells beside free ones, no segment within one cell
  double added = 0;   ///< share of the segments' cells, no occupied cell within one cell
};
ConversionError conversion_error(const KnownMap& map, const std::vector<Segment>& segments);

}  // namespace majak::map
