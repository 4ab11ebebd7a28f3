// SPDX-License-Identifier: Apache-2.0
// The walls that scans make where they were truly taken: what a map is held against.
#pragma once

#include "majak/core/event.hpp"
#include "majak/map/surfel_map.hpp"

namespace majak::eval {

class TrueWalls {
 public:
  static constexpr double kFar = 1.0;  ///< m, the most that anything counts as off the walls

  void add(const Scan& scan, const Pose2& T_truth_robot);

  /// m, from the nearest wall, across it.
  double off(const Vec2& p) const;

 private:
  map::SurfelMap walls_{{.cell = 0.1, .reach = kFar}};
};

}  // namespace majak::eval
