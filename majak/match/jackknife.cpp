// SPDX-License-Identifier: Apache-2.0
#include "majak/match/jackknife.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace majak::match {
namespace {

constexpr double kHeadOn = 0.75, kGrazing = 0.25;  // cos^2 of incidence
constexpr double kOutlier = 0.04;                  // m, residual at which one counts half

constexpr int kOctaves = 8;  // from 0.5 m on

struct Octave {
  Vec3 pull = Vec3::Zero();
  double information = 0, gradient = 0, noise = 0;
};

struct Block {
  Mat3 information = Mat3::Zero();
  Vec3 gradient = Vec3::Zero();
};

// As in align(), without the points that have no surface.
std::vector<Block> blocks_of(const ScanPoints& points, const map::SurfelMap& map,
                             const Pose2& T_map_robot, const AlignOptions& align, std::size_t count,
                             Jackknife& result, std::array<Octave, kOctaves>& octaves) {
  std::vector<Block> blocks(count);
  const Vec2 robot = T_map_robot.translation(), from = T_map_robot * points.laser;
  const double c = std::cos(T_map_robot.theta), s = std::sin(T_map_robot.theta);
  const double inv_sigma2 = 1 / (align.sigma * align.sigma);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 r(c * points.x[i] - s * points.y[i], s * points.x[i] + c * points.y[i]);
    const Vec2 p = robot + r;
    const auto found = map.nearest(static_cast<float>(p.x()), static_cast<float>(p.y()));
    if (found == map::SurfelMap::kNone) continue;
    const map::Surfel& f = map.surfel(found);
    const Vec2 n(f.nx, f.ny), off = p - Vec2(f.x, f.y);
    if (n.isZero() || off.squaredNorm() > align.final_gate * align.final_gate) continue;
    const double residual = n.dot(off), near = std::min(1.0, r.norm() / align.full_range);
    const double w = near * near * inv_sigma2 /
                     (return_variance(align.noise, n, p - from) +
                      residual * residual / (align.cauchy * align.cauchy));
    const Vec3 j(n.x(), n.y(), n.y() * r.x() - n.x() * r.y());
    const Vec2 way = p - from;
    const double range = way.norm(), across = range > 0 ? n.dot(way) / range : 0;
    const double cos2 = across * across;
    if (cos2 > kHeadOn || cos2 < kGrazing) {
      const double told = near * near / (1 + residual * residual / (kOutlier * kOutlier));
      Spread& spread = cos2 > kHeadOn ? result.head_on : result.grazing;
      spread.weight += told, spread.square += told * residual * residual;
      spread.cos2 += told * cos2;
    }
    const int at = std::clamp(range > 0 ? std::ilogb(range) + 1 : 0, 0, kOctaves - 1);
    Octave& octave = octaves[static_cast<std::size_t>(at)];
    octave.pull += w * across * j;
    octave.information += w * across * across;
    octave.gradient += w * across * residual;
    octave.noise += w * w * across * across * residual * residual;
    Block& block = blocks[i * count / points.size()];
    block.information += w * j * j.transpose();
    block.gradient += w * residual * j;
  }
  return blocks;
}

}  // namespace

Jackknife jackknife(const ScanPoints& points, const map::SurfelMap& map, const Pose2& T_map_robot,
                    const Mat3& held, const AlignOptions& align, const JackknifeOptions& options) {
  if (points.size() == 0 || options.blocks < 2) return {};
  Jackknife result;
  std::array<Octave, kOctaves> octaves;
  const auto blocks = blocks_of(points, map, T_map_robot, align,
                                static_cast<std::size_t>(options.blocks), result, octaves);
  Mat3 all = held + 1e-6 * Mat3::Identity();
  Mat3 seen = Mat3::Zero();
  for (const Block& b : blocks) seen += b.information;
  if (seen.isZero(0)) return {};
  all += seen;
  const Mat3 inverse = all.inverse();
  result.claimed = inverse * seen * inverse;
  for (const Block& b : blocks) {
    const Vec3 moved = (all - b.information).inverse() * b.gradient;
    result.covariance += moved * moved.transpose();
  }
  // A step of the laser's error at the lower end of octave k is in all octaves from there on. What
  // is common to all is learnt elsewhere; what the pose takes up is not seen.
  for (const Octave& o : octaves)
    if (o.information > 0) result.steps += (o.gradient * o.gradient - o.noise) / o.information;
  Vec3 pull = Vec3::Zero();
  for (std::size_t k = kOctaves - 1; k > 0; --k) {
    pull += octaves[k].pull;
    const Vec3 moved = inverse * pull;
    result.by_step += moved * moved.transpose();
    for (std::size_t at = 0; at < kOctaves; ++at) {
      const Octave& o = octaves[at];
      if (!(o.information > 0)) continue;
      const double left = (at >= k) - o.pull.dot(moved) / o.information;
      result.steps_weight += o.information * left * left;
    }
  }
  return result;
}

}  // namespace majak::match
