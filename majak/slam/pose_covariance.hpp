// SPDX-License-Identifier: Apache-2.0
// How sure graph SLAM is of its poses (docs/MATH.md, "How sure the map is"). The graph's own
// marginals count errors that are each edge's own. Two kinds of error all edges have in common: the
// laser's systematic error, and where the laser does not see the motion, the share by which all of
// it may be wrong. How the poses answer to each of them is followed through the graph and added.
#pragma once

#include <vector>

#include "majak/core/site.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/joint_refinement.hpp"
#include "majak/slam/key_scan.hpp"

namespace majak::slam {

/// How far the robot may have moved between two scans beside what is believed, where the laser does
/// not see it; one sigma. With odometry a share of the way, without it what a robot moves in the
/// time.
struct UnseenMotion {
  double way = 0;   ///< m
  double turn = 0;  ///< rad
};
UnseenMotion unseen_motion(const PosedScan& from, const PosedScan& to);

/// Covariances of (x, y, theta) of all key scans in the map's axes, relative to the first.
/// `unseen`: of every key scan, since the one before.
std::vector<Mat3> key_covariances(const KeyScans& keys, const JointRefinement& refined,
                                  const std::vector<UnseenMotion>& unseen);

/// Covariance of a scan that hangs on a key scan and was matched to the finished map; `unseen`
/// since that key scan.
Mat3 scan_covariance(const Mat3& key_covariance, const match::Match& match,
                     const UnseenMotion& unseen);

}  // namespace majak::slam
