// SPDX-License-Identifier: Apache-2.0
// Attributes of cells (thesis p. 24): a map may tell more than where walls are: the floor's colour,
// how well a place reflects, the strength of a radio. A robot that senses it weighs each pose by
// how well the cell there explains what it senses, in any filter:
//
//   P(s | l) = P(s | a(l)),  a(l) the attribute of the cell where l has the sensor
//
//   belief.see(likelihoods of all cells)                                filter::Histogram
//   particles.see([&](const Pose2& l) { return colour(red, floor.at(l.translation())); });
#pragma once

#include <limits>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::match {

/// An attribute that nothing is known of.
inline constexpr float kNoAttribute = std::numeric_limits<float>::quiet_NaN();

struct CellAttributes {
  double resolution = 0.05;  ///< m, side of a cell
  double x0 = 0, y0 = 0;     ///< m, map frame: the corner with the least x and y
  int width = 0, height = 0;
  std::vector<float> values;  ///< row by row, from low y; the number of a class, or a reading

  /// kNoAttribute outside.
  float at(const Vec2& p_map) const;
};

/// A sense that tells which of several classes it sees (a colour), with errors.
struct ClassSense {
  int classes = 2;
  std::vector<double> p;  ///< row: what is there, column: what is told; each row sums to 1

  /// P(told | there). Where nothing is known any class may be there, all alike.
  double operator()(int told, float there) const;
};

/// A sense that reads a number (a reflectivity), with Gaussian errors and some gross ones.
struct NumberSense {
  double sigma = 0.1;   ///< of a reading, in its unit
  double random = 0.1;  ///< share of readings that may be anything ...
  double range = 1;     ///< ... within a range that wide

  /// Density of reading `told`. Where nothing is known it may be anything.
  double operator()(double told, float there) const;
};

}  // namespace majak::match
