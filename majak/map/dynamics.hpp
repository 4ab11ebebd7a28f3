// SPDX-License-Identifier: Apache-2.0
// Dynamics: what each cell did over time. A cell is a Markov chain of two states, occupied and
// free, whose rates are learnt from its own changes; few of the changes are kept, so that memory
// follows the area and not the scans (MATH 20).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/tiles.hpp"

namespace majak::map {

struct DynamicsOptions {
  OccupancyGridOptions grid;   ///< cells, reach, and which scans are drawn
  double interval = 0.3;       ///< s, a scan so much later is drawn even if the robot stands
  double hit_occupied = 0.7;   ///< chance that a beam ends in an occupied cell that it meets
  double hit_free = 0.05;      ///< ... in a free one
  double sure = 0.95;          ///< belief from which on a state is stated
  double log_odds_limit = 6;   ///< belief stays within +- this
  double prior_time = 3600;    ///< s between two changes of a cell that nothing is known of
  double prior_changes = 0.2;  ///< changes that this is worth
  double stay = 10;            ///< s, what stood for less is passing (a person)
};
/// All but those of the grid.
void describe(OptionFields& fields, DynamicsOptions& options);

enum class CellKind : std::uint8_t {
  unknown,
  free,       ///< always
  occupied,   ///< always
  passed,     ///< free; something came by
  switching,  ///< stays occupied, stays free: a door, a thing that was moved
};

/// The old state was seen last at `from`, the new one first at `to`; s since DynamicsMap::begin().
struct CellChange {
  float from = 0, to = 0;
};

/// What is kept of a cell. Times are s since DynamicsMap::begin().
struct CellHistory {
  static constexpr std::size_t kKept = 8;  ///< changes, those around the longest stays

  float log_odds = 0;  ///< of being occupied, when last seen
  float first_seen = 0, last_seen = 0;
  float confirmed = 0, doubted = 0;  ///< last reading for the state, first against it since then
  float occupied_time = 0, free_time = 0;  ///< s seen in that state
  std::uint16_t filled = 0, emptied = 0;   ///< changes to occupied, to free
  std::int32_t changes = -1;               ///< where those kept are; -1: none
  std::uint8_t kept = 0;
  bool known = false;     ///< seen at all
  bool stated = false;    ///< a state was sure once
  bool occupied = false;  ///< the state that was sure last
};

class DynamicsMap {
 public:
  explicit DynamicsMap(const DynamicsOptions& options = {}) : options_(options) {}

  double resolution() const { return options_.grid.resolution; }
  /// Stamp of the first scan, and s from it to the last.
  Time begin() const { return begin_; }
  double duration() const { return duration_; }
  CellBox bounds() const;  ///< tight around all cells that were read
  std::size_t bytes() const;
  std::size_t scans_drawn() const { return scans_drawn_; }

  CellKind kind(int ix, int iy) const;
  /// Null where no beam has told of the cell.
  const CellHistory* history(int ix, int iy) const;
  /// The changes that are kept, ascending; after the last one the cell is history()->occupied.
  std::vector<CellChange> changes(const CellHistory& cell) const;
  /// s from the first reading of the longest stay in that state to its last.
  double longest_stay(const CellHistory& cell, bool occupied) const;
  struct Rates {
    double fill = 0, empty = 0;  ///< 1/s, free to occupied and back
  };
  Rates rates(const CellHistory& cell) const;

  /// Chance that the cell is occupied `time` s after begin(). With hindsight all readings tell,
  /// else those of up to then; nothing where none does. (MATH 20.4, 20.5)
  std::optional<double> occupied_at(const CellHistory& cell, double time, bool hindsight) const;

  /// One reading of a cell.
  void add(CellHistory& cell, float time, bool hit);

 private:
  friend DynamicsMap build_dynamics(const Site&, const DynamicsOptions&, Threads);
  using Changes = std::array<CellChange, CellHistory::kKept>;

  void state_change(CellHistory& cell, float time);

  DynamicsOptions options_;
  Time begin_ = 0;
  double duration_ = 0;
  std::size_t scans_drawn_ = 0;
  Tiles<CellHistory> cells_;
  std::vector<Changes> changes_;
};

/// From the scans of a site at their final poses, in the order of the log. In one scan a cell is
/// read once; cells beside a hit of the same scan are not read as free, for so far poses and ranges
/// err. The result does not depend on the number of threads. Throws Error when an option is out of
/// its range.
DynamicsMap build_dynamics(const Site& site, const DynamicsOptions& options = {},
                           Threads threads = {});

/// The map as it was at a time (s after begin()).
OccupancyGrid map_at(const DynamicsMap& dynamics, double time, bool hindsight = true);

}  // namespace majak::map
