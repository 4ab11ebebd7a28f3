// SPDX-License-Identifier: Apache-2.0
// build_occupancy_grid: scans are drawn into windows, which are added to the tiles row by row.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "majak/core/option_range.hpp"
#include "majak/map/edits.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/scan_choice.hpp"
#include "majak/map/scan_window.hpp"

namespace majak::map {

namespace {

constexpr int kTileSize = OccupancyGrid::kTileSize;
constexpr std::int16_t kUnknown = OccupancyGrid::kUnknown;
constexpr auto kHit = ScanWindow::kHit, kNothing = ScanWindow::kNothing;

/// Integers in units of OccupancyGrid::kUnit. Sums stay inside int16 by the ranges of the options.
struct Steps {
  std::int16_t hit, miss, limit;
};

/// A row of a window onto a row of a tile. Without a branch, so that it becomes vector code.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
__attribute__((target_clones("avx2", "default")))  // integers: the same result either way
#endif
void add_row(std::int16_t* cells, const std::uint8_t* marks, const Steps& steps) {
  const Steps s = steps;
  const auto low = static_cast<std::int16_t>(-s.limit);
  for (int i = 0; i < kTileSize; ++i) {
    const std::int16_t old = cells[i], mark = marks[i];
    const std::int16_t base = old == kUnknown ? std::int16_t{0} : old;
    const std::int16_t change = mark == kHit ? s.hit : s.miss;
    const auto sum = static_cast<std::int16_t>(base + change);
    const std::int16_t next = std::min(std::max(sum, low), s.limit);
    cells[i] = mark != kNothing ? next : old;
  }
}

/// Adds the window to the grid and leaves the window blank.
void add(ScanWindow& window, OccupancyGrid& grid, const Steps& steps) {
  std::int16_t* cells = nullptr;
  int at_x = 0, at_y = 0;
  window.take_rows([&](int tx, int ty, int y, const std::uint8_t* marks) {
    if (!cells || tx != at_x || ty != at_y) cells = grid.tile(at_x = tx, at_y = ty);
    add_row(cells + y * kTileSize, marks, steps);
  });
}

std::int16_t to_units(double log_odds) {
  return static_cast<std::int16_t>(std::lround(log_odds / OccupancyGrid::kUnit));
}

}  // namespace

OccupancyGrid build_occupancy_grid(const Site& site, const OccupancyGridOptions& options,
                                   Threads threads) {
  require_in_range(options);
  const Steps steps{to_units(options.log_odds_hit), to_units(-options.log_odds_miss),
                    to_units(options.log_odds_limit)};
  OccupancyGrid grid(options.resolution);
  const std::vector<std::size_t> chosen = scans_to_draw(
      site, {options.resolution, options.max_range, options.scan_spacing, options.scan_turn});
  // A batch is drawn side by side and added in the order of the log.
  std::vector<ScanWindow> windows(static_cast<std::size_t>(std::max(1, threads.count)));
  for (std::size_t first = 0; first < chosen.size(); first += windows.size()) {
    const std::size_t count = std::min(windows.size(), chosen.size() - first);
    parallel_for(threads, count,
                 [&](std::size_t i) { windows[i].draw(site.scans[chosen[first + i]], options); });
    for (std::size_t i = 0; i < count; ++i) add(windows[i], grid, steps);
  }
  grid.scans_drawn_ = chosen.size();
  draw_edits(grid, site);
  return grid;
}

}  // namespace majak::map
