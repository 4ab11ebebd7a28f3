// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/corners.hpp"

#include <Eigen/LU>

namespace majak::slam {
namespace {

// p = A^-1 (rho_1, rho_2) with the unit normals as rows of A; each line's offset at the corner has
// the variance of its own and that of its turn times the distance from its middle.
Corner corner_of(const map::Segment& before, const map::Segment& after, double wall_sigma) {
  Eigen::Matrix2d normals;
  normals << before.normal().transpose(), after.normal().transpose();
  const auto variance = [&](const map::Segment& s) {
    const Vec2 offset(1, (before.b - s.middle()).dot(s.direction()));
    return offset.dot(s.covariance * offset) + wall_sigma * wall_sigma;
  };
  const Eigen::Matrix2d inverse = normals.inverse();
  return {before.b,
          inverse * Vec2(variance(before), variance(after)).asDiagonal() * inverse.transpose()};
}

}  // namespace

std::vector<Corner> find_corners(const Scan& scan, const CornerOptions& options) {
  const std::vector<map::Segment> walls = map::extract_segments(scan, options.segments);
  std::vector<Corner> corners;
  for (std::size_t i = 0; i + 1 < walls.size(); ++i)  // walls that meet end in the same point
    if (walls[i].b == walls[i + 1].a)
      corners.push_back(corner_of(walls[i], walls[i + 1], options.wall_sigma));
  return corners;
}

}  // namespace majak::slam
