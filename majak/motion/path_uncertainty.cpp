// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/path_uncertainty.hpp"

#include <cmath>

namespace majak::motion {

void PathUncertainty::move(const Vec3& twist, const Mat3& noise,
                           const ByParameters& by_parameters) {
  const Mat3 F = adjoint(exp(-twist));  // the old error, seen from the new pose (MATH 6.9)
  const Mat3 J = right_jacobian(twist);
  covariance_ = (F * covariance_ * F.transpose() + J * noise * J.transpose()).eval();
  if (parameters_.rows() > 0) {
    const ByParameters G = J * by_parameters;
    const Mat3 mixed = F * cross_ * G.transpose();
    covariance_ += mixed + mixed.transpose() + G * parameters_ * G.transpose();
    cross_ = (F * cross_ + G * parameters_).eval();
  }
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

Mat3 in_map_axes(const Mat3& covariance, double heading) {
  Mat3 R = Mat3::Identity();
  R(0, 0) = R(1, 1) = std::cos(heading);
  R(1, 0) = std::sin(heading);
  R(0, 1) = -R(1, 0);
  return R * covariance * R.transpose();
}

void describe(OptionFields& fields, OdometryNoise& o) {
  fields.add("odometry_noise.way", o.way, {"m/sqrt(m)", "random, along", 0, 1});
  fields.add("odometry_noise.side", o.side, {"m/sqrt(m)", "random, across", 0, 1});
  fields.add("odometry_noise.turn", o.turn, {"rad/sqrt(rad)", "random, of turns", 0, 1});
  fields.add("odometry_noise.turn_per_way", o.turn_per_way,
             {"rad/sqrt(m)", "random, of the heading along the way", 0, 1});
  fields.add("odometry_noise.scale", o.scale, {"1", "sigma of the scale of ways", 0, 0.5});
  fields.add("odometry_noise.turn_scale", o.turn_scale, {"1", "sigma of that of turns", 0, 0.5});
  fields.add("odometry_noise.drift", o.drift, {"rad/m", "sigma of a pull to one side", 0, 0.5});
}

Mat3 random_part(const OdometryNoise& noise, const Vec3& twist) {
  const double way = twist.head<2>().norm(), turn = std::abs(twist.z());
  return Vec3(noise.way * noise.way * way, noise.side * noise.side * way,
              noise.turn * noise.turn * turn + noise.turn_per_way * noise.turn_per_way * way)
      .asDiagonal();
}

ByParameters constant_part(const Vec3& twist) {
  Mat3 m;
  m << twist.x(), 0, 0, twist.y(), 0, 0, 0, twist.z(), twist.x();
  return m;
}

ParameterCovariance constant_covariance(const OdometryNoise& noise) {
  return Vec3(noise.scale * noise.scale, noise.turn_scale * noise.turn_scale,
              noise.drift * noise.drift)
      .asDiagonal()
      .toDenseMatrix();
}

}  // namespace majak::motion
