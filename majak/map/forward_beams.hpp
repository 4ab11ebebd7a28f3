// SPDX-License-Identifier: Apache-2.0
// A scan's beams as the forward model takes them.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/map/forward_grid.hpp"

namespace majak::map {

class ForwardBeams {
 public:
  static constexpr double kWindow = 4;  ///< standard deviations; farther off none is measured

  ForwardBeams(const ForwardCells& cells, const ForwardGridOptions& options)
      : cells_(cells),
        step_(cells.step()),
        per_cell_(1 / cells.resolution),
        rays_(options.beam_width > 0 ? static_cast<int>(options.rays) : 1),
        options_(options) {}

  /// Calls visit(BeamLine, BeamReading) for each beam that tells something.
  template <class Visit>
  void for_each(const PosedScan& posed, Visit visit) {
    const Scan& scan = posed.scan;
    const Pose2 T_map_laser = posed.estimate.T_map_robot * scan.T_robot_laser;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      double range = static_cast<double>(scan.ranges[i]);
      const bool stopped = range > 0 && range <= options_.max_range;
      if (range < 0) range = -range;  // erased()
      if (!stopped)
        range =
            std::min(options_.max_range,
                     range == static_cast<double>(kNoReturn) ? options_.no_return_range : range);
      if (!(range > 0) || std::isnan(scan.ranges[i])) continue;
      const double angle = T_map_laser.theta + scan.angle(i);
      const Vec2 direction(std::cos(angle), std::sin(angle));
      BeamReading reading = read_beam(range, stopped, step_, kWindow * largest_sigma(options_));
      reading.rays = rays_;
      visit(BeamLine{T_map_laser.translation() * per_cell_, direction * (step_ * per_cell_)},
            reading);
    }
  }

  /// Cells of all rays, step by step.
  void cells_on(const BeamLine& line, const BeamReading& reading,
                std::vector<std::uint32_t>& path) const {
    path.resize(static_cast<std::size_t>(reading.steps) * static_cast<std::size_t>(reading.rays));
    for (int ray = 0; ray < reading.rays; ++ray)
      map::cells_on(cells_, turned(line, ray), reading.steps, path.data() + ray,
                    static_cast<std::size_t>(reading.rays));
  }
  /// One of the rays of a beam.
  BeamLine turned(const BeamLine& line, int ray) const {
    if (rays_ == 1) return line;
    const double turn = options_.beam_width * (ray / (rays_ - 1.0) - 0.5);
    return {line.from, Pose2{0, 0, turn} * line.step};
  }
  int rays() const { return rays_; }

  /// No less than half a cell, else a wall between two steps is none.
  static double largest_sigma(const ForwardGridOptions& options) {
    return std::max(options.sigma, 0.5 * options.resolution);
  }

 private:
  const ForwardCells& cells_;
  double step_, per_cell_;
  int rays_;
  ForwardGridOptions options_;
};

}  // namespace majak::map
