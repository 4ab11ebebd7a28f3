// SPDX-License-Identifier: Apache-2.0
// report.html: everything that a run found out, in one file that needs nothing else.
#pragma once

#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/io/summary.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/motion/slip.hpp"

namespace majak::draw {

/// What the site does not know. Names end in their unit ("matching_cpu_s"); empty lists are left
/// out.
struct ReportExtras {
  std::vector<io::NamedFigure> timing;
  std::vector<io::NamedFigure> evaluation;
  std::string version;                   ///< of the program
  std::vector<motion::SlipEvent> slips;  ///< biggest first
};

/// The whole page. Equal sites (and extras) give equal bytes.
std::string report_html(const Site& site, const map::OccupancyGrid& grid,
                        const ReportExtras& extras = {});

}  // namespace majak::draw
