// SPDX-License-Identifier: Apache-2.0
// The figures of a run, once: for summary.json, for the report and for what the program prints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/motion/slip.hpp"

namespace majak::io {

/// Name and value; the name ends in the unit ("matching_cpu_s").
using NamedFigure = std::pair<std::string, double>;

struct Figures {
  std::size_t scans = 0, key_scans = 0, scans_drawn = 0;
  std::size_t ok = 0, degraded = 0, lost = 0;  ///< scans by health
  std::size_t closures = 0, closures_rejected = 0;
  std::size_t matches = 0;            ///< relations between successive scans
  double duration_s = 0;              ///< from the earliest to the latest scan
  double path_m = 0, turned_rad = 0;  ///< along the key scans (all scans if there are none)
  double width_m = 0, height_m = 0;   ///< of the map
  double known_area_m2 = 0;
  double grid_resolution_m = 0;
  double position_sigma_median_m = 0, position_sigma_max_m = 0;  ///< larger axis of the ellipse
  double heading_sigma_median_rad = 0, heading_sigma_max_rad = 0;
  double match_score_mean = 0;
  double front_end_shift_max_m = 0;  ///< how far loop closing moved a pose
  std::int64_t skipped = 0;          ///< records, all reasons together
};

Figures figures_of(const Site& site, const map::OccupancyGrid& grid);

/// summary.json: the figures, what was learnt of the odometry, what was skipped; keys carry units.
/// `extras` come as they are under their own key (evaluations, say); `timing` is left out when
/// empty, so that two equal runs give equal bytes. Of `slips`, biggest first, it holds the count
/// and the first twenty.
std::string summary_json(const Site& site, const map::OccupancyGrid& grid,
                         const std::vector<NamedFigure>& extras = {},
                         const std::vector<NamedFigure>& timing = {},
                         const std::vector<motion::SlipEvent>& slips = {});

}  // namespace majak::io
