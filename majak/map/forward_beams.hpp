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
      : step_(cells.step()), per_cell_(1 / cells.resolution), options_(options) {}

  /// Calls visit(BeamLine, BeamReading) for each beam that tells something.
  template <class Visit>
  void for_each(const PosedScan& posed, Visit visit) {
    const Scan& scan = posed.scan;
    const Pose2 T_map_laser = posed.estimate.T_map_robot * scan.T_robot_laser;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      double range = static_cast<double>(scan.ranges[i]);
      const bool stopped = range <= options_.max_range;
      if (!stopped)
        range = std::min(options_.max_range, range == static_cast<double>(kNoReturn)
                                                 ? options_.no_return_range
                                                 : options_.max_range);
      if (!(range > 0) || std::isnan(scan.ranges[i])) continue;
      const double angle = T_map_laser.theta + scan.angle(i);
      const Vec2 direction(std::cos(angle), std::sin(angle));
      visit(BeamLine{T_map_laser.translation() * per_cell_, direction * (step_ * per_cell_)},
            read_beam(range, stopped, step_, kWindow * largest_sigma(options_)));
    }
  }

  /// No less than half a cell, else a wall between two steps is none.
  static double largest_sigma(const ForwardGridOptions& options) {
    return std::max(options.sigma, 0.5 * options.resolution);
  }

 private:
  double step_, per_cell_;
  ForwardGridOptions options_;
};

}  // namespace majak::map
