// SPDX-License-Identifier: Apache-2.0
#include "majak/match/range_offset.hpp"

#include <Eigen/Cholesky>

namespace majak::match {

// Residual n' (p - q) of a return p = laser + (range - b) u; the pose is eliminated (Schur).
RangeOffset range_offset(const ScanPoints& points, const map::SurfelMap& map,
                         const Pose2& T_map_robot, const Vec2& laser, const AlignOptions& options) {
  const Vec2 robot = T_map_robot.translation(), from = T_map_robot * laser;
  Mat3 h = 1e-3 * Mat3::Identity();
  Vec3 h_b = Vec3::Zero(), g = Vec3::Zero();
  double h_bb = 0, g_b = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 p = T_map_robot * Vec2(points.x[i], points.y[i]);
    const auto found = map.nearest(static_cast<float>(p.x()), static_cast<float>(p.y()));
    if (found == map::SurfelMap::kNone) continue;
    const map::Surfel& s = map.surfel(found);
    const Vec2 n(s.nx, s.ny), off = p - Vec2(s.x, s.y), way = p - from, r = p - robot;
    if (n.isZero() || off.norm() > options.final_gate) continue;
    const double across = n.dot(way.normalized());
    const double residual = n.dot(off);
    const double w = 1 / (1 + residual * residual / (options.cauchy * options.cauchy));
    const Vec3 j(n.x(), n.y(), n.y() * r.x() - n.x() * r.y());
    h += w * j * j.transpose();
    h_b -= w * across * j;
    h_bb += w * across * across;
    g += w * residual * j;
    g_b -= w * across * residual;
  }
  const Eigen::LLT<Mat3> factor(h);
  const double information = h_bb - h_b.dot(factor.solve(h_b));
  if (!(information > 1e-6)) return {};
  return {-(g_b - h_b.dot(factor.solve(g))) / information,
          information / (options.sigma * options.sigma)};
}

}  // namespace majak::match
