// SPDX-License-Identifier: Apache-2.0
// WheelPath: the way that the wheels say the robot went, corrected, at any time.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/motion/drive_correction.hpp"

namespace majak::motion {

/// What the wheels report of the motion since the sample before, uncorrected.
struct WheelSample {
  Time time = 0;
  Vec3 twist = Vec3::Zero();  ///< m, m, rad of the whole step
  double steering = 0;        ///< rad, held during the step; of an Ackermann drive
  bool jump = false;          ///< the step is none: the counters began anew
};

/// What a log says of its wheels, the direction of travel mended if `reversed`.
std::vector<WheelSample> wheel_samples(const std::vector<Odometry>& odometry, bool reversed);
/// Each record holds until the next one.
std::vector<WheelSample> wheel_samples(const std::vector<WheelMotion>& wheels, double wheelbase);

class WheelPath {
 public:
  /// `wheelbase` of an Ackermann drive (m), whose steering is corrected; 0: of any other.
  WheelPath(const std::vector<WheelSample>& samples, const DriveCorrection& correction,
            double wheelbase = 0);

  struct Point {
    Pose2 pose;       ///< from the first sample
    double way = 0;   ///< m rolled up to here, either way
    double turn = 0;  ///< rad turned up to here, either way
    int jumps = 0;
    bool in_jump = false;  ///< within a step that is none
    /// f (1 - f) of the sample's way and turn, f the part of it before `time`: how much less the
    /// steps to both sides differ, for the sample's noise is shared out by interpolation.
    double split_way = 0, split_turn = 0;
    /// How far off the interpolation may be, by the change of speed around the sample.
    Vec3 doubt = Vec3::Zero();
  };
  /// Nothing outside the samples' times. The lag is the correction's: `time` is the laser's.
  std::optional<Point> at(Time time) const;

 private:
  std::vector<Time> times_;  ///< running maximum of the stamps
  std::vector<Vec3> twists_;
  std::vector<Point> points_;
  Duration lag_ = 0;
};

}  // namespace majak::motion
