// SPDX-License-Identifier: Apache-2.0
// Landmark graph: the same wheels, landmarks and fixes as in EKF-SLAM, but all poses at once, and
// all equations linear where the result is (Thrun and Montemerlo 2006, GraphSLAM). What was taken
// for two landmarks and is one is found afterwards, and what does not fit is doubted.
#pragma once

#include "majak/core/options.hpp"
#include "majak/slam/ekf_slam.hpp"
#include "majak/slam/wheel_numbers.hpp"

namespace majak::slam {

struct LandmarkGraphOptions {
  int rounds = 12;  ///< at most, of optimising and learning what the wheels count wrongly
  GroundOptions ground;
  double merge_distance = 1;  ///< m, between landmarks that may be one
};

void describe(OptionFields& fields, LandmarkGraphOptions& options);

/// `seen`: by EkfSlam::finish(), with these options. The result has the same scans; landmarks that
/// turned out to be one are one.
LandmarkMap optimize_landmarks(LandmarkMap seen, const EkfSlamOptions& ekf = {},
                               const LandmarkGraphOptions& options = {});

/// As the registry wants it: EKF-SLAM on the way, the graph at the end; the path, without the map.
localize::Localizer landmark_graph(const EkfSlamOptions& ekf, const LandmarkGraphOptions& options,
                                   const Pose2& start);

}  // namespace majak::slam
