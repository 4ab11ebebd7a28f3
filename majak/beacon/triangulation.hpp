// SPDX-License-Identifier: Apache-2.0
// Triangulation: where one stands and which way one faces, from directions to beacons of known
// places. docs/MATH.md "Beacons".
#pragma once

#include <limits>
#include <span>

#include "majak/beacon/fix.hpp"

namespace majak::beacon {

/// A direction to a beacon.
struct BearingTo {
  Vec2 p_map = Vec2::Zero();
  double bearing = 0;  ///< rad in the sensor's frame, counter-clockwise from ahead
  double sigma = 1;    ///< rad
};

struct Triangulation {
  FixProblem problem = FixProblem::too_few;
  Pose2 T_map_sensor{};
  Mat3 covariance = Mat3::Zero();  ///< of (x, y, theta) in the map's axes
  double chi2 = 0;                 ///< sum of squared residuals in sigmas; passes_residual_test()
  int dof = 0;
  double dop = std::numeric_limits<double>::infinity();  ///< m of position a rad of bearing
  /// Mean distance to the beacons over dop: near 1 amidst them, 0 on the danger circle, where the
  /// sensor lies on one circle with all beacons and every place of it explains the bearings.
  double conditioning = 0;
  double nonlinearity = 0;  ///< sigmas, of the residuals within two sigmas; see FixOptions
  Mask used = 0;            ///< the others are gross errors
  int iterations = 0;
};

/// Three bearings, in any order: closed form. More: least squares; gross errors are left out by
/// consensus where there are five and more. Throws Error for more than kMostMeasurements;
/// everything else is told in `problem`.
Triangulation triangulate(std::span<const BearingTo> bearings, const FixOptions& options = {});

}  // namespace majak::beacon
