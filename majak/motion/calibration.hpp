// SPDX-License-Identifier: Apache-2.0
// Calibration: what is wrong with the wheels, the laser's place and the clock, by joint least
// squares between the wheels' steps and those of the laser's final poses, all in the log
// (docs/MATH.md "Calibration").
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/motion/drive_correction.hpp"
#include "majak/motion/step_noise.hpp"
#include "majak/motion/wheel_path.hpp"

namespace majak::motion {

/// The unknowns, in this order in all vectors and matrices.
enum class Unknown { scale, turn_scale, uneven, laser_x, laser_y, laser_theta, lag };
inline constexpr std::size_t kUnknowns = 7;
using Vec7 = Eigen::Matrix<double, 7, 1>;
using Mat7 = Eigen::Matrix<double, 7, 7>;

struct CalibrationOptions {
  double track = 0;      ///< m between the wheels as the odometry believes; 0: not known
  double wheelbase = 0;  ///< m of an Ackermann drive as its maker says; 0: another drive
  bool timed = true;     ///< false: the stamps tell only the order, no lag is sought
  double start_lag = 0;  ///< s, within 0.15 s of the truth
  Pose2 T_robot_laser;   ///< nominal
  int rounds = 12;       ///< of Newton steps, 6 ... 20; in the first half the noise is learnt, too
  double noise_factor = 1.03;  ///< to which the noise is sought, 1.01 ... 1.2
  /// m or rad between the laser poses that are used: longer steps tell the slow part of the wheels'
  /// error, on which drift depends, shorter ones the lag and the place of the laser.
  double least_way = 0.5, least_turn = 0.5;
};

struct Calibration {
  DriveCorrection correction;  ///< what is determined; the rest at its nominal value
  /// Value and sigma of each unknown, `used` if determined. uneven: rad/m of unequal wheels, or rad
  /// of steering; the laser's are T_robot_laser.
  std::array<Learnt, kUnknowns> values;
  Mat7 covariance = Mat7::Zero();
  Learnt wheel_difference;  ///< right radius over left radius, less 1; needs the track
  Learnt length;            ///< m, track or wheelbase
  StepNoise noise;
  std::size_t steps = 0, left_out = 0;  ///< steps compared; of these beyond the gate
  double mean_nis = 0;                  ///< 3 if the noise is right
  double log_likelihood = 0;
  double way = 0, turned = 0;         ///< m and rad, by the wheels, either way
  std::vector<std::string> not_told;  ///< what this log does not determine, and what to drive

  /// Slips are rare; if a quarter of the steps are none, the laser's poses are wrong.
  bool contradicted() const { return 4 * left_out > steps; }

  const Learnt& operator[](Unknown unknown) const {
    return values[static_cast<std::size_t>(unknown)];
  }
};

/// Laser poses in the log's order. Throws Error where fewer than forty steps can be compared.
Calibration calibrate(const std::vector<LaserPose>& laser, const std::vector<WheelSample>& wheels,
                      const CalibrationOptions& options);

}  // namespace majak::motion
