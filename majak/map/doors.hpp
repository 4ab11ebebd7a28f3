// SPDX-License-Identifier: Apache-2.0
// Doors: straight stretches of cells that are now occupied, now free, between ends that stay; and
// whether each is open (MATH 20.6).
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/map/dynamics.hpp"

namespace majak::map {

struct DoorOptions {
  double least_width = 0.6;   ///< m
  double most_width = 1.4;    ///< m
  double tolerance = 0.1;     ///< m, cells and returns so near to the leaf's line are on it
  double jamb_reach = 0.3;    ///< m, something that stays is so near to either end
  double stay = 1.5;          ///< s, each state was seen for so long without a break
  double clear = 0.5;         ///< share of the leaf's length with free floor on both sides
  double filled = 0.6;        ///< share of the leaf's length that its cells cover
  double change_time = 120;   ///< s between changes of a door
  double pass_open = 0.9;     ///< chance that a beam through the doorway goes on, door open
  double pass_closed = 0.1;   ///< ... door closed
  double beam_weight = 0.34;  ///< what a beam counts, of an independent one
  double scan_limit = 3;      ///< nats, the most that one scan tells
  double log_odds_limit = 4;  ///< belief stays within +- this
  double sure = 0.9;          ///< belief from which on a state is stated
  int least_beams = 3;        ///< a door is in sight of a scan with so many beams through it
  double least_incidence =
      0.2;  ///< sine of the angle between beam and leaf; flatter ones tell nothing
};
void describe(OptionFields& fields, DoorOptions& options);

/// A doorway: where the leaf is when shut.
struct DoorSpan {
  Vec2 a, b;  ///< m, map frame
  bool operator==(const DoorSpan&) const = default;
};

/// Those whose leaf moved between readings; a door that never did is not told from a wall or a gap.
std::vector<DoorSpan> find_doors(const DynamicsMap& dynamics, const DoorOptions& options = {});

enum class DoorState : std::uint8_t { unknown, open, closed };

/// Watches doors scan by scan.
class DoorWatch {
 public:
  explicit DoorWatch(std::vector<DoorSpan> doors, const DoorOptions& options = {});

  /// Scans in the order of time, at poses T_map_robot; those that are lost tell nothing.
  void add(const PosedScan& scan);

  std::size_t size() const { return doors_.size(); }
  const DoorSpan& door(std::size_t i) const { return doors_[i].where; }
  /// As of the last scan: open from `sure` on, closed below 1 - `sure`. Fades towards unknown while
  /// the door is out of sight.
  DoorState state(std::size_t i) const;
  double open_chance(std::size_t i) const;
  /// Did the last scan tell of it?
  bool in_sight(std::size_t i) const { return doors_[i].in_sight; }

 private:
  struct Watched {
    DoorSpan where;
    double log_odds = 0;  ///< of being open, at the last scan
    bool in_sight = false;
  };
  DoorOptions options_;
  std::vector<Watched> doors_;
  Time last_ = 0;
  bool begun_ = false;
};

/// A door's state from `begin` on, until the next one.
struct DoorStay {
  Time begin = 0;
  DoorState state = DoorState::unknown;
  double open_chance = 0.5;  ///< when it began
};
struct DoorHistory {
  DoorSpan where;
  std::vector<DoorStay> stays;  ///< ascending; unknown ones are those before the door was seen
};
/// What a DoorWatch states over all scans of a site. A state holds until another is stated.
std::vector<DoorHistory> door_histories(const Site& site, const std::vector<DoorSpan>& doors,
                                        const DoorOptions& options = {});

/// Those of find_doors() that the scans state to be open and to be closed, one after the other:
/// what is left out is a wall that errors of poses moved.
std::vector<DoorHistory> doors_that_moved(const Site& site, const DynamicsMap& dynamics,
                                          const DoorOptions& options = {});

}  // namespace majak::map
