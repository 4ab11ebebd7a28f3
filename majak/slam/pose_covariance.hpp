// SPDX-License-Identifier: Apache-2.0
// How sure graph SLAM is of its poses (MATH 3). A matcher's own information counts every return as if
// its error were its own. A range-finder's systematic error is shared by all of them, and along an
// empty corridor the noise of the walls' normals feigns information: both are put right here, in one
// place, and held against simulated truth (tests: NEES).
#pragma once

#include <vector>

#include "majak/core/site.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/front_end.hpp"
#include "majak/slam/joint_refinement.hpp"
#include "majak/slam/key_scan.hpp"
#include "majak/slam/range_bias.hpp"

namespace majak::slam {

/// Information of the step that led to a key scan, in the axes of that scan. `weak`: the match is not
/// to be trusted.
Mat3 step_information(const FrontEndStep& step, bool weak);

/// The same of the laser alone, without the predicted motion and without what normals' noise feigns.
Mat3 laser_step_information(const FrontEndStep& step, bool weak);

/// A matcher's information without what only comes from the noise of the surfaces' normals: along
/// an empty corridor nothing is left (MATH 3.2). Any axes.
Mat3 without_normal_noise(const Mat3& information);

/// How far the robot may have moved where the laser does not see it; one sigma.
struct UnseenMotion {
  double way = 0.01;   ///< m
  double turn = 0.02;  ///< rad
};

/// With odometry: a share of what it says. Without: what a robot moves in that time.
UnseenMotion unseen_motion(const PosedScan& from, const PosedScan& to);

struct KeyUncertainty {
  std::vector<Mat3> covariances;  ///< of (x, y, theta) of all key scans, map's axes, relative to the first
  LearntRangeBias range_bias;     ///< what the edges' disagreement tells of the laser
};

/// `unseen` of each key scan since the one before. Costs one factorisation of the graph.
KeyUncertainty key_uncertainty(const KeyScans& keys, const JointRefinement& refined,
                               const std::vector<UnseenMotion>& unseen);

/// Of a scan that hangs on a key scan and was matched to the finished map; `unseen` since that key
/// scan. Fills covariance, health and weak direction.
void judge(const Mat3& key_covariance, const match::Match& match, const UnseenMotion& unseen,
           Estimate& estimate);

}  // namespace majak::slam
