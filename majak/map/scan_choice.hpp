// SPDX-License-Identifier: Apache-2.0
// Which scans a map is drawn from: a robot that stands would draw the same thing again and again.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "majak/core/site.hpp"

namespace majak::map {

struct ScanChoice {
  double resolution = 0.05;                                   ///< m, side of a cell
  double max_range = 30;                                      ///< m, beams are drawn so far
  double spacing = 0.15;                                      ///< m
  double turn = 0.15;                                         ///< rad
  double interval = std::numeric_limits<double>::infinity();  ///< s
};

/// Indices of the scans that moved `spacing`, turned by `turn` or came `interval` after the last
/// chosen one of the same laser, ascending. None that is lost, or of which place or beams are not
/// finite or too far away to be counted in cells.
std::vector<std::size_t> scans_to_draw(const Site& site, const ScanChoice& choice);

/// Calls visit(posed) for each scan that is `spacing` (m) or `turn` (rad) away from the last one,
/// as scans_to_draw() has it.
template <class Visit>
void for_spaced_scans(const Site& site, double spacing, double turn, const Visit& visit) {
  for (const std::size_t i : scans_to_draw(site, {.spacing = spacing, .turn = turn}))
    visit(site.scans[i]);
}

}  // namespace majak::map
