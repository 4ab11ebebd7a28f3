// SPDX-License-Identifier: Apache-2.0
// What the readings of wheels are wrong by, carried to the twist of a step by the drive's
// derivatives: the noise that PathUncertainty adds up.
#pragma once

#include "majak/core/options.hpp"
#include "majak/motion/drive.hpp"
#include "majak/motion/path_uncertainty.hpp"
#include "majak/motion/wheel_matrix.hpp"

namespace majak::motion {

/// Random errors of single wheels; a step's variance is slip^2 times the way rolled.
struct WheelNoise {
  double slip = 0.005;      ///< m per sqrt(m), each wheel on its own
  double steering = 0.002;  ///< rad, each reading
};

/// Covariance of a step's twist.
Mat3 random_part(const WheelNoise& noise, const Differential& drive,
                 const Differential::Wheels& wheels);
Mat3 random_part(const WheelNoise& noise, const Ackermann& drive, const Ackermann::Wheels& wheels);
Mat3 random_part(const WheelNoise& noise, const Omnidirectional& drive,
                 const Omnidirectional::Wheels& wheels);
Mat3 random_part(const WheelNoise& noise, const WheelMatrix& drive, const Eigen::VectorXd& rolled);

/// A car on the road that reports speed and steering.
struct CarNoise {
  double way = 0.03;               ///< m per sqrt(m)
  double steering = 0.01;          ///< rad sqrt(m): over a way d its mean errs by this / sqrt(d)
  double scale = 0.02;             ///< sigma of the constant scale of speed
  double steering_offset = 0.005;  ///< rad, sigma
  double wheelbase = 0.01;         ///< sigma per m
};
void describe(OptionFields& fields, CarNoise& options);

Mat3 random_part(const CarNoise& noise, const Ackermann& drive, const Ackermann::Wheels& wheels);
/// Covariance of the parameters of Ackermann::by_parameters().
ParameterCovariance constant_covariance(const CarNoise& noise, const Ackermann& drive);

}  // namespace majak::motion
