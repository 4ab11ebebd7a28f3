// SPDX-License-Identifier: Apache-2.0
// The map with what was found on it, as inline SVG: the grid's picture, trajectories before and
// after, closures, uncertainty ellipses, weak stretches. Layers carry classes that a page switches.
#pragma once

#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/draw/map_layers.hpp"
#include "majak/draw/svg.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::draw {

/// How well a closure fits the final poses: chi-square with 3 degrees of freedom.
enum class Fit { good, strained, poor, rejected };

/// good up to the 95 % quantile, strained up to the 99.9 % one, poor beyond; rejected when
/// disabled.
Fit fit_of(const Constraint& closure);
const char* style_of(Fit fit);  ///< class in the style sheet: "good" ...

/// Trajectories in the map's frame, one point a scan.
struct Paths {
  std::vector<Point> final, front_end, odometry, truth;  ///< empty where there is none
};

/// Odometry and truth are laid onto the first final pose.
Paths paths_of(const Site& site);

struct MapFigure {
  std::string svg;
  std::vector<Layer> layers;  ///< those that are there
  double ellipse_scale = 1;   ///< the ellipses are drawn so many times larger than 95 %
  std::size_t closures_drawn = 0;
};

MapFigure map_figure(const Site& site, const map::OccupancyGrid& grid, const Paths& paths);

/// Only the trajectories, all of them whole, on a metric frame.
std::string path_figure(const Paths& paths);

}  // namespace majak::draw
