// SPDX-License-Identifier: Apache-2.0
// Landmark graph: the same wheels, landmarks and fixes as in EKF-SLAM, but all poses at once, and
// all equations linear where the result is (Thrun and Montemerlo 2006, GraphSLAM). What was taken
// for two landmarks and is one is found afterwards, and what does not fit is doubted.
#pragma once

#include "majak/core/options.hpp"
#include "majak/slam/ekf_slam.hpp"

namespace majak::slam {

struct LandmarkGraphOptions {
  int rounds = 12;            ///< at most, of optimising and learning what the wheels count wrongly
  double merge_distance = 1;  ///< m, between landmarks that may be one
  double merge_gate = 9.21;   ///< squared Mahalanobis distance, 2 dof
  // As in EkfSlamOptions; one sigma.
  double scale_sigma = 0.03, turn_scale_sigma = 0.05, turn_offset_sigma = 0.004,
         steering_curve_sigma = 0.3, steering_square_sigma = 0.1, crab_sigma = 0.02;
  double gps_sigma = 0.35;       ///< m, of what errs alike in a piece
  double gps_fast_sigma = 0.08;  ///< m
  double antenna_sigma = 3;      ///< m
};

/// `seen`: by EkfSlam::finish(). The result has the same scans; landmarks that turned out to be one
/// are one.
LandmarkMap optimize_landmarks(LandmarkMap seen, const LandmarkGraphOptions& options = {});

}  // namespace majak::slam
