// SPDX-License-Identifier: Apache-2.0
// Maps that need to be told where the robot was: what they are worth at poses of different worth.
// Table 2 of the thesis puts them beside the methods that find the poses themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/eval/trajectory.hpp"

namespace majak::eval {

enum class PosesFrom : std::uint8_t { truth, graph_slam, wheels };

struct GivenScore {
  double map_error =
      0;  ///< m, mean way of what is drawn from the walls at the true poses; at most 1
  std::size_t elements = 0;  ///< cells that are known, walls
  std::size_t bytes = 0;
  double cpu = 0;  ///< s
  double way = 0;  ///< m, of the truth
};

struct GivenMap {
  const char* name;  ///< "occupancy-grid"
  const char* in_the_thesis;
  const char* elements;  ///< "cells"
  /// `walls`: what the map draws, map frame, m.
  struct Drawn {
    std::vector<Vec2> walls;
    std::size_t elements = 0, bytes = 0;
  };
  Drawn (*draw)(const Site& site);
};
std::span<const GivenMap> given_maps();

/// `site`: graph SLAM's, with the log's odometry; truth in any frame, must not be empty.
GivenScore try_given(const GivenMap& map, const Site& site, const Trajectory& truth,
                     PosesFrom poses, const std::function<double()>& clock);

}  // namespace majak::eval
