// SPDX-License-Identifier: Apache-2.0
// How sure graph SLAM is of its poses. A matcher's own information counts every return as if its
// error were its own; returns of one wall share errors, so what leaves the program is widened here,
// in one place, and held against simulated truth (tests: NEES).
#pragma once

#include <vector>

#include "majak/match/point_to_line.hpp"
#include "majak/slam/joint_refinement.hpp"
#include "majak/slam/key_scan.hpp"

namespace majak::slam {

/// Covariances of (x, y, theta) of all key scans in the map's axes, relative to the first.
std::vector<Mat3> key_covariances(const KeyScans& keys, const JointRefinement& refined);

/// Covariance of a scan that hangs on a key scan and was matched to the finished map.
Mat3 scan_covariance(const Mat3& key_covariance, const match::Match& match,
                     const match::PosePrior& prior);

}  // namespace majak::slam
