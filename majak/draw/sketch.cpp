// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/sketch.hpp"

#include <Eigen/LU>
#include <cmath>

namespace majak::draw {

Polyline wheel(const Pose2& pose, const Colour& colour, double length) {
  const double half = length / 2, wide = 0.3 * half;
  Polyline box{{}, {colour, 1.4}, true, colour.faint(0.85)};
  for (const Vec2& corner :
       {Vec2(half, wide), Vec2(-half, wide), Vec2(-half, -wide), Vec2(half, -wide)})
    box.points.push_back(point(pose * corner));
  return box;
}

std::vector<Point> arc(const Point& centre, double radius, double from, double to) {
  constexpr int kSteps = 72;
  std::vector<Point> points;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = from + (to - from) * i / kSteps;
    points.push_back({centre.x + radius * std::cos(t), centre.y + radius * std::sin(t)});
  }
  return points;
}

std::vector<Point> way_of(const Vec2& p_robot, const Pose2& pose, const Vec3& twist) {
  constexpr int kSteps = 72;
  std::vector<Point> points;
  for (int i = 0; i <= kSteps; ++i)
    points.push_back(point(pose * exp(twist * i / kSteps) * p_robot));
  return points;
}

std::vector<Point> bent_ellipse(const Pose2& pose, const Mat3& covariance, double chi2) {
  const Eigen::Matrix2d xy = covariance.topLeftCorner<2, 2>();
  const Ellipse e = covariance_ellipse({0, 0}, xy, {}, chi2);
  if (!(e.ry > 0)) return {};
  // The heading's error that goes with an error of place.
  const Eigen::RowVector2d heading = covariance.block<1, 2>(2, 0) * xy.inverse();
  std::vector<Point> points;
  constexpr int kSteps = 120;
  for (int i = 0; i < kSteps; ++i) {
    const double t = 2 * kPi * i / kSteps;
    const Vec2 p = Pose2{0, 0, e.angle} * Vec2(e.rx * std::cos(t), e.ry * std::sin(t));
    points.push_back(point((pose * exp({p.x(), p.y(), heading * p})).translation()));
  }
  return points;
}

}  // namespace majak::draw
