// SPDX-License-Identifier: Apache-2.0
// Absolute and relative trajectory error against a reference (Sturm et al. 2012, "A benchmark for
// the evaluation of RGB-D SLAM systems"; Geiger et al. 2012 for errors over distances).
#pragma once

#include <vector>

#include "majak/eval/statistics.hpp"
#include "majak/eval/trajectory.hpp"

namespace majak::eval {

enum class Alignment {
  none,        ///< both already in one frame
  first_pose,  ///< the first pair is made equal: errors grow from there, as they did for the robot
  best,        ///< the rigid motion with the least squared distance
};

/// The T_reference_map that minimizes sum |p_reference - T p_map|^2 over the positions: closed form
/// (Umeyama 1991 without scale, in the plane). One pair: that pair's poses are made equal.
Pose2 align(const std::vector<PosePair>& pairs);

struct AbsoluteError {
  ErrorStats translation;  ///< m
  ErrorStats rotation;     ///< rad
  Pose2 T_reference_map;   ///< the alignment used
  std::vector<Pose2>
      residuals;  ///< T_reference_robot^-1 * T_reference_map * T_map_robot, a pair each
};

/// ATE. No pairs give zero counts.
AbsoluteError absolute_error(const std::vector<PosePair>& pairs,
                             Alignment alignment = Alignment::best);

struct RelativeError {
  double distance = 0;     ///< m along the reference
  ErrorStats translation;  ///< m
  ErrorStats rotation;     ///< rad
};

/// RPE: from each pair to the first one at least `distance` further along the reference. Distances
/// that the path does not reach are left out.
std::vector<RelativeError> relative_errors(const std::vector<PosePair>& pairs,
                                           const std::vector<double>& distances);

/// Length of the reference path, m.
double path_length(const std::vector<PosePair>& pairs);

}  // namespace majak::eval
