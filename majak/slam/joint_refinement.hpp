// SPDX-License-Identifier: Apache-2.0
// Joint refinement: the front end's chain, and key scans of other visits against each other, all at
// once (Lu and Milios 1997, with point-to-line pairs found anew in every round). That is where the
// last centimetre is.
#pragma once

#include <cstddef>
#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/graph/pose_graph.hpp"
#include "majak/slam/chain.hpp"
#include "majak/slam/key_scan.hpp"

namespace majak::slam {

struct JointRefinementOptions {
  int rounds = 2;        ///< how often pairs are found anew
  double gate = 0.15;    ///< m, between paired returns, first round; half of it at last
  double sigma = 0.02;   ///< m, of a return off its surface
  double cauchy = 0.03;  ///< m, residual at which a pair of returns counts half
};

struct JointRefinement {
  ChainGraph chain;                ///< of the last round, with the pairs
  std::vector<graph::Edge> pairs;  ///< of that
  std::vector<double> rms;         ///< m, of the paired returns, round by round
};

/// Moves keys[..].T_map_robot to the common optimum. `partners`: for every key scan the older ones
/// that it is paired with.
/// `closures`: edges between key scans that hold loops also where no pair of single scans meets, as
/// when a corridor is driven back; doubted where the rest speaks against them.
JointRefinement refine_jointly(KeyScans& keys,
                               const std::vector<std::vector<std::size_t>>& partners,
                               const std::vector<graph::Edge>& closures,
                               const JointRefinementOptions& options, Threads threads);

}  // namespace majak::slam
