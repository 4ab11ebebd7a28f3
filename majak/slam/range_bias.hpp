// SPDX-License-Identifier: Apache-2.0
// What a range-finder's systematic error does to a relative pose. All returns of a run are too long
// or too short by the same law, so this error does not average away over returns, scans or pairs:
// it has to be followed through the whole graph (MATH 5).
#pragma once

#include <Eigen/Core>

#include "majak/core/pose2.hpp"
#include "majak/slam/key_scan.hpp"

namespace majak::slam {

/// What a laser could see: its field of view and the spacing of its beams, from its returns.
struct LaserView {
  double reach = 1;    ///< cosine of the widest bearing with a return
  double step = 0.02;  ///< rad, between neighbouring beams
};
LaserView laser_view(const KeyScan& key);

/// The error's law, in columns of one sigma each: a constant, and hats over the ranges 0, 4, 8, 12
/// m and from 16 m on. The LMS-291's sheet bounds the whole by 35 mm, which is taken for 2.6 sigma.
struct RangeBias {
  static constexpr int kCount = 6;
  static constexpr double kConstant = 0.012;  ///< m
  static constexpr double kHat = 0.006;       ///< m
  static constexpr double kSpacing = 4.0;     ///< m, between hats
  using Weights = Eigen::Matrix<double, kCount, 1>;
  using Columns = Eigen::Matrix<double, 3, kCount>;

  /// Error (m) of a range under each column.
  static Weights at(double range);

  /// How the relative pose T_target_source, measured point to line with pairs up to `gate` m, is
  /// shifted under each column, in the axes of the source.
  static Columns shift(const KeyScan& target, const LaserView& view, const KeyScan& source,
                       double gate);
};

}  // namespace majak::slam
