// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/wheel_matrix.hpp"

#include <Eigen/QR>
#include <cmath>

#include "majak/core/error.hpp"

namespace majak::motion {

WheelMatrix::WheelMatrix(const std::vector<RollerWheel>& wheels)
    : matrix_(static_cast<Eigen::Index>(wheels.size()), 3) {
  constexpr double kLeastDrive = 1e-6;  // cosine between rollers and heading
  Eigen::Index row = 0;
  for (const RollerWheel& w : wheels) {
    const double drive = std::cos(w.rollers);
    if (std::abs(drive) < kLeastDrive)
      throw Error("a wheel whose rollers stand across its heading drives nothing");
    // Along the rollers' axis nothing slides: n v = n u rolled (MATH 6.6).
    const Vec2 n(std::cos(w.heading + w.rollers), std::sin(w.heading + w.rollers));
    matrix_.row(row++) << n.x() / drive, n.y() / drive,
        (n.y() * w.place.x() - n.x() * w.place.y()) / drive;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(matrix_);
  if (qr.rank() < 3)
    throw Error("these wheels do not determine the robot's motion; three that differ are needed");
  inverse_ = qr.solve(Eigen::MatrixXd::Identity(matrix_.rows(), matrix_.rows()));
}

WheelMatrix::Motion WheelMatrix::forward(const Eigen::VectorXd& rolled) const {
  const Vec3 twist = inverse_ * rolled;
  return {twist, rolled - matrix_ * twist};
}

std::vector<RollerWheel> omni_wheels(int count, double arm) {
  std::vector<RollerWheel> wheels;
  for (int i = 0; i < count; ++i) {
    const double heading = 2 * kPi * i / count;
    wheels.push_back({arm * Vec2(std::sin(heading), -std::cos(heading)), heading, 0});
  }
  return wheels;
}

std::vector<RollerWheel> mecanum_wheels(double length, double width) {
  const double x = length / 2, y = width / 2, tilt = kPi / 4;
  return {{{x, y}, 0, -tilt}, {{x, -y}, 0, tilt}, {{-x, y}, 0, tilt}, {{-x, -y}, 0, -tilt}};
}

}  // namespace majak::motion
