// SPDX-License-Identifier: Apache-2.0
// UMBmark, the square-path test (Borenstein and Feng 1996, "Measurement and correction of
// systematic odometry errors in mobile robots"): a robot with two driven wheels drives squares by
// its odometry, some to the left, some to the right, and one measures where it ends. A wrong track
// turns too much or too little in both directions, unequal wheels always pull to the same side, so
// the two come apart (docs/MATH.md 9.4).
#pragma once

#include <vector>

#include "majak/core/site.hpp"
#include "majak/motion/drive_correction.hpp"

namespace majak::motion {

/// Where a robot truly ended less where its odometry says it did, in the axes of its start (x
/// ahead, along the first side).
struct SquareRun {
  bool left = true;  ///< counter-clockwise
  double x = 0;      ///< m
  double y = 0;      ///< m
};

struct Umbmark {
  Learnt turn_scale;      ///< true turn per turn of the odometry
  Learnt turn_per_metre;  ///< rad/m, left positive
  /// With the track (the odometry's): right radius over left one, and the true track in m.
  Learnt wheel_ratio, track;
  Vec2 centre_left = Vec2::Zero(), centre_right = Vec2::Zero();  ///< of the ends, m
  double systematic = 0;  ///< m, of the farther centre: the method's measure of an odometry
  DriveCorrection correction;
};

/// `side` of the square in m, `track` in m or 0 where it is not known. Throws Error without a run
/// in each direction, or for a side that is not positive. Sigmas from the scatter of at least two
/// runs in each direction, else 0.
Umbmark umbmark(const std::vector<SquareRun>& runs, double side, double track = 0);

}  // namespace majak::motion
