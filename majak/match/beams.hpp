// SPDX-License-Identifier: Apache-2.0
// Beams: those beams of a scan that a likelihood looks at, spread evenly over it, in the robot's
// frame.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/event.hpp"

namespace majak::match {

struct BeamsOptions {
  int most = 180;           ///< beams kept, 0: all
  double min_range = 0.05;  ///< m, shorter returns are the robot itself
  double max_range = 60;    ///< m, longer returns count as none
};

/// One array a quantity. Invalid beams are left out.
struct Beams {
  Vec2 laser = Vec2::Zero();    ///< m, where they begin
  std::vector<float> cos, sin;  ///< their directions
  std::vector<float> range;     ///< m; kNoReturn where nothing came back
  std::vector<float> x, y;      ///< m, end points of the first `returns` beams
  std::size_t returns = 0;      ///< beams with a return come first
  double max_range = 0;         ///< m, what the laser reaches at most

  std::size_t size() const { return range.size(); }
};

Beams beams(const Scan& scan, const BeamsOptions& options = {});

}  // namespace majak::match
