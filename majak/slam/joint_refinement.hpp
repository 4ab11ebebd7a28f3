// SPDX-License-Identifier: Apache-2.0
// Joint refinement: all overlapping key scans against each other at once (Lu and Milios 1997, with
// point-to-line pairs found anew in every round). That is where the last centimetre is.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/graph/pose_graph.hpp"
#include "majak/slam/key_scan.hpp"

namespace majak::slam {

struct JointRefinementOptions {
  int rounds = 2;             ///< how often pairs are found anew
  int near_in_time = 3;       ///< pairs with the key scans 1, 2, 4 ... before
  int near_in_space = 3;      ///< pairs with other visits to the place
  double reach = 4.0;         ///< m, between the robots of a pair
  double gate = 0.15;         ///< m, between paired returns, first round; half of it at last
  double sigma = 0.02;        ///< m, of a return off its surface
  double cauchy = 0.03;       ///< m, residual at which a pair of returns counts half
  double prior = 0.1;         ///< weight of the front end's steps beside the pairs
};

struct JointRefinement {
  std::vector<graph::Edge> edges;  ///< of the last round, indices of key scans
  std::vector<double> rms;         ///< m, of the paired returns, round by round
};

/// Moves keys[..].T_map_robot to the common optimum.
JointRefinement refine_jointly(KeyScans& keys, const JointRefinementOptions& options, Threads threads);

}  // namespace majak::slam
