// SPDX-License-Identifier: Apache-2.0
// Graph SLAM, the main job: where was the robot, and what does the place look like (Lu and Milios
// 1997; Grisetti et al. 2010, "A tutorial on graph-based SLAM").
//
//   slam::GraphSlam slam({}, {.count = 2});
//   while (auto event = source->next()) slam.add(std::move(*event));
//   Site site = slam.finish().site;
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/slam/joint_refinement.hpp"
#include "majak/slam/loop_closing.hpp"
#include "majak/slam/mapper.hpp"
#include "majak/slam/revisits.hpp"
#include "majak/slam/scan_chain.hpp"

namespace majak::slam {

struct GraphSlamOptions {
  ScanChainOptions chain;
  bool close_loops = true;  ///< false: places seen again are not recognised
  LoopClosingOptions loops;
  RevisitOptions revisits;
  JointRefinementOptions refinement;
};

void describe(OptionFields& fields, GraphSlamOptions& options);

class GraphSlam {
 public:
  GraphSlam(const GraphSlamOptions& options, Threads threads);

  /// The next event, in the log's order. Gives the newest pose that is known by now, in the map as
  /// it stands; a scan may wait for its odometry.
  std::optional<Estimate> add(Event event);

  /// Everything after the last event: the last loops, the joint refinement, a pose and a covariance
  /// for every scan. Throws Error when there was no scan to work with.
  Mapping finish();

  /// What is known so far.
  const ScanChain& chain() const { return chain_; }

 private:
  std::optional<Estimate> take_scans();

  GraphSlamOptions options_;
  Threads threads_;
  ScanChain chain_;
  LoopCloser loop_closer_;
};

/// The second half of that: key scans that loop closing has placed are refined jointly, every scan
/// gets its pose and covariance, and what speaks for them is recorded. `site`: scans as the front
/// end left them, with their odometry.
void finish_site(Site& site, KeyScans& keys, const LoopCloser& loops,
                 const GraphSlamOptions& options, Threads threads);

}  // namespace majak::slam
