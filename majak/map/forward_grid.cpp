// SPDX-License-Identifier: Apache-2.0
#include "majak/map/forward_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/map/forward_beams.hpp"

namespace majak::map {

void describe(OptionFields& fields, ForwardGridOptions& o) {
  fields.add("forward_grid.resolution", o.resolution, {"m", "side of a cell", 0.005, 10});
  fields.add("forward_grid.max_range", o.max_range,
             {"m", "a return beyond only tells that all before is free", 0.1, 1000});
  fields.add("forward_grid.no_return_range", o.no_return_range,
             {"m", "a beam without return tells that so much is free; 0: nothing", 0, 1000});
  fields.add("forward_grid.sigma", o.sigma,
             {"m", "of a range, noise and pose, to begin with and at most", 1e-3, 10});
  fields.add("forward_grid.beam_width", o.beam_width,
             {"rad", "whole cone of a beam, of which the first thing stops it", 0, 1});
  fields.add("forward_grid.rays", o.rays,
             {"1", "side by side in the cone; 1: the middle line of the beam", 1, 99});
  fields.add("forward_grid.random", o.random,
             {"1", "share of returns from no surface, to begin with", 1e-6, 0.5});
  fields.add("forward_grid.none", o.none,
             {"1", "share of beams that are lost, to begin with", 1e-6, 0.4});
  fields.add("forward_grid.prior_stop", o.prior_stop,
             {"1", "half of an unseen cell stops a beam with this probability", 1e-6, 0.9});
  fields.add("forward_grid.prior_weight", o.prior_weight,
             {"1", "beams by which the prior is believed", 1e-3, 1000});
  fields.add("forward_grid.rounds", o.rounds, {"1", "of expectation maximization", 1, 1000});
  fields.add("forward_grid.tolerance", o.tolerance,
             {"1", "nats a beam; a round that gains less is the last", 0, 10});
  fields.add("forward_grid.scan_spacing", o.scan_spacing,
             {"m", "a scan nearer to the last one taken is left out unless it turned", 0, 100});
  fields.add(
      "forward_grid.scan_turn", o.scan_turn,
      {"rad", "a scan turned less against the last one taken is left out unless it moved", 0, 4});
}

double ForwardGrid::stop(int ix, int iy) const {
  return -std::expm1(ForwardCells::kStepsPerCell * cells_.log_pass[cells_.index(ix, iy)]);
}

double ForwardGrid::stop_sigma(int ix, int iy) const {
  // (17.6): beta distribution of a step, then across the cell.
  const std::size_t cell = cells_.index(ix, iy);
  const double q = cells_.stop[cell];
  const double steps =
      ForwardCells::kStepsPerCell * (static_cast<double>(evidence_[cell]) + options_.prior_weight);
  const double step_sigma = std::sqrt(q * (1 - q) / (steps + 1));
  const double slope = ForwardCells::kStepsPerCell *
                       std::exp((ForwardCells::kStepsPerCell - 1) * cells_.log_pass[cell]);
  return slope * step_sigma;
}

CellBox ForwardGrid::bounds() const {
  int x_low = std::numeric_limits<int>::max(), x_high = std::numeric_limits<int>::min();
  int y_low = x_low, y_high = x_high;
  std::size_t cell = 1;
  for (const ForwardCells::Place& place : cells_.places)
    for (int y = 0; y < ForwardCells::kTileSize; ++y)
      for (int x = 0; x < ForwardCells::kTileSize; ++x, ++cell) {
        if (!(evidence_[cell] > 0)) continue;
        x_low = std::min(x_low, place.tx * ForwardCells::kTileSize + x);
        x_high = std::max(x_high, place.tx * ForwardCells::kTileSize + x);
        y_low = std::min(y_low, place.ty * ForwardCells::kTileSize + y);
        y_high = std::max(y_high, place.ty * ForwardCells::kTileSize + y);
      }
  if (x_low > x_high) return {};
  return {x_low, y_low, x_high - x_low + 1, y_high - y_low + 1};
}

double ForwardGrid::known_area() const {
  const auto cells =
      std::count_if(evidence_.begin(), evidence_.end(), [](float e) { return e > 0; });
  return static_cast<double>(cells) * resolution() * resolution();
}

std::size_t ForwardGrid::bytes() const {
  return sizeof(*this) + evidence_.size() * (sizeof(float) + 2 * sizeof(double)) +
         cells_.places.size() * (sizeof(ForwardCells::Place) + 4 * sizeof(std::size_t));
}

BeamScore ForwardGrid::log_likelihood(const PosedScan& scan) const {
  BeamScore score;
  ForwardBeams beams(cells_, options_);
  std::vector<std::uint32_t> path;
  std::vector<double> stops;
  beams.for_each(scan, [&](const BeamLine& line, const BeamReading& reading) {
    beams.cells_on(line, reading, path);
    score.log_likelihood +=
        explain(cells_, model_, reading, options_.max_range, path, stops).log_likelihood;
    ++score.beams;
  });
  return score;
}

OccupancyGrid ForwardGrid::log_odds() const {
  OccupancyGrid grid(resolution());
  constexpr double kLimit = 9;  // of the log-odds; an OccupancyGrid holds 32
  std::size_t cell = 1;
  for (const ForwardCells::Place& place : cells_.places)
    for (int y = 0; y < ForwardCells::kTileSize; ++y)
      for (int x = 0; x < ForwardCells::kTileSize; ++x, ++cell) {
        if (!(evidence_[cell] > 0)) continue;
        const double passes = ForwardCells::kStepsPerCell * cells_.log_pass[cell];
        const double odds = std::log(-std::expm1(passes)) - passes;
        grid.set_log_odds(place.tx * ForwardCells::kTileSize + x,
                          place.ty * ForwardCells::kTileSize + y,
                          static_cast<float>(std::clamp(odds, -kLimit, kLimit)));
      }
  return grid;
}

}  // namespace majak::map
