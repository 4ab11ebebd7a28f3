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

Vec3 Ackermann::forward(const Wheels& w) const {
  return {w.way * std::cos(w.steering), 0, w.way * std::sin(w.steering) / wheelbase};
}

Ackermann::Wheels Ackermann::inverse(const Vec3& twist) const {
  if (twist.x() == 0) return {};
  const double steering = std::atan(wheelbase * twist.z() / twist.x());
  return {twist.x() / std::cos(steering), steering};
}

double Ackermann::radius(double steering) const {
  const double t = std::tan(steering);
  return t == 0 ? std::numeric_limits<double>::infinity() : wheelbase / t;
}

Vec3 Omnidirectional::forward(const Wheels& w) const {
  return {(2 * w[0] - w[1] - w[2]) / 3, (w[1] - w[2]) / (2 * kSin120),
          (w[0] + w[1] + w[2]) / (3 * arm)};
}

Omnidirectional::Wheels Omnidirectional::inverse(const Vec3& t) const {
  const double turn = arm * t.z();
  return {t.x() + turn, -t.x() / 2 + kSin120 * t.y() + turn, -t.x() / 2 - kSin120 * t.y() + turn};
}

}  // namespace majak::motion
