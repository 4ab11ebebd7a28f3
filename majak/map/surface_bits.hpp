// SPDX-License-Identifier: Apache-2.0
// SurfaceBits: the static returns of a whole site, gathered in small squares with their moments, so
// that lines can be fitted to all of them and memory follows the surface, not the scans.
#pragma once

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::map {

/// The returns in one square, map frame.
struct SurfaceBit {
  double returns = 0;
  Vec2 mean = Vec2::Zero();                                   ///< m
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();          ///< m^2, covariance of the returns
  Eigen::Matrix2d pose_covariance = Eigen::Matrix2d::Zero();  ///< m^2, of a return, by its pose
  double heading_variance = 0;                                ///< rad^2, of the poses
  Vec2 beam = Vec2::Zero();           ///< mean direction of the beams, not unit
  int scans = 0;                      ///< in which it was hit
  int first_scan = 0, last_scan = 0;  ///< of those taken, numbered from 1
};

struct SurfaceBitsOptions {
  double cell = 0.02;         ///< m, side of a square
  double max_range = 30;      ///< m, longer beams are left out
  double key_spacing = 0.15;  ///< m, a scan nearer than this to the last one taken and
  double key_turn = 0.15;     ///< rad, turned less is left out
};

class SurfaceBits {
 public:
  /// What does not lie in or beside an occupied cell of the grid, the site's own, is left out.
  SurfaceBits(const Site& site, const OccupancyGrid& grid, const SurfaceBitsOptions& options = {});

  const std::vector<SurfaceBit>& all() const { return bits_; }

  /// Calls visit(index) for every bit whose mean is within `reach` of the straight way from a to b,
  /// and for some that are not, in an order that depends on the site alone.
  template <class Visit>
  void near(const Vec2& a, const Vec2& b, double reach, const Visit& visit) const {
    const Vec2 low = a.cwiseMin(b).array() - reach, high = a.cwiseMax(b).array() + reach;
    for (int y = block(low.y()); y <= block(high.y()); ++y)
      for (int x = block(low.x()); x <= block(high.x()); ++x) {
        if (misses(x, y, a, b, reach)) continue;
        const auto found = blocks_.find(key(x, y));
        if (found == blocks_.end()) continue;
        for (std::size_t i = found->second.first; i < found->second.second; ++i) visit(i);
      }
  }

 private:
  static constexpr double kBlock = 0.25;  // m
  static int block(double v) { return static_cast<int>(std::floor(v / kBlock)); }
  static std::uint64_t key(int x, int y) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32) |
           static_cast<std::uint32_t>(y);
  }
  static bool misses(int x, int y, const Vec2& a, const Vec2& b, double reach);
  void gather(const Site& site, const SurfaceBitsOptions& options);
  void keep_static(const OccupancyGrid& grid);
  void sort_into_blocks();

  std::vector<SurfaceBit> bits_;
  std::unordered_map<std::uint64_t, std::pair<std::size_t, std::size_t>> blocks_;
};

}  // namespace majak::map
