// SPDX-License-Identifier: Apache-2.0
// Elevation: a 2.5-D map, how high the ground is in each square cell, how steep, and whether a
// robot can drive there. Made of the points of a laser that looks down at the ground ahead, nods or
// looks sideways. The robot is taken to move in the plane z = 0. MATH 22.4.
//
//   const Elevation map = build_elevation(points.cloud());
//   map.at(ix, iy).height
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "majak/map/occupancy_grid.hpp"
#include "majak/map/solid.hpp"
#include "majak/map/solid_points.hpp"

namespace majak::map {

struct ElevationOptions {
  double max_step = 0.1;           ///< m, from a cell to the next, that the robot can climb
  double max_slope = radians(15);  ///< rad
  double clearance = 1.2;          ///< m, what is higher above the ground is out of the way
  double slope_radius = 0.3;       ///< m, of the cells that a slope is fitted to
  double sigma = 0.01;             ///< m, of a return's height, at least
};

inline void describe(OptionFields& fields, ElevationOptions& o) {
  fields.add("elevation.max_step", o.max_step, {"m", "that the robot can climb", 0.001, 10});
  fields.add("elevation.max_slope", o.max_slope, {"rad", "that the robot can climb", 0.001, 1.5});
  fields.add("elevation.clearance", o.clearance,
             {"m", "what is higher is out of the way", 0.01, 100});
  fields.add("elevation.slope_radius", o.slope_radius, {"m", "of the cells of a slope", 0.02, 10});
  fields.add("elevation.sigma", o.sigma, {"m", "of a return's height, at least", 1e-4, 1});
}

enum class Ground : std::uint8_t {
  unknown,  ///< nothing was seen at the height of the ground or of the robot
  passable,
  steep,     ///< steeper than max_slope
  step,      ///< a step of more than max_step to a neighbour
  obstacle,  ///< something stands on it, or hangs into the robot's way
};
const char* name_of(Ground ground);

struct ElevationCell {
  Ground ground = Ground::unknown;
  int count = 0;        ///< returns of its ground
  double height = 0;    ///< m, of the ground: the lowest thing seen in the cell
  double variance = 0;  ///< m^2, of that height
  double top = 0;       ///< m, of what stands on the ground without a gap, or hangs into the way
  Vec2 gradient = Vec2::Zero();                          ///< of the height over x and y
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the gradient; 0: not known

  bool slope_known() const { return covariance(0, 0) > 0; }
  double slope() const { return std::atan(gradient.norm()); }  ///< rad
  double slope_sigma() const;                                  ///< rad
};

struct Elevation {
  double resolution = 0.1;           ///< m
  CellBox box;                       ///< cells; (ix, iy) covers [ix, ix + 1) x [iy, iy + 1) of them
  std::vector<ElevationCell> cells;  ///< row by row, from low y

  bool inside(int ix, int iy) const {
    return ix >= box.x0 && iy >= box.y0 && ix < box.x0 + box.width && iy < box.y0 + box.height;
  }
  const ElevationCell& at(int ix, int iy) const;
  const ElevationCell& at(const Vec2& p_map) const;
};

/// Cells are the cubes' columns. Throws Error when an option is out of its range, or the place is
/// larger than 32767 cells along a side.
Elevation build_elevation(const SolidCloud& cloud, const ElevationOptions& options = {});

/// A part for each kind of ground, "passable" ..., a quad a cell at its height: green, yellow where
/// steep, orange where there is a step, red where there is an obstacle.
Solid elevation_solid(const Elevation& elevation);

}  // namespace majak::map
