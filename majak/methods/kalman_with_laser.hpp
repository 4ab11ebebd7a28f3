// SPDX-License-Identifier: Apache-2.0
// The Kalman filter with the laser as one more account of the motion: each scan is matched to a
// local map of those before (slam::FrontEnd), and the step it tells is relative information beside
// that of the wheels. No map is kept and no place recognised.
#pragma once

#include "majak/localize/kalman.hpp"
#include "majak/slam/front_end.hpp"

namespace majak::methods {

struct KalmanWithLaserOptions {
  localize::KalmanOptions kalman;
  slam::FrontEndOptions front_end;
};

localize::Localizer kalman_with_laser(const KalmanWithLaserOptions& options, const Pose2& start,
                                      const beacon::BeaconMap& beacons);

}  // namespace majak::methods
