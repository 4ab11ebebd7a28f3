// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/wheel_noise.hpp"

#include <cmath>

namespace majak::motion {
namespace {

/// J diag(variances) J'
template <class Jacobian, class Variances>
Mat3 carried(const Jacobian& J, const Variances& variances) {
  return J * variances.asDiagonal() * J.transpose();
}

double square(double v) { return v * v; }

}  // namespace

Mat3 random_part(const WheelNoise& noise, const Differential& drive,
                 const Differential::Wheels& w) {
  return carried(drive.by_wheels(),
                 Vec2(square(noise.slip) * Vec2(std::abs(w.left), std::abs(w.right))));
}

Mat3 random_part(const WheelNoise& noise, const Ackermann& drive, const Ackermann::Wheels& w) {
  return carried(drive.by_wheels(w),
                 Vec2(square(noise.slip) * std::abs(w.way), square(noise.steering)));
}

Mat3 random_part(const WheelNoise& noise, const Omnidirectional& drive,
                 const Omnidirectional::Wheels& w) {
  return carried(drive.by_wheels(),
                 Vec3(square(noise.slip) * Vec3(std::abs(w[0]), std::abs(w[1]), std::abs(w[2]))));
}

Mat3 random_part(const WheelNoise& noise, const WheelMatrix& drive, const Eigen::VectorXd& rolled) {
  return carried(drive.by_wheels(), Eigen::VectorXd(square(noise.slip) * rolled.cwiseAbs()));
}

void describe(OptionFields& fields, CarNoise& o) {
  fields.add("car_noise.way", o.way, {"m/sqrt(m)", "random, along", 0, 10});
  fields.add("car_noise.steering", o.steering, {"rad sqrt(m)", "random, of the steering", 0, 1});
  fields.add("car_noise.scale", o.scale, {"1", "sigma of the scale of speed", 0, 0.5});
  fields.add("car_noise.steering_offset", o.steering_offset, {"rad", "sigma", 0, 0.5});
  fields.add("car_noise.wheelbase", o.wheelbase, {"1", "sigma per m of the wheelbase", 0, 0.5});
}

Mat3 random_part(const CarNoise& noise, const Ackermann& drive, const Ackermann::Wheels& w) {
  const double way = std::abs(w.way * std::cos(w.steering));  // of the axle's centre
  if (way == 0) return Mat3::Zero();
  return carried(drive.by_wheels(w), Vec2(square(noise.way) * way, square(noise.steering) / way));
}

ParameterCovariance constant_covariance(const CarNoise& noise, const Ackermann& drive) {
  const Vec3 sigma(noise.scale, noise.steering_offset, noise.wheelbase * drive.wheelbase);
  return sigma.cwiseAbs2().asDiagonal().toDenseMatrix();
}

}  // namespace majak::motion
