// SPDX-License-Identifier: Apache-2.0
// How an estimate that is never corrected drifts from key scan to key scan, and how the error that
// shows where a loop closes is shared out along it (docs/MATH.md, "The hybrid").
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "majak/slam/key_scan.hpp"

namespace majak::slam {

struct DriftOptions {
  double match_share = 0.25;   ///< of a match's covariance: most of its error does not add up,
                               ///< because a local map is the mean of many key scans
  double scale_sigma = 0.015;  ///< of the way that nothing but the wheels counts, one sign a run
  double weak_way = 0.1;       ///< m, of a step that is not to be trusted
  double weak_turn = 0.04;     ///< rad
};

/// Of the step to a key scan, in its own axes.
struct Drift {
  Mat3 covariance = Mat3::Zero();
  Mat3 by_motion = Mat3::Zero();  ///< share of the step that the motion tells, not the laser
};
Drift drift_to(const KeyScan& key, const DriftOptions& options);

/// Poses of a chain (the first is held) when its last one is moved to `end`: the most likely ones
/// where the step to pose k has covariance[k] in the axes of pose k, to first order in the move.
std::vector<Pose2> share_out(std::span<const Pose2> chain, std::span<const Mat3> covariances,
                             const Pose2& end);

}  // namespace majak::slam
