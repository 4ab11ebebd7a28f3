// SPDX-License-Identifier: Apache-2.0
#include "majak/match/point_to_line.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "majak/core/simd.hpp"

namespace majak::match {
namespace {

// Information in the weak direction over that in the strong one.
constexpr double kHeldShare = 0.01;

constexpr double kNormalNoise2 = 3e-3;  // rad^2, variance of a surfel's normal
constexpr int kLanes = 8;  // sums are kept in lanes, in the same order whatever the vector unit

// Sums of one Gauss-Newton iteration, in the map's axes about the robot.
struct NormalEquations {
  Mat3 hessian = Mat3::Zero();
  Vec3 gradient = Vec3::Zero();
  double weight = 0, cost = 0;
  int inliers = 0;
};

// The points of a scan at one pose, and what they met; arrays that keep their memory.
struct Pairs {
  std::vector<float> rx, ry, mx, my;  // point about the robot and in the map, map axes
  std::vector<float> nx, ny, dx, dy,
      on;                    // surfel's normal, point - surfel; share by which it counts
  std::vector<float> share;  // the same before it is known what it met
  std::vector<std::uint32_t> surfel;

  void resize(std::size_t n) {
    share.resize(n);
    n = (n + kLanes - 1) / kLanes * kLanes;
    for (auto* v : {&rx, &ry, &mx, &my, &nx, &ny, &dx, &dy, &on}) v->assign(n, 0.0F);
    surfel.assign(n, map::SurfelMap::kNone);
  }
};

MAJAK_VECTORIZED void transform(const ScanPoints& points, const Pose2& pose, Pairs& pairs) {
  const auto c = static_cast<float>(std::cos(pose.theta)),
             s = static_cast<float>(std::sin(pose.theta));
  const auto px = static_cast<float>(pose.x), py = static_cast<float>(pose.y);
  const std::size_t n = points.size();
  const float *x = points.x.data(), *y = points.y.data();
  float *rx = pairs.rx.data(), *ry = pairs.ry.data(), *mx = pairs.mx.data(), *my = pairs.my.data();
  for (std::size_t i = 0; i < n; ++i) {
    rx[i] = c * x[i] - s * y[i];
    ry[i] = s * x[i] + c * y[i];
    mx[i] = rx[i] + px;
    my[i] = ry[i] + py;
  }
}

// Points without a surface (poles, legs) are few: they are summed here and leave the arrays.
template <class Map>
void look_up(const Map& map, std::size_t n, float gate2, float inv_cauchy2, Pairs& p,
             NormalEquations& sum) {
  map.nearest(p.mx.data(), p.my.data(), n, p.surfel.data());
  for (std::size_t i = 0; i < n; ++i) {
    p.on[i] = 0;
    if (p.surfel[i] == map::SurfelMap::kNone) continue;
    const map::Surfel f = map.surfel(p.surfel[i]);
    p.nx[i] = f.nx, p.ny[i] = f.ny;
    p.dx[i] = p.mx[i] - f.x, p.dy[i] = p.my[i] - f.y;
    const float d2 = p.dx[i] * p.dx[i] + p.dy[i] * p.dy[i];
    if (d2 > gate2) continue;
    ++sum.inliers;
    if (f.nx != 0 || f.ny != 0) {
      p.on[i] = p.share[i];
      continue;
    }
    const double w = 0.25F / (1.0F + d2 * inv_cauchy2);  // by half in each direction
    const Vec3 jx(1, 0, -p.ry[i]), jy(0, 1, p.rx[i]);
    sum.hessian += w * (jx * jx.transpose() + jy * jy.transpose());
    sum.gradient += w * (p.dx[i] * jx + p.dy[i] * jy);
    sum.weight += w, sum.cost += w * d2;
  }
}

MAJAK_VECTORIZED void accumulate(const Pairs& p, std::size_t n, float inv_cauchy2, const Vec2& arm,
                                 const ReturnNoise& noise, NormalEquations& sum) {
  const auto lx = static_cast<float>(arm.x()), ly = static_cast<float>(arm.y());
  const auto beam = static_cast<float>(noise.beam), surface = static_cast<float>(noise.surface),
             spot = static_cast<float>(noise.spot);
  float h[11][kLanes] = {};
  for (std::size_t i = 0; i < n; i += kLanes) {
    for (int k = 0; k < kLanes; ++k) {
      const float nx = p.nx[i + k], ny = p.ny[i + k];
      const float r = nx * p.dx[i + k] + ny * p.dy[i + k];
      const float jt = ny * p.rx[i + k] - nx * p.ry[i + k];
      const float bx = p.rx[i + k] - lx, by = p.ry[i + k] - ly, b2 = bx * bx + by * by;
      const float head_on = nx * bx + ny * by, c2 = head_on * head_on / (b2 + 1e-6F);
      const float variance = beam * c2 + surface + spot * (b2 - head_on * head_on);
      const float w = p.on[i + k] / (variance + r * r * inv_cauchy2);
      const float wx = w * nx, wy = w * ny, wt = w * jt;
      h[0][k] += wx * nx, h[1][k] += wx * ny, h[2][k] += wy * ny;
      h[3][k] += wx * jt, h[4][k] += wy * jt, h[5][k] += wt * jt;
      h[6][k] += wx * r, h[7][k] += wy * r, h[8][k] += wt * r;
      h[9][k] += w, h[10][k] += w * r * r;
    }
  }
  double t[11] = {};
  for (int q = 0; q < 11; ++q)
    for (const float lane : h[q]) t[q] += lane;
  Mat3 hessian;
  hessian << t[0], t[1], t[3], t[1], t[2], t[4], t[3], t[4], t[5];
  sum.hessian += hessian;
  sum.gradient += Vec3(t[6], t[7], t[8]);
  sum.weight += t[9];
  sum.cost += t[10];
}

template <class Map>
NormalEquations collect(const ScanPoints& points, const Map& map, const Pose2& pose, float gate,
                        const AlignOptions& options, Pairs& pairs) {
  NormalEquations sum;
  const bool settled = gate <= static_cast<float>(options.final_gate);
  const auto cauchy = static_cast<float>(settled ? options.cauchy : options.first_cauchy);
  const float inv_cauchy2 = 1.0F / (cauchy * cauchy);
  transform(points, pose, pairs);
  look_up(map, points.size(), gate * gate, inv_cauchy2, pairs, sum);
  const Pose2 turn{0, 0, pose.theta};
  accumulate(pairs, points.size(), inv_cauchy2, turn * points.laser, options.noise, sum);
  return sum;
}

// Near things are hit by many beams, a person in front by half of them, and near things move.
Pairs pairs_of(const ScanPoints& points, const AlignOptions& options) {
  Pairs pairs;
  pairs.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float range = std::sqrt(points.x[i] * points.x[i] + points.y[i] * points.y[i]);
    const float near = std::min(1.0F, range / static_cast<float>(options.full_range));
    pairs.share[i] = near * near;
  }
  return pairs;
}

}  // namespace

template <class Map>
double share_on(const ScanPoints& points, const Map& map, const Pose2& T_map_robot, double gate) {
  if (points.size() == 0) return 0;
  Pairs pairs;
  pairs.resize(points.size());
  transform(points, T_map_robot, pairs);
  NormalEquations sum;
  look_up(map, points.size(), static_cast<float>(gate * gate), 1, pairs, sum);
  return sum.inliers / static_cast<double>(points.size());
}

int count_across(const ScanPoints& points, const map::SurfelMap& map, const Pose2& T_map_robot,
                 const Vec2& direction, double gate) {
  constexpr float kAcross = 0.6F;  // cosine of normal and direction
  const auto c = static_cast<float>(std::cos(T_map_robot.theta)),
             s = static_cast<float>(std::sin(T_map_robot.theta));
  const auto px = static_cast<float>(T_map_robot.x), py = static_cast<float>(T_map_robot.y);
  const auto ux = static_cast<float>(direction.x()), uy = static_cast<float>(direction.y());
  const auto gate2 = static_cast<float>(gate * gate);
  int count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float x = c * points.x[i] - s * points.y[i] + px,
                y = s * points.x[i] + c * points.y[i] + py;
    const std::uint32_t found = map.nearest(x, y);
    if (found == map::SurfelMap::kNone) continue;
    const map::Surfel& f = map.surfel(found);
    const float dx = x - f.x, dy = y - f.y;
    const bool faces =
        f.nx * (x - px) + f.ny * (y - py) < 0;  // the robot is on the side that was seen
    count += dx * dx + dy * dy < gate2 && faces && std::abs(f.nx * ux + f.ny * uy) > kAcross;
  }
  return count;
}

Mat3 without_normal_noise(const Mat3& information) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(information.topLeftCorner<2, 2>());
  const double weak = axes.eigenvalues()(0);
  if (!(weak > 0)) return Mat3::Identity();
  const double kept = std::max(0.0, 1 - kNormalNoise2 * axes.eigenvalues().sum() / weak);
  const Vec2 t = axes.eigenvectors().col(0);
  Mat3 s = Mat3::Identity();
  s.topLeftCorner<2, 2>() -= (1 - std::sqrt(kept)) * t * t.transpose();
  return s;
}

template <class Map>
Match align(const ScanPoints& points, const Map& map, const PosePrior& prior,
            const AlignOptions& options) {
  Match match;
  match.T_map_robot = prior.T_map_robot;
  const double inv_sigma2 = 1.0 / (options.sigma * options.sigma);
  double gate = options.gate;
  NormalEquations sum;
  Pairs pairs = pairs_of(points, options);
  for (match.iterations = 0; match.iterations < options.max_iterations;) {
    ++match.iterations;
    sum = collect(points, map, match.T_map_robot, static_cast<float>(gate), options, pairs);
    if (sum.inliers < 3) break;
    const Mat3 s = without_normal_noise(sum.hessian);
    sum.hessian = s * sum.hessian * s;
    sum.gradient = s * (s * sum.gradient);
    const Pose2& at = match.T_map_robot;
    const Vec3 off(at.x - prior.T_map_robot.x, at.y - prior.T_map_robot.y,
                   angle_diff(at.theta, prior.T_map_robot.theta));
    const Mat3 h = inv_sigma2 * sum.hessian + prior.information + 1e-6 * Mat3::Identity();
    const Vec3 b = inv_sigma2 * sum.gradient + prior.information * off;
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
  match.information = inv_sigma2 * sum.hessian;
  match.inliers = sum.inliers;
  match.rms = sum.weight > 0 ? std::sqrt(sum.cost / sum.weight) : 0;
  match.score =
      points.size() > 0 ? static_cast<double>(sum.inliers) / static_cast<double>(points.size()) : 0;
  return match;
}

template <class Map>
double log_likelihood(const ScanPoints& points, const Map& map, const Pose2& T_map_robot,
                      const AlignOptions& options) {
  Pairs pairs = pairs_of(points, options);
  transform(points, T_map_robot, pairs);
  map.nearest(pairs.mx.data(), pairs.my.data(), points.size(), pairs.surfel.data());
  const auto gate2 = static_cast<float>(options.final_gate * options.final_gate);
  const double cauchy2 = options.cauchy * options.cauchy;
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    float off2 = gate2;
    if (pairs.surfel[i] != map::SurfelMap::kNone) {
      const map::Surfel& f = map.surfel(pairs.surfel[i]);
      const float dx = pairs.mx[i] - f.x, dy = pairs.my[i] - f.y, d2 = dx * dx + dy * dy;
      const float across = f.nx * dx + f.ny * dy;
      if (d2 < gate2) off2 = f.nx != 0 || f.ny != 0 ? across * across : d2;
    }
    sum -= pairs.share[i] * std::log1p(off2 / cauchy2);
  }
  return 0.5 * cauchy2 / (options.sigma * options.sigma) * sum;
}

bool holds_all_round(const Mat3& information) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(information.topLeftCorner<2, 2>());
  return axes.eigenvalues()(0) > kHeldShare * axes.eigenvalues()(1);
}

template double share_on(const ScanPoints&, const map::SurfelMap&, const Pose2&, double);
template double share_on(const ScanPoints&, const map::OlderSurfels&, const Pose2&, double);
template Match align(const ScanPoints&, const map::SurfelMap&, const PosePrior&,
                     const AlignOptions&);
template Match align(const ScanPoints&, const map::SharedSurfelMap&, const PosePrior&,
                     const AlignOptions&);
template Match align(const ScanPoints&, const map::OlderSurfels&, const PosePrior&,
                     const AlignOptions&);
template double log_likelihood(const ScanPoints&, const map::SurfelMap&, const Pose2&,
                               const AlignOptions&);
template double log_likelihood(const ScanPoints&, const map::OlderSurfels&, const Pose2&,
                               const AlignOptions&);

}  // namespace majak::match
