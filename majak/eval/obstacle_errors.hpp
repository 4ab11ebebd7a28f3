// SPDX-License-Identifier: Apache-2.0
// How well mapped landmarks stand where they are: against the true ones, and against themselves.
#pragma once

#include <optional>
#include <vector>

#include "majak/eval/landmarks.hpp"
#include "majak/eval/path_score.hpp"
#include "majak/slam/ekf_slam.hpp"

namespace majak::eval {

/// How well the landmarks stand where they are.
struct ObstacleErrors {
  std::optional<LandmarkMatch> match;    ///< with the true ones, nothing aligned
  std::optional<LandmarkMatch> aligned;  ///< the same after one alignment of the whole map
  SplitHalf split;                       ///< the map by itself: halves of the sightings, one path
  std::optional<SplitHalf> maps;         ///< and two maps of the graph, nothing aligned
  /// Of sightings that are landmarks, against the truth; without it against the map they made.
  std::vector<SightingError> sightings;
};

/// `truth`: of the robot, empty: nobody knows; `trunks`: the true ones, in the same frame.
ObstacleErrors obstacle_errors(const slam::LandmarkMap& map, const Trajectory& truth,
                               const std::vector<Vec2>& trunks, const Pose2& T_robot_laser);

/// Landmarks in one square of 50 m go together. `trunks`: as matched.
Headline headline(const LandmarkMatch& match, const std::vector<Vec2>& trunks);
Headline headline(const SplitHalf& split);

}  // namespace majak::eval
