// SPDX-License-Identifier: Apache-2.0
#include "majak/map/dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "majak/core/option_range.hpp"
#include "majak/map/scan_choice.hpp"
#include "majak/map/scan_window.hpp"

namespace majak::map {
namespace {

double log_odds_of(double p) { return std::log(p / (1 - p)); }

/// (MATH 20.1): the chance after dt.
double carried(double p, const DynamicsMap::Rates& rates, double dt) {
  const double sum = rates.fill + rates.empty;
  const double resting = rates.fill / sum;
  return resting + (p - resting) * std::exp(-sum * dt);
}

}  // namespace

void describe(OptionFields& fields, DynamicsOptions& o) {
  fields.add("dynamics.interval", o.interval,
             {"s", "a scan so much later is drawn even if the robot stands", 0, 1e6});
  fields.add("dynamics.hit_occupied", o.hit_occupied,
             {"1", "chance that a beam ends in an occupied cell", 0.01, 0.99});
  fields.add("dynamics.hit_free", o.hit_free,
             {"1", "chance that a beam ends in a free cell", 0.001, 0.99});
  fields.add("dynamics.sure", o.sure, {"1", "belief from which on a state is stated", 0.5, 0.999});
  fields.add("dynamics.log_odds_limit", o.log_odds_limit,
             {"1", "belief stays within +- this", 0.1, 20});
  fields.add("dynamics.prior_time", o.prior_time,
             {"s", "between changes of a cell that nothing is known of", 1, 1e9});
  fields.add("dynamics.prior_changes", o.prior_changes,
             {"1", "changes that the prior is worth", 1e-3, 1e3});
  fields.add("dynamics.stay", o.stay, {"s", "what stood for less is passing", 0, 1e6});
}

CellBox DynamicsMap::bounds() const {
  return cells_.bounds([](const CellHistory& cell) { return cell.known; });
}

std::size_t DynamicsMap::bytes() const {
  return cells_.bytes() + changes_.size() * sizeof(Changes);
}

const CellHistory* DynamicsMap::history(int ix, int iy) const {
  const CellHistory& cell = cells_(ix, iy);
  return cell.known ? &cell : nullptr;
}

std::vector<CellChange> DynamicsMap::changes(const CellHistory& cell) const {
  if (cell.changes < 0) return {};
  const Changes& kept = changes_[static_cast<std::size_t>(cell.changes)];
  return {kept.begin(), kept.begin() + cell.kept};
}

DynamicsMap::Rates DynamicsMap::rates(const CellHistory& cell) const {
  const double n = options_.prior_changes, t = n * options_.prior_time;
  return {(cell.filled + n) / (static_cast<double>(cell.free_time) + t),
          (cell.emptied + n) / (static_cast<double>(cell.occupied_time) + t)};
}

void DynamicsMap::add(CellHistory& cell, float time, bool hit) {
  if (!cell.known) {
    cell.known = true;
    cell.first_seen = cell.last_seen = cell.confirmed = cell.doubted = time;
  }
  const double dt = std::max(0.0F, time - cell.last_seen);
  double l = static_cast<double>(cell.log_odds);
  if (dt > 0) l = log_odds_of(carried(1 / (1 + std::exp(-l)), rates(cell), dt));
  l += hit ? std::log(options_.hit_occupied / options_.hit_free)
           : std::log((1 - options_.hit_occupied) / (1 - options_.hit_free));
  l = std::clamp(l, -options_.log_odds_limit, options_.log_odds_limit);
  cell.log_odds = static_cast<float>(l);
  cell.last_seen = std::max(cell.last_seen, time);
  const double sure = log_odds_of(options_.sure);
  if (!cell.stated) {
    cell.occupied = l > 0;
    cell.stated = std::abs(l) >= sure;
    cell.confirmed = cell.last_seen;
  } else if (hit == cell.occupied) {
    (cell.occupied ? cell.occupied_time : cell.free_time) += cell.last_seen - cell.confirmed;
    cell.confirmed = cell.doubted = cell.last_seen;
  } else {
    if (cell.doubted <= cell.confirmed) cell.doubted = cell.last_seen;
    if (cell.occupied ? l <= -sure : l >= sure) state_change(cell, cell.last_seen);
  }
}

/// Where there is no room for one more, the two changes around the shortest stay are forgotten.
void DynamicsMap::state_change(CellHistory& cell, float time) {
  if (cell.changes < 0) {
    cell.changes = static_cast<std::int32_t>(changes_.size());
    changes_.emplace_back();
  }
  Changes& kept = changes_[static_cast<std::size_t>(cell.changes)];
  if (cell.kept == CellHistory::kKept) {
    std::size_t shortest = 0;
    for (std::size_t i = 1; i + 1 < CellHistory::kKept; ++i)
      if (kept[i + 1].from - kept[i].to < kept[shortest + 1].from - kept[shortest].to) shortest = i;
    std::copy(kept.begin() + static_cast<std::ptrdiff_t>(shortest) + 2, kept.end(),
              kept.begin() + static_cast<std::ptrdiff_t>(shortest));
    cell.kept = CellHistory::kKept - 2;
  }
  kept[cell.kept++] = {cell.confirmed, cell.doubted};
  std::uint16_t& count = cell.occupied ? cell.emptied : cell.filled;
  if (count < std::numeric_limits<std::uint16_t>::max()) ++count;
  cell.occupied = !cell.occupied;
  (cell.occupied ? cell.occupied_time : cell.free_time) += time - cell.doubted;
  cell.confirmed = cell.doubted = time;
}

double DynamicsMap::longest_stay(const CellHistory& cell, bool occupied) const {
  const std::vector<CellChange> kept = changes(cell);
  double longest = 0;
  bool state = cell.occupied != (kept.size() % 2 == 1);
  for (std::size_t i = 0; i <= kept.size(); ++i, state = !state) {
    const float from = i == 0 ? cell.first_seen : kept[i - 1].to;
    const float to = i == kept.size() ? cell.confirmed : kept[i].from;
    if (state == occupied) longest = std::max(longest, static_cast<double>(to - from));
  }
  return longest;
}

CellKind DynamicsMap::kind(int ix, int iy) const {
  const CellHistory* cell = history(ix, iy);
  if (!cell || !cell->stated) return CellKind::unknown;
  if (cell->kept == 0) return cell->occupied ? CellKind::occupied : CellKind::free;
  return longest_stay(*cell, true) < options_.stay    ? CellKind::passed
         : longest_stay(*cell, false) < options_.stay ? CellKind::occupied
                                                      : CellKind::switching;
}

std::optional<double> DynamicsMap::occupied_at(const CellHistory& cell, double time,
                                               bool hindsight) const {
  if (!hindsight && time < static_cast<double>(cell.first_seen)) return std::nullopt;
  const double sure = 1 / (1 + std::exp(-options_.log_odds_limit));
  const auto chance = [&](bool occupied) { return occupied ? sure : 1 - sure; };
  const Rates r = rates(cell);
  if (!cell.stated) return 1 / (1 + std::exp(-static_cast<double>(cell.log_odds)));
  const std::vector<CellChange> kept = changes(cell);
  bool state = cell.occupied != (kept.size() % 2 == 1);
  if (time < static_cast<double>(cell.first_seen))
    return carried(chance(state), r, static_cast<double>(cell.first_seen) - time);
  for (const CellChange& c : kept) {
    const double from = static_cast<double>(c.from), to = static_cast<double>(c.to);
    if (time < from) return chance(state);
    if (time < to) {
      if (!hindsight) return carried(chance(state), r, time - from);
      const double passed = (time - from) / (to - from);
      return (1 - passed) * chance(state) + passed * chance(!state);
    }
    state = !state;
  }
  return carried(chance(state), r, std::max(0.0, time - static_cast<double>(cell.last_seen)));
}

DynamicsMap build_dynamics(const Site& site, const DynamicsOptions& options, Threads threads) {
  require_in_range(options);
  require_in_range(options.grid);
  DynamicsMap map(options);
  const std::vector<std::size_t> chosen =
      scans_to_draw(site, {options.grid.resolution, options.grid.max_range,
                           options.grid.scan_spacing, options.grid.scan_turn, options.interval});
  if (chosen.empty()) return map;
  map.begin_ = site.scans[chosen.front()].scan.time;
  map.duration_ = to_seconds(site.scans[chosen.back()].scan.time - map.begin_);
  map.scans_drawn_ = chosen.size();
  std::vector<ScanWindow> windows(static_cast<std::size_t>(std::max(1, threads.count)));
  for (std::size_t first = 0; first < chosen.size(); first += windows.size()) {
    const std::size_t count = std::min(windows.size(), chosen.size() - first);
    parallel_for(threads, count, [&](std::size_t i) {
      windows[i].draw(site.scans[chosen[first + i]], options.grid);
      windows[i].forget_beside_hits();
    });
    for (std::size_t i = 0; i < count; ++i) {
      const auto time =
          static_cast<float>(to_seconds(site.scans[chosen[first + i]].scan.time - map.begin_));
      windows[i].take_rows([&](int tx, int ty, int y, const std::uint8_t* marks) {
        CellHistory* cells =
            map.cells_.tile(tx, ty) + static_cast<std::ptrdiff_t>(y) * OccupancyGrid::kTileSize;
        for (int x = 0; x < OccupancyGrid::kTileSize; ++x)
          if (marks[x] != ScanWindow::kNothing)
            map.add(cells[x], time, marks[x] == ScanWindow::kHit);
      });
    }
  }
  return map;
}

OccupancyGrid map_at(const DynamicsMap& dynamics, double time, bool hindsight) {
  OccupancyGrid grid(dynamics.resolution());
  const CellBox box = dynamics.bounds();
  for (int iy = box.y0; iy < box.y0 + box.height; ++iy)
    for (int ix = box.x0; ix < box.x0 + box.width; ++ix) {
      const CellHistory* cell = dynamics.history(ix, iy);
      if (!cell) continue;
      if (const auto p = dynamics.occupied_at(*cell, time, hindsight))
        grid.set_log_odds(ix, iy, static_cast<float>(log_odds_of(*p)));
    }
  return grid;
}

}  // namespace majak::map
