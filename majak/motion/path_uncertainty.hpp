// SPDX-License-Identifier: Apache-2.0
// PathUncertainty: how unsure a pose becomes that is only counted up. Errors of two kinds: random
// ones, new in every step, grow with the root of the way; constant ones (a wheel that is larger
// than it is believed to be) grow with the way itself. Both are carried along exactly to first
// order in the axes of the robot, T = T_estimated * exp(error), where the ellipse of (x, y) bends
// into the well known banana by itself (MATH "Drives and dead reckoning").
#pragma once

#include <Eigen/Core>

#include "majak/core/options.hpp"
#include "majak/core/pose2.hpp"
#include "majak/motion/drive.hpp"

namespace majak::motion {

using ParameterCovariance =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

class PathUncertainty {
 public:
  /// Starts at a known pose; `parameters`: covariance of what is constantly wrong.
  explicit PathUncertainty(const ParameterCovariance& parameters = {})
      : parameters_(parameters), cross_(ByParameters::Zero(3, parameters.rows())) {}

  /// The robot moves by exp(twist); the twist itself errs by `noise` and by `by_parameters` times
  /// the parameters' errors.
  void move(const Vec3& twist, const Mat3& noise, const ByParameters& by_parameters = {});

  /// Of the error in the robot's axes: T_true = T_estimated * exp(error).
  const Mat3& covariance() const { return covariance_; }

 private:
  ParameterCovariance parameters_;
  Mat3 covariance_ = Mat3::Zero();
  ByParameters cross_;  ///< E[pose error * parameter error']
};

/// From the robot's axes to the map's, as Estimate has it: of (x, y, theta) to first order.
Mat3 in_map_axes(const Mat3& covariance, double heading);

/// What a robot's odometry is wrong by where nothing is known of its wheels. The defaults are those
/// of an indoor robot of half a metre; `majak calibrate` measures them.
struct OdometryNoise {
  double way = 0.005;           ///< m per sqrt(m): slip along
  double side = 0.002;          ///< m per sqrt(m): slip across
  double turn = 0.01;           ///< rad per sqrt(rad)
  double turn_per_way = 0.018;  ///< rad per sqrt(m)
  double scale = 0.005;         ///< sigma of the constant scale of ways, per unit
  double turn_scale = 0.011;    ///< sigma of the constant scale of turns, per unit
  double drift = 0.0035;        ///< rad per m: sigma of the constant pull to one side
};
void describe(OptionFields& fields, OdometryNoise& options);

/// Covariance of the random part of a step's twist.
Mat3 random_part(const OdometryNoise& noise, const Vec3& twist);
/// Derivatives of a step's twist by (scale, turn scale, drift), and their covariance.
ByParameters constant_part(const Vec3& twist);
ParameterCovariance constant_covariance(const OdometryNoise& noise);

}  // namespace majak::motion
