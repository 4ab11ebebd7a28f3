// SPDX-License-Identifier: Apache-2.0
// Forward-model grid (Thrun, "Learning occupancy grid maps with forward sensor models", Autonomous
// Robots 15, 2003): not each cell by itself, but the one map under which all that was measured is
// likeliest. A beam is stopped by one of the cells that it meets, or is astray; which, is found by
// expectation maximization together with the map and the sensor's own numbers (docs/MATH.md 17).
//
//   const ForwardGrid grid = build_forward_grid(site);
//   grid.stop(ix, iy);          // probability that a beam across the cell ends in it
//   grid.log_likelihood(scan);  // of a scan that it has not seen, too
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/map/forward_cells.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::map {

struct ForwardGridOptions {
  double resolution = 0.05;      ///< m, side of a cell
  double max_range = 30.0;       ///< m, a return beyond only tells that all before is free
  double no_return_range = 0.0;  ///< m, a beam without return tells so of so much; 0: nothing
  double sigma = 0.06;           ///< m, of a range (noise and pose) to begin with, and at most
  double beam_width = 0;         ///< rad, of the whole cone; the first thing in it stops the beam
  double rays = 1;               ///< side by side in the cone; 1: the beam is its middle line
  double random = 0.05;          ///< share of returns that come from no surface, to begin with
  double none = 0.01;            ///< share of beams that are lost on their way, to begin with
  double prior_stop = 0.02;      ///< an unseen half of a cell stops a beam with this probability
  double prior_weight = 0.5;     ///< beams (each of two halves) by which that is believed
  double rounds = 40;            ///< of expectation maximization at most
  double tolerance = 3e-4;       ///< nats a beam; a round that gains less is the last
  double scan_spacing = 0.15;    ///< m, a scan nearer than this to the last one taken and
  double scan_turn = 0.15;       ///< rad, turned less than this against it is left out
};
void describe(OptionFields& fields, ForwardGridOptions& options);

/// What is known of the sensor besides the map.
struct ForwardModel {
  double sigma = 0.06;   ///< m
  double random = 0.05;  ///< share of beams that return from anywhere
  double none = 0.01;    ///< share of beams that get lost
};

/// Of densities in 1/m.
struct BeamScore {
  double log_likelihood = 0;  ///< nats
  std::size_t beams = 0;
};

class ForwardGrid {
 public:
  double resolution() const { return cells_.resolution; }
  const ForwardModel& model() const { return model_; }
  /// Has any beam told of this cell?
  bool known(int ix, int iy) const { return evidence_[cells_.index(ix, iy)] > 0; }
  /// Probability that a beam straight across the cell ends in it; the prior's where unknown.
  double stop(int ix, int iy) const;
  /// Standard deviation of stop(), as if it were known which cell stopped each beam.
  double stop_sigma(int ix, int iy) const;
  /// Tight around all known cells; empty when there are none. Costs a walk over the tiles.
  CellBox bounds() const;
  double known_area() const;  ///< m^2
  std::size_t bytes() const;
  std::size_t scans_drawn() const { return scans_drawn_; }
  /// Log-posterior after each round, but for a constant; never falls.
  const std::vector<double>& posterior() const { return posterior_; }
  /// Of the scans that made the map.
  const BeamScore& score() const { return score_; }

  /// Of the beams of a scan from its pose, whether or not the map was made from it. Beams of which
  /// the map was told nothing by its options (without return, say) do not count.
  BeamScore log_likelihood(const PosedScan& scan) const;

  /// The same map as log-odds of stop(), for all that reads occupancy grids.
  OccupancyGrid log_odds() const;

 private:
  friend class ForwardFit;
  ForwardCells cells_;
  std::vector<float> evidence_;  ///< beams that told of each of cells_
  ForwardModel model_;
  ForwardGridOptions options_;
  std::size_t scans_drawn_ = 0;
  std::vector<double> posterior_;
  BeamScore score_;
};

/// The same bytes for any number of threads. Throws Error when an option is out of its range.
ForwardGrid build_forward_grid(const Site& site, const ForwardGridOptions& options = {},
                               Threads threads = {});

/// The likeliest forward grid in which cells of like log-odds (to 0.25; unknown ones are a kind of
/// their own) are alike: what a log-odds grid is worth as a forward model, at its best.
ForwardGrid fit_to_log_odds(const OccupancyGrid& log_odds, const Site& site,
                            const ForwardGridOptions& options = {}, Threads threads = {});

}  // namespace majak::map
