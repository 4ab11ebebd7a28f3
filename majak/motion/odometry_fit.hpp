// SPDX-License-Identifier: Apache-2.0
// What is wrong with the odometry and the laser's place, from steps that both have seen: lag,
// scale, scale of turns and place, together, with a covariance that also holds for noise that is
// correlated from step to step (docs/MATH.md "Odometry").
#pragma once

#include <Eigen/Core>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::motion {

inline constexpr double kGrossTurn = 0.10;  ///< rad, disagreement beyond which a step is an outlier
inline constexpr double kGrossStep = 0.15;  ///< m

/// A step from one scan to the next, as seen from both sides.
struct ComparedStep {
  Pose2 laser;          ///< by the laser, of the nominal robot
  Pose2 wheels;         ///< by the odometry, at the lag supposed
  Vec3 wheels_per_lag;  ///< derivative of `wheels` by the lag, per s
  Vec3 neighbours;      ///< mean of the laser's steps before and after
  Vec3 change;          ///< half of: the laser's velocity in the step after less that before
};

/// laser step = D^-1 * (scale, turn_scale)(wheel step, lag later) * D
struct OdometryFaults {
  double lag = 0;  ///< s, added to that with which the steps were made
  double scale = 1, turn_scale = 1;
  Pose2 D;  ///< the laser's true place against the nominal one
};

struct OdometryFit {
  OdometryFaults faults;
  /// Standard deviations, in the same order: lag, scale, turn scale, D.
  double lag = 0, scale = 0, turn_scale = 0;
  Vec3 D = Vec3::Zero();
};

/// One Newton step from `start`. What the steps do not determine stays where the nominal values
/// are, within the width of what is usual: 0.3 s, 10 %, 10 %, 0.1 m, 0.05 rad; its sigma says so.
/// Sigmas are left at 0 unless `with_sigma`.
OdometryFit fit_odometry(const std::vector<ComparedStep>& steps, const OdometryFaults& start,
                         bool with_sigma);

}  // namespace majak::motion
