// SPDX-License-Identifier: Apache-2.0
// What the forward model asks of its cells, and what a beam makes of them. A beam is looked at in
// steps of half a cell; each may stop it (docs/MATH.md 17).
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::map {

/// Sparse tiles; the cells of all tiles lie in one row each of `stop` and `log_pass`. Number 0 is
/// every cell outside.
struct ForwardCells {
  static constexpr int kTileBits = 6;
  static constexpr int kTileSize = 1 << kTileBits;
  static constexpr std::uint32_t kTileCells = 1U << (2 * kTileBits);
  static constexpr double kStepsPerCell = 2;
  struct Place {
    int tx, ty;
    bool operator==(const Place&) const = default;
  };

  double resolution = 0.05;                                ///< m
  std::unordered_map<std::uint64_t, std::uint32_t> first;  ///< number of a tile's first cell
  std::vector<Place> places;                               ///< of the tiles in their order
  std::vector<double> stop{0};      ///< probability that a step in the cell stops a beam
  std::vector<double> log_pass{0};  ///< log(1 - stop)

  double step() const { return resolution / kStepsPerCell; }
  /// 0 when missing.
  std::uint32_t tile(int tx, int ty) const;
  /// Makes it when missing; the cells are like those outside.
  void add_tile(int tx, int ty);
  std::uint32_t index(int ix, int iy) const;
  void set(std::size_t cell, double stop_probability);
};

/// From where a ray goes where to, in cells.
struct BeamLine {
  Vec2 from;
  Vec2 step;  ///< of half a cell
};

/// Numbers of the cells under the middles of the first `steps` steps, written to every `pitch`th
/// place from `path` on. The line may not leave the +- 2^30 cells around the origin.
void cells_on(const ForwardCells& cells, const BeamLine& line, int steps, std::uint32_t* path,
              std::size_t pitch = 1);
/// Tiles under them, appended where they change.
void tiles_on(const BeamLine& line, int steps, std::vector<ForwardCells::Place>& tiles);

struct ForwardModel;

/// What was measured, in steps.
struct BeamReading {
  double range = 0;     ///< m
  bool stopped = true;  ///< false: it went on beyond `range`, or was lost
  int before = 0;       ///< steps that did not stop it, if it was not astray
  int steps = 0;        ///< all that matter
  int rays = 1;         ///< cells in each step
};
/// `window`: m, how far off its stop a beam may measure.
BeamReading read_beam(double range, bool stopped, double step, double window);

/// Posterior of what became of one beam.
struct BeamCause {
  double log_likelihood = 0;  ///< nats; of a density in 1/m
  double seen = 0;            ///< it went by the map: to a stop, or to the end of what matters
  double squares = 0;         ///< m^2, (range - stop)^2 times its probability, summed over stops
};

/// The E-step. `path` are the reading's cells, step by step; `stops` gets the probability that the
/// beam was stopped by each of the cells from step reading.before on.
BeamCause explain(const ForwardCells& cells, const ForwardModel& model, const BeamReading& reading,
                  double max_range, const std::vector<std::uint32_t>& path,
                  std::vector<double>& stops);

}  // namespace majak::map
