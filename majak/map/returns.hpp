// SPDX-License-Identifier: Apache-2.0
// The sensor map: what the laser saw and nothing else. Scans can be picked by when and where they
// were taken, and drawn again.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "majak/core/options.hpp"
#include "majak/core/site.hpp"
#include "majak/map/tiles.hpp"

namespace majak::map {

/// Which scans: all that meet every condition.
struct ScanSelection {
  double from = 0;  ///< s after the first scan
  double to = std::numeric_limits<double>::infinity();
  std::optional<Vec2> near;  ///< m, map frame: taken within `radius` of it
  double radius = 5;         ///< m
};

/// The site with those scans alone and the constraints between them. Throws Error when there is no
/// such scan.
Site selected(const Site& site, const ScanSelection& selection);

/// How many returns fell into each cell (65535: so many or more), in the map's frame; lost scans
/// and poses that are not finite are left out, and returns beyond max_range.
struct ReturnCounts {
  double resolution = 0.05;  ///< m, side of a cell
  Tiles<std::uint16_t> cells;
  std::int64_t returns = 0, no_returns = 0, unknown = 0, scans = 0;
};
ReturnCounts count_returns(const Site& site, double resolution = 0.05, double max_range = 30);

}  // namespace majak::map
