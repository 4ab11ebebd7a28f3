// SPDX-License-Identifier: Apache-2.0
#include "majak/map/visits.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

double time_at(const Site& site, std::size_t i) { return to_seconds(site.scans[i].scan.time); }

/// Cut where nothing came for `gap` s, then each part into equal ones of `longest` s at most.
std::vector<Visit> split(const Site& site, double gap, double longest) {
  std::vector<Visit> visits;
  const std::size_t count = site.scans.size();
  for (std::size_t first = 0, last = 0; first < count; first = last) {
    while (++last < count && time_at(site, last) - time_at(site, last - 1) <= gap) {
    }
    const double begin = time_at(site, first), lasts = time_at(site, last - 1) - begin;
    const double parts = std::max(1.0, std::ceil(lasts / longest));
    const auto part_of = [&](std::size_t i) {
      return lasts > 0 ? std::min(parts - 1, std::floor((time_at(site, i) - begin) * parts / lasts))
                       : 0;
    };
    std::size_t from = first;
    for (std::size_t i = first + 1; i <= last; ++i) {
      if (i < last && part_of(i) == part_of(from)) continue;
      visits.push_back({from, i});
      from = i;
    }
  }
  return visits;
}

}  // namespace

void describe(OptionFields& fields, VisitOptions& o) {
  fields.add("visits.gap", o.gap, {"s", "without a scan: another visit begins", 0, 1e9});
  fields.add("visits.longest", o.longest, {"s", "longer ones are cut in equal parts", 1, 1e9});
  fields.add("visits.most", o.most, {"1", "visits at most", 1, 200});
}

std::vector<Visit> split_visits(const Site& site, const VisitOptions& options) {
  if (!(options.gap >= 0 && options.longest >= 1 && options.most >= 1))
    throw Error("visits: gap of 0 s or more, longest of 1 s or more, one visit or more");
  double gap = options.gap, longest = options.longest;
  std::vector<Visit> visits = split(site, gap, longest);
  while (visits.size() > static_cast<std::size_t>(options.most)) {
    gap = 2 * gap + 1, longest *= 2;
    visits = split(site, gap, longest);
  }
  return visits;
}

std::vector<KnownMap> visit_maps(const Site& site, const std::vector<Visit>& visits,
                                 const OccupancyGridOptions& grid, Threads threads) {
  std::vector<KnownMap> maps;
  for (const Visit& visit : visits) {
    Site part;
    part.scans.assign(site.scans.begin() + static_cast<std::ptrdiff_t>(visit.first),
                      site.scans.begin() + static_cast<std::ptrdiff_t>(visit.last));
    maps.push_back(known_map(build_occupancy_grid(part, grid, threads)));
  }
  return maps;
}

}  // namespace majak::map
