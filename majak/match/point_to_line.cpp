// SPDX-License-Identifier: Apache-2.0
#include "majak/match/point_to_line.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace majak::match {
namespace {

// Sums of one Gauss-Newton iteration, in the map's axes about the robot.
struct NormalEquations {
  float hxx = 0, hxy = 0, hyy = 0, hxt = 0, hyt = 0, htt = 0;
  float bx = 0, by = 0, bt = 0;
  float weight = 0, cost = 0;
  int inliers = 0;

  void add(float jx, float jy, float jt, float r, float w) {
    hxx += w * jx * jx, hxy += w * jx * jy, hyy += w * jy * jy;
    hxt += w * jx * jt, hyt += w * jy * jt, htt += w * jt * jt;
    bx += w * jx * r, by += w * jy * r, bt += w * jt * r;
    cost += w * r * r, weight += w;
  }
  Mat3 hessian() const {
    Mat3 h;
    h << hxx, hxy, hxt, hxy, hyy, hyt, hxt, hyt, htt;
    return h;
  }
  Vec3 gradient() const { return {bx, by, bt}; }
};

NormalEquations collect(const ScanPoints& points, const map::SurfelMap& map, const Pose2& pose, float gate,
                        float cauchy) {
  NormalEquations sum;
  const auto c = static_cast<float>(std::cos(pose.theta)), s = static_cast<float>(std::sin(pose.theta));
  const auto px = static_cast<float>(pose.x), py = static_cast<float>(pose.y);
  const float gate2 = gate * gate, inv_cauchy2 = 1.0F / (cauchy * cauchy);
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const float rx = c * points.x[i] - s * points.y[i], ry = s * points.x[i] + c * points.y[i];
    const float mx = rx + px, my = ry + py;
    const std::uint32_t found = map.nearest(mx, my);
    if (found == map::SurfelMap::kNone) continue;
    const map::Surfel& f = map.surfel(found);
    const float dx = mx - f.x, dy = my - f.y, d2 = dx * dx + dy * dy;
    if (d2 > gate2) continue;
    ++sum.inliers;
    if (f.nx != 0 || f.ny != 0) {
      const float r = f.nx * dx + f.ny * dy;
      sum.add(f.nx, f.ny, f.ny * rx - f.nx * ry, r, 1.0F / (1.0F + r * r * inv_cauchy2));
    } else {  // not a surface: the point itself attracts, by half in each direction
      const float w = 0.25F / (1.0F + d2 * inv_cauchy2);
      sum.add(1, 0, -ry, dx, w);
      sum.add(0, 1, rx, dy, w);
    }
  }
  return sum;
}

}  // namespace

Match align(const ScanPoints& points, const map::SurfelMap& map, const PosePrior& prior, const AlignOptions& options) {
  Match match;
  match.T_map_robot = prior.T_map_robot;
  const double inv_sigma2 = 1.0 / (options.sigma * options.sigma);
  double gate = options.gate;
  NormalEquations sum;
  for (match.iterations = 0; match.iterations < options.max_iterations;) {
    ++match.iterations;
    sum = collect(points, map, match.T_map_robot, static_cast<float>(gate), static_cast<float>(options.cauchy));
    if (sum.inliers < 3) break;
    const Pose2& at = match.T_map_robot;
    const Vec3 off(at.x - prior.T_map_robot.x, at.y - prior.T_map_robot.y, angle_diff(at.theta, prior.T_map_robot.theta));
    const Mat3 h = inv_sigma2 * sum.hessian() + prior.information + 1e-6 * Mat3::Identity();
    const Vec3 b = inv_sigma2 * sum.gradient() + prior.information * off;
    const Vec3 step = -h.llt().solve(b);
    if (!step.allFinite()) break;
    match.T_map_robot = {at.x + step.x(), at.y + step.y(), wrap_angle(at.theta + step.z())};
    const double size = std::max(step.head<2>().norm(), 5.0 * std::abs(step.z()));
    const bool settled = size < options.tolerance || (gate > options.final_gate && size < 0.02);
    if (settled && gate <= options.final_gate) {
      match.converged = true;
      break;
    }
    if (settled || match.iterations >= 3) gate = options.final_gate;
  }
  match.information = inv_sigma2 * sum.hessian();
  match.inliers = sum.inliers;
  match.rms = sum.weight > 0 ? std::sqrt(sum.cost / sum.weight) : 0;
  match.score = points.size() > 0 ? static_cast<double>(sum.inliers) / static_cast<double>(points.size()) : 0;
  return match;
}

}  // namespace majak::match
