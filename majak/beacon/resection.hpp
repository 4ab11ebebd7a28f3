// SPDX-License-Identifier: Apache-2.0
// Resection: the robot's pose from what it sees of numbered beacons, ranges and bearings mixed,
// without any map but theirs.
#pragma once

#include <span>

#include "majak/beacon/beacon_map.hpp"
#include "majak/beacon/fix.hpp"
#include "majak/core/event.hpp"

namespace majak::beacon {

struct PoseFix {
  FixProblem problem = FixProblem::too_few;
  Pose2 T_map_robot{};
  Mat3 covariance = Mat3::Zero();  ///< of (x, y, theta) in the map's axes
  double chi2 = 0;                 ///< sum of squared residuals in sigmas; passes_residual_test()
  int dof = 0;
  int unknown = 0;          ///< sightings whose number is not in the map; left out
  int gross = 0;            ///< ranges and bearings left out as gross errors
  double nonlinearity = 0;  ///< sigmas, of the residuals within two sigmas; see FixOptions
};

/// Takes two sightings with range and bearing, or three bearings, and whatever comes with them; all
/// of one moment. Throws Error for more than 32 of known beacons; everything else is told in
/// `problem`.
PoseFix resect(std::span<const BeaconSighting> sightings, const BeaconMap& map,
               const FixOptions& options = {});

}  // namespace majak::beacon
