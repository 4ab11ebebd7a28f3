// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/range_bias.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace majak::slam {
namespace {

constexpr std::size_t kStride = 4;  // every fourth return tells enough
constexpr double kGrazing = 0.05;   // cosine; a surface seen flatter is seen from its other side
constexpr double kUndetermined =
    1e-3;  // share of the returns that would have to tell of a direction

}  // namespace

LaserView laser_view(const KeyScan& key) {
  const double c = std::cos(key.T_robot_laser.theta), s = std::sin(key.T_robot_laser.theta);
  LaserView view;
  Vec2 before = Vec2::Zero();
  for (std::size_t i = 0; i < key.points.size(); ++i) {
    const Vec2 ray =
        (Vec2(key.points.x[i], key.points.y[i]) - key.T_robot_laser.translation()).normalized();
    view.reach = std::min(view.reach, c * ray.x() + s * ray.y());
    if (i > 0)
      view.step = std::min(view.step, std::abs(before.x() * ray.y() - before.y() * ray.x()));
    before = ray;
  }
  view.step = std::max(view.step, 1e-3);
  return view;
}

RangeBias::Weights RangeBias::at(double range) {
  Weights w = Weights::Zero();
  const double knot = std::clamp(range / kSpacing, 0.0, static_cast<double>(kCount - 2));
  const int k = std::min(static_cast<int>(knot), kCount - 3);
  w(0) = kConstant;
  w(1 + k) = kHat * (1 - (knot - k));
  w(2 + k) = kHat * (knot - k);
  return w;
}

// A return of the source is shifted along its ray, and so is the target's surface along the
// target's; what matters is what both do along the normal.
RangeBias::Columns RangeBias::shift(const KeyScan& target, const LaserView& view,
                                    const KeyScan& source, double gate) {
  const Vec2 own = source.T_robot_laser.translation();
  const Pose2 other = between(source.T_map_robot, target.T_map_robot) * target.T_robot_laser;
  const Vec2 ahead(std::cos(other.theta), std::sin(other.theta));
  Mat3 h = Mat3::Zero();
  Columns g = Columns::Zero();
  for (std::size_t i = 0; i < source.points.size(); i += kStride) {
    const Vec2 p(source.points.x[i], source.points.y[i]),
        n(source.points.nx[i], source.points.ny[i]);
    if (n.isZero()) continue;
    const Vec2 ray = p - own, other_ray = p - other.translation();
    const double range = ray.norm(), other_range = other_ray.norm();
    const double facing = -n.dot(other_ray) / other_range;
    if (facing < kGrazing || ahead.dot(other_ray) < view.reach * other_range) continue;
    // Far along a wall the target's returns lie apart, and few of the source's come near to one.
    const double weight = std::min(1.0, 2 * gate * facing / (view.step * other_range));
    const Vec3 j(n.x(), n.y(), n.y() * p.x() - n.x() * p.y());
    h += weight * j * j.transpose();
    g += weight * j * (n.dot(ray) / range * at(range) + facing * at(other_range)).transpose();
  }
  h += (kUndetermined * h.trace() + 1e-3) * Mat3::Identity();
  return -h.llt().solve(g);
}

}  // namespace majak::slam
