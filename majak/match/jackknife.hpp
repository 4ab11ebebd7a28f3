// SPDX-License-Identifier: Apache-2.0
// How sure is a matched pose, judged by what the residuals of this very scan do? Neighbouring beams
// err together (a wall that is a centimetre off in the map, a laser that reads too long at one
// range), so beams are left out by blocks, and the pose's covariance is how much it moves when one
// is (delete-a-group jackknife; Shao and Tu 1995, 2.3; in econometrics the cluster-robust CR3).
#pragma once

#include "majak/core/pose2.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::match {

struct JackknifeOptions {
  int blocks = 8;  ///< into which the points are cut, in the order of the beams, 2 ... 1000
};

/// Squared residuals (m^2) of returns of alike incidence, weighted, and the cos^2 of it.
struct Spread {
  double weight = 0, square = 0, cos2 = 0;
};

struct Jackknife {
  Mat3 covariance = Mat3::Zero();  ///< of the pose, map axes at the robot, as the residuals show it
  Mat3 claimed = Mat3::Zero();  ///< the same if each return erred on its own by AlignOptions::sigma
  Spread head_on, grazing;      ///< within 30 degrees of the normal; more than 60 off it
  // The laser's error may take a step at each doubling of the range, from 0.5 m on.
  Mat3 by_step = Mat3::Zero();  ///< covariance of the pose for steps of 1 m, one sigma
  double steps = 0,
         steps_weight = 0;  ///< their ratio: a step's variance as this scan shows it, m^2
};

/// At the pose where `points` were aligned. `held`: information of the prior, that holds the pose
/// where the scan does not. Both zero where nothing lies on a surface.
Jackknife jackknife(const ScanPoints& points, const map::SurfelMap& map, const Pose2& T_map_robot,
                    const Mat3& held, const AlignOptions& align, const JackknifeOptions& options);

}  // namespace majak::match
