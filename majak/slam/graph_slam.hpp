// SPDX-License-Identifier: Apache-2.0
// Graph SLAM, the main job: where was the robot, and what does the place look like (Lu and Milios
// 1997; Grisetti et al. 2010, "A tutorial on graph-based SLAM").
//
//   slam::GraphSlam slam({}, {.count = 2});
//   while (auto event = source->next()) slam.add(std::move(*event));
//   Site site = slam.finish();
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/options.hpp"
#include "majak/core/parallel.hpp"
#include "majak/core/site.hpp"
#include "majak/motion/drive_correction.hpp"
#include "majak/motion/odometry_model.hpp"
#include "majak/slam/front_end.hpp"
#include "majak/slam/joint_refinement.hpp"
#include "majak/slam/key_scan.hpp"
#include "majak/slam/loop_closing.hpp"
#include "majak/slam/revisits.hpp"

namespace majak::slam {

struct GraphSlamOptions {
  bool use_odometry = true;  ///< false: the laser alone
  bool close_loops = true;   ///< false: places seen again are not recognised
  FrontEndOptions front_end;
  LoopClosingOptions loops;
  RevisitOptions revisits;
  JointRefinementOptions refinement;
  motion::OdometryModelOptions odometry;
  motion::DriveCorrection drive;  ///< from a calibration; mends the log before anything else
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
  Site finish();

 private:
  void process(std::size_t index);
  void place_scans(const std::vector<Mat3>& covariances);
  Pose2 between_keys(std::size_t scan, double& passed) const;
  void place_scan(std::size_t scan, const std::vector<Mat3>& covariances, const map::SurfelMap& map,
                  const match::AlignOptions& align, match::BeamDirections& directions);
  void record_constraints();

  GraphSlamOptions options_;
  Threads threads_;
  motion::CorrectedDrive drive_;
  motion::OdometryModel odometry_;
  FrontEnd front_end_;
  LoopCloser loop_closer_;
  KeyScans keys_;
  std::vector<std::size_t> key_of_;  ///< key scan that a scan hangs on
  std::size_t processed_ = 0;
  JointRefinement refined_;
  Site site_;
};

}  // namespace majak::slam
