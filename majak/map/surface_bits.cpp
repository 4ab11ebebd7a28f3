// SPDX-License-Identifier: Apache-2.0
#include "majak/map/surface_bits.hpp"

#include <algorithm>
#include <cmath>

#include "majak/map/occupancy_grid.hpp"
#include "majak/map/scan_choice.hpp"
#include "majak/map/segment_gaps.hpp"

namespace majak::map {
namespace {

/// Of a point that is `arm` from the robot (map axes), by the pose's error.
Eigen::Matrix2d by_pose(const Mat3& covariance, const Vec2& arm) {
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << 1, 0, -arm.y(), 0, 1, arm.x();
  return jacobian * covariance * jacobian.transpose();
}

/// Sums while returns come in; `bit` holds sums, not means, until it is finished.
struct Gathering {
  SurfaceBit bit;
  Vec2 corner;  // moments are about it
};

SurfaceBit finished(const Gathering& g) {
  SurfaceBit bit = g.bit;
  const Vec2 mean = bit.mean / bit.returns;
  bit.scatter = bit.scatter / bit.returns - mean * mean.transpose();
  bit.mean = g.corner + mean;
  bit.pose_covariance /= bit.returns;
  bit.heading_variance /= bit.returns;
  bit.beam /= bit.returns;
  return bit;
}

}  // namespace

SurfaceBits::SurfaceBits(const Site& site, const OccupancyGrid& grid,
                         const SurfaceBitsOptions& options) {
  gather(site, options);
  keep_static(grid);
  sort_into_blocks();
}

void SurfaceBits::gather(const Site& site, const SurfaceBitsOptions& o) {
  std::unordered_map<std::uint64_t, std::size_t> index;
  std::vector<Gathering> sums;
  int number = 0;
  for_spaced_scans(site, o.key_spacing, o.key_turn, [&](const PosedScan& posed) {
    const Pose2& pose = posed.estimate.T_map_robot;
    ++number;
    const Mat3 covariance =
        posed.estimate.covariance.allFinite() ? posed.estimate.covariance : Mat3::Zero();
    const Pose2 T_map_laser = pose * posed.scan.T_robot_laser;
    for (std::size_t i = 0; i < posed.scan.ranges.size(); ++i) {
      const double range = posed.scan.ranges[i], angle = T_map_laser.theta + posed.scan.angle(i);
      if (!std::isfinite(range) || range <= 0 || range > o.max_range) continue;
      const Vec2 beam(std::cos(angle), std::sin(angle));
      const Vec2 p = T_map_laser.translation() + range * beam;
      const int x = static_cast<int>(std::floor(p.x() / o.cell));
      const int y = static_cast<int>(std::floor(p.y() / o.cell));
      const auto [found, fresh] = index.try_emplace(key(x, y), sums.size());
      if (fresh) sums.push_back({{}, Vec2(x * o.cell, y * o.cell)});
      Gathering& g = sums[found->second];
      const Vec2 from_corner = p - g.corner;
      g.bit.returns += 1;
      g.bit.mean += from_corner;
      g.bit.scatter += from_corner * from_corner.transpose();
      g.bit.pose_covariance += by_pose(covariance, p - pose.translation());
      g.bit.heading_variance += covariance(2, 2);
      g.bit.beam += beam;
      g.bit.scans += g.bit.last_scan != number;
      if (g.bit.scans == 1) g.bit.first_scan = number;
      g.bit.last_scan = number;
    }
  });
  bits_.reserve(sums.size());
  for (const Gathering& g : sums) bits_.push_back(finished(g));
}

void SurfaceBits::keep_static(const OccupancyGrid& grid) {
  std::erase_if(bits_, [&](const SurfaceBit& bit) { return !beside_occupied(grid, bit.mean); });
}

void SurfaceBits::sort_into_blocks() {
  const auto key_of = [](const SurfaceBit& bit) {
    return key(block(bit.mean.x()), block(bit.mean.y()));
  };
  std::stable_sort(bits_.begin(), bits_.end(),
                   [&](const SurfaceBit& a, const SurfaceBit& b) { return key_of(a) < key_of(b); });
  for (std::size_t first = 0, i = 1; i <= bits_.size(); ++i) {
    if (i < bits_.size() && key_of(bits_[i]) == key_of(bits_[first])) continue;
    blocks_[key_of(bits_[first])] = {first, i};
    first = i;
  }
}

bool SurfaceBits::misses(int x, int y, const Vec2& a, const Vec2& b, double reach) {
  const Vec2 middle((x + 0.5) * kBlock, (y + 0.5) * kBlock), way = b - a;
  const double length2 = way.squaredNorm();
  const double u = length2 > 0 ? std::clamp(way.dot(middle - a) / length2, 0.0, 1.0) : 0.0;
  return (a + u * way - middle).norm() > reach + kBlock * std::sqrt(0.5);
}

}  // namespace majak::map
