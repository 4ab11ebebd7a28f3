// SPDX-License-Identifier: Apache-2.0
// Occupancy grid: log-odds of "something is here" per square cell (Moravec and Elfes 1985; Thrun,
// Burgard, Fox 2005, ch. 9), in sparse tiles, so that memory follows the explored area.
#pragma once

#include <cstddef>
#include <cstdint>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/map/tiles.hpp"

namespace majak::map {

struct OccupancyGridOptions {
  double resolution = 0.05;      ///< m, side of a cell
  double max_range = 30.0;       ///< m, beams are drawn so far; a return beyond is no hit
  double no_return_range = 0.0;  ///< m, a beam without return clears so far
  double log_odds_hit = 1.1;     ///< added to the cell a beam ends in
  double log_odds_miss = 0.4;    ///< taken from the cells a beam crosses
  double log_odds_limit = 6.0;   ///< log-odds stay within +- this
  double scan_spacing = 0.15;    ///< m, a scan nearer than this to the last drawn one and
  double scan_turn = 0.15;       ///< rad, turned less than this against it is not drawn
};

inline void describe(OptionFields& fields, OccupancyGridOptions& o) {
  fields.add("grid.resolution", o.resolution, {"m", "side of a cell", 0.005, 10});
  fields.add("grid.max_range", o.max_range, {"m", "beams are drawn so far", 0.1, 1000});
  fields.add("grid.no_return_range", o.no_return_range,
             {"m", "a beam without return clears so far; 0: nothing", 0, 1000});
  fields.add("grid.log_odds_hit", o.log_odds_hit, {"1", "added where a beam ends", 0.01, 10});
  fields.add("grid.log_odds_miss", o.log_odds_miss, {"1", "taken where a beam passes", 0.01, 10});
  fields.add("grid.log_odds_limit", o.log_odds_limit,
             {"1", "log-odds stay within +- this", 0.1, 20});
  fields.add("grid.scan_spacing", o.scan_spacing,
             {"m", "a scan nearer to the last drawn one is left out unless it turned", 0, 100});
  fields.add(
      "grid.scan_turn", o.scan_turn,
      {"rad", "a scan turned less against the last drawn one is left out unless it moved", 0, 4});
}

/// Cell (ix, iy) covers [ix, ix + 1) x [iy, iy + 1) times the resolution, in the map frame.
class OccupancyGrid {
 public:
  static constexpr int kTileBits = Tiles<std::int16_t>::kBits;
  static constexpr int kTileSize = Tiles<std::int16_t>::kSize;  ///< cells along a tile's side
  static constexpr double kUnit = 1e-3;  ///< log-odds are stored as int16 in this unit
  static constexpr std::int16_t kUnknown = INT16_MIN;

  explicit OccupancyGrid(double resolution = 0.05) : resolution_(resolution) {}

  double resolution() const { return resolution_; }
  /// Tight around all known cells; empty when there are none. Costs a walk over the tiles.
  CellBox bounds() const {
    return tiles_.bounds([](std::int16_t v) { return v != kUnknown; });
  }
  /// 0 where unknown.
  float log_odds(int ix, int iy) const {
    const std::int16_t value = tiles_(ix, iy);
    return value == kUnknown ? 0.0F : static_cast<float>(value * kUnit);
  }
  /// Has any beam told of this cell?
  bool known(int ix, int iy) const { return tiles_(ix, iy) != kUnknown; }
  /// Area of all known cells, m^2.
  double known_area() const;
  std::size_t bytes() const { return sizeof(*this) + tiles_.bytes(); }
  /// How many scans were drawn.
  std::size_t scans_drawn() const { return scans_drawn_; }

  /// |log_odds| < 32.
  void set_log_odds(int ix, int iy, float log_odds);

  /// As if no beam had told of it.
  void forget(int ix, int iy) { tiles_(ix, iy) = kUnknown; }

  /// Stored values of the row of cells (x0 ... x0 + width - 1, iy), for walks over whole pictures.
  void copy_row(int x0, int iy, int width, std::int16_t* out) const {
    tiles_.copy_row(x0, iy, width, out);
  }

  /// body(ix, iy, log_odds) for every known cell.
  template <class Body>
  void for_each(const Body& body) const {
    tiles_.for_each([&](int ix, int iy, std::int16_t v) {
      if (v != kUnknown) body(ix, iy, static_cast<float>(v * kUnit));
    });
  }

  /// Stored values of a tile, see Tiles.
  std::int16_t* tile(int tx, int ty) { return tiles_.tile(tx, ty); }
  /// Null when missing.
  const std::int16_t* find_tile(int tx, int ty) const { return tiles_.find_tile(tx, ty); }

 private:
  friend OccupancyGrid build_occupancy_grid(const Site&, const OccupancyGridOptions&, Threads);

  double resolution_;
  std::size_t scans_drawn_ = 0;
  Tiles<std::int16_t> tiles_{kUnknown};
};

/// Draws the scans of a site from their final poses. In one scan a cell changes once, and a beam
/// that ends in it wins over beams that cross it. Beams of unknown range, scans that are lost and
/// poses that are not finite draw nothing; what people drew is there (map/edits). The result does
/// not depend on the number of threads.
/// Throws Error when an option is out of its range.
OccupancyGrid build_occupancy_grid(const Site& site, const OccupancyGridOptions& options = {},
                                   Threads threads = {});

/// Cells `factor` times as wide (1 or more), for what wants to be quick or far-sighted: each has
/// the highest log-odds of the known cells in it, so that nothing that stands in the way is lost.
OccupancyGrid coarser(const OccupancyGrid& grid, int factor);

}  // namespace majak::map
