// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/corners.hpp"

#include <Eigen/LU>
#include <cmath>
#include <optional>

namespace majak::slam {
namespace {

// m^2, of a wall's offset at a point of it: its own and that of its turn.
double offset_variance(const map::Segment& wall, const Vec2& at, double wall_sigma) {
  const Vec2 by(1, (at - wall.middle()).dot(wall.direction()));
  return by.dot(wall.covariance * by) + wall_sigma * wall_sigma;
}

// p = A^-1 (rho_1, rho_2) with the unit normals as rows of A.
Corner where_they_meet(const map::Segment& before, const map::Segment& after, double wall_sigma) {
  const Vec2& p = before.b;
  Eigen::Matrix2d normals;
  normals << before.normal().transpose(), after.normal().transpose();
  const Eigen::Matrix2d inverse = normals.inverse();
  const Vec2 variance(offset_variance(before, p, wall_sigma),
                      offset_variance(after, p, wall_sigma));
  return {p, inverse * variance.asDiagonal() * inverse.transpose()};
}

// The wall ends at p (`outward`: the way it does not go on) if the next two beams there pass.
std::optional<Corner> where_it_ends(const Scan& scan, const map::Segment& wall, const Vec2& p,
                                    const Vec2& outward, const CornerOptions& o) {
  const Vec2 q = scan.T_robot_laser.inverse() * p;
  const double range = q.norm();
  const Vec2 seen = p - scan.T_robot_laser.translation();  // robot axes
  const double side = outward.dot(map::Segment::left_of(seen)) > 0 ? 1 : -1;
  const double beam = (std::atan2(q.y(), q.x()) - scan.start_angle) / scan.angle_step;
  for (const int next : {1, 2}) {
    const auto i = std::lround(beam + side * next * (scan.angle_step > 0 ? 1 : -1));
    if (i < 0 || i >= static_cast<long>(scan.ranges.size())) return std::nullopt;
    if (!(scan.ranges[static_cast<std::size_t>(i)] > range + o.behind)) return std::nullopt;
  }
  // A beam is about so wide on the wall; the end is half of that farther, in the mean.
  const double across = std::max(0.2, std::abs(wall.normal().dot(seen.normalized())));
  const double gap = range * std::abs(scan.angle_step) / across;
  const Vec2 end = p + 0.5 * gap * outward;
  const double along = gap * gap / 12 + o.wall_sigma * o.wall_sigma;
  const Vec2 n = wall.normal();
  return Corner{end, along * outward * outward.transpose() +
                         offset_variance(wall, p, o.wall_sigma) * n * n.transpose()};
}

}  // namespace

std::vector<Corner> find_corners(const Scan& scan, const CornerOptions& options) {
  const std::vector<map::Segment> walls = map::extract_segments(scan, options.segments);
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const map::Segment& wall = walls[i];
    // Walls that meet end in the same point.
    const bool meets = i + 1 < walls.size() && wall.b == walls[i + 1].a;
    const bool met = i > 0 && walls[i - 1].b == wall.a;
    if (!met)
      if (const auto end = where_it_ends(scan, wall, wall.a, -wall.direction(), options))
        corners.push_back(*end);
    if (meets)
      corners.push_back(where_they_meet(wall, walls[i + 1], options.wall_sigma));
    else if (const auto end = where_it_ends(scan, wall, wall.b, wall.direction(), options))
      corners.push_back(*end);
  }
  return corners;
}

}  // namespace majak::slam
