// SPDX-License-Identifier: Apache-2.0
// Globally consistent range scan alignment (Lu and Milios 1997; thesis, table 2): scans are matched
// in pairs, each pair says with its covariance where one stands seen from the other, and one linear
// system gives all poses and how sure they are. Pairs are those that overlap by the present poses:
// what drift has torn apart is never held together, so that no ring closes by itself
// (docs/MATH.md, "Lu and Milios").
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/graph/pose_graph.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

struct ConsistentPoses {
  std::vector<Pose2> poses;
  std::vector<Mat3> covariances;  ///< of (x, y, theta), map axes, given the first pose
  int rounds = 0;                 ///< linear systems solved
  bool converged = false;         ///< the last one moved nothing
};

struct ConsistentPosesOptions {
  int max_rounds = 20;      ///< linear systems, 1 ... 1000
  double tolerance = 1e-9;  ///< m and rad; poses that move less stand still
};

/// The poses that agree best with all relations, the first one fixed, and their covariance. Throws
/// Error where graph::check() does, and if the relations leave a pose open.
ConsistentPoses consistent_poses(std::span<const graph::Edge> relations, std::vector<Pose2> guess,
                                 const ConsistentPosesOptions& options = {});

struct LuMiliosOptions {
  int rounds = 5;        ///< how often all pairs are matched anew, at most
  double still = 0.001;  ///< m and rad, root mean square; poses that move less stand still
  double reach = 4.0;    ///< m, between the robots of a pair
  double overlap =
      0.6;            ///< share of returns on surfaces of the other scan from which on two overlap
  int partners = 12;  ///< later scans that one is matched to beside the next, spread evenly
  double trusted_score = 0.8;  ///< share of returns on the other scan for a match to be believed
  match::AlignOptions align;
};

void describe(OptionFields& fields, LuMiliosOptions& options);

struct PairAlignment {
  std::vector<graph::Edge> relations;  ///< of the last round: steps, then matched pairs
  std::vector<Mat3> covariances;       ///< of the poses of the key scans
};

/// Moves keys[..].T_map_robot until all pairs of key scans that overlap agree best.
PairAlignment align_pairs(KeyScans& keys, const LuMiliosOptions& options, Threads threads);

class LuMilios {
 public:
  LuMilios(const ScanChainOptions& chain, const LuMiliosOptions& options, Threads threads);

  /// Gives no estimate: the work is done after the run.
  std::optional<Estimate> add(Event event);
  Mapping finish();

  /// What is known so far.
  const ScanChain& chain() const { return chain_; }

 private:
  void place_scans(const std::vector<Mat3>& key_covariances);
  void record_constraints(const std::vector<graph::Edge>& relations);

  LuMiliosOptions options_;
  Threads threads_;
  ScanChain chain_;
};

}  // namespace majak::slam
