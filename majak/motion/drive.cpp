// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/drive.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace majak::motion {

namespace {

constexpr double kSin120 = std::numbers::sqrt3 / 2;

}  // namespace

Vec3 Differential::forward(const Wheels& w) const {
  return {(w.left + w.right) / 2, 0, (w.right - w.left) / track};
}

Differential::Wheels Differential::inverse(const Vec3& twist) const {
  const double half = twist.z() * track / 2;
  return {twist.x() - half, twist.x() + half};
}

Eigen::Matrix<double, 3, 2> Differential::by_wheels() const {
  Eigen::Matrix<double, 3, 2> J;
  J << 0.5, 0.5, 0, 0, -1 / track, 1 / track;
  return J;
}

ByParameters Differential::by_parameters(const Wheels& w) const {
  ByParameters J(3, 3);
  J << by_wheels() * Eigen::DiagonalMatrix<double, 2>(w.left, w.right),
      Vec3(0, 0, (w.left - w.right) / (track * track));
  return J;
}

Vec3 Ackermann::forward(const Wheels& w) const {
  return {w.way * std::cos(w.steering), 0, w.way * std::sin(w.steering) / wheelbase};
}

Ackermann::Wheels Ackermann::inverse(const Vec3& twist) const {
  if (twist.x() == 0) return {};
  const double steering = std::atan(wheelbase * twist.z() / twist.x());
  return {twist.x() / std::cos(steering), steering};
}

Eigen::Matrix<double, 3, 2> Ackermann::by_wheels(const Wheels& w) const {
  const double c = std::cos(w.steering), s = std::sin(w.steering);
  Eigen::Matrix<double, 3, 2> J;
  J << c, -w.way * s, 0, 0, s / wheelbase, w.way * c / wheelbase;
  return J;
}

ByParameters Ackermann::by_parameters(const Wheels& w) const {
  const Vec3 twist = forward(w);
  ByParameters J(3, 3);
  J << twist, by_wheels(w).col(1), Vec3(0, 0, -twist.z() / wheelbase);
  return J;
}

double Ackermann::radius(double steering) const {
  const double t = std::tan(steering);
  return t == 0 ? std::numeric_limits<double>::infinity() : wheelbase / t;
}

SteeredPair steered_pair(double left, double right, double wheelbase, double track,
                         double tolerance) {
  // Each wheel alone: the middle one stands half a track further from, or nearer to, the centre.
  const double half = track / (2 * wheelbase), l = std::tan(left), r = std::tan(right);
  const double by_left = std::atan2(l, 1 + half * l), by_right = std::atan2(r, 1 - half * r);
  SteeredPair pair;
  pair.disagreement = std::abs(angle_diff(by_left, by_right));
  pair.consistent = pair.disagreement <= tolerance;
  // The mean of the cotangents (MATH 6.4), where there are two of one sign.
  pair.steering = l * r > 0 ? std::atan(2 * l * r / (l + r)) : by_left + (by_right - by_left) / 2;
  return pair;
}

Vec3 Omnidirectional::forward(const Wheels& w) const {
  return {(2 * w[0] - w[1] - w[2]) / 3, (w[1] - w[2]) / (2 * kSin120),
          (w[0] + w[1] + w[2]) / (3 * arm)};
}

Omnidirectional::Wheels Omnidirectional::inverse(const Vec3& t) const {
  const double turn = arm * t.z();
  return {t.x() + turn, -t.x() / 2 + kSin120 * t.y() + turn, -t.x() / 2 - kSin120 * t.y() + turn};
}

Mat3 Omnidirectional::by_wheels() const {
  const double side = 1 / (2 * kSin120), turn = 1 / (3 * arm);
  Mat3 J;
  J << 2.0 / 3, -1.0 / 3, -1.0 / 3, 0, side, -side, turn, turn, turn;
  return J;
}

ByParameters Omnidirectional::by_parameters(const Wheels& w) const {
  ByParameters J(3, 4);
  J << by_wheels() * Eigen::DiagonalMatrix<double, 3>(w[0], w[1], w[2]),
      Vec3(0, 0, -forward(w).z() / arm);
  return J;
}

}  // namespace majak::motion
