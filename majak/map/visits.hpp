// SPDX-License-Identifier: Apache-2.0
// Visits: a run cut into pieces that each leave a map of their own, to be compared.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/map/known_map.hpp"

namespace majak::map {

struct VisitOptions {
  double gap = 60;       ///< s without a scan: what comes after is another visit
  double longest = 300;  ///< s, a longer one is cut in equal parts
  int most = 24;         ///< visits at most; the parts become longer
};
void describe(OptionFields& fields, VisitOptions& options);

/// Scans [first, last) of a site.
struct Visit {
  std::size_t first = 0, last = 0;
  bool operator==(const Visit&) const = default;
};

/// In the order of the log. Throws Error when an option is out of its range.
std::vector<Visit> split_visits(const Site& site, const VisitOptions& options = {});

/// The map of each visit.
std::vector<KnownMap> visit_maps(const Site& site, const std::vector<Visit>& visits,
                                 const OccupancyGridOptions& grid = {}, Threads threads = {});

}  // namespace majak::map
