// SPDX-License-Identifier: Apache-2.0
#include "majak/map/door_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace majak::map {
namespace {

constexpr int kDirections = 36;      // over half a turn
constexpr double kThin = 0.5;        // share of a jamb
constexpr int kFace = 3;             // cells before the floor in which a wall's face is
constexpr double kOneSide = 0.8;     // share of a jamb that makes up for a bad one opposite
constexpr double kNearer = 1.3;      // times as far as the nearest wall jambs are at most
constexpr double kStraight = 1.25;   // cells, by which a wall may depart from a line
constexpr double kLong = 1.5;        // m of wall in line with a gap that are looked for
constexpr double kWallInLine = 0.9;  // m, at least, on both sides together
constexpr double kInLine = 2.5;      // cells, between the walls on both sides

struct Step {
  int dx, dy;
};

/// Cells along a ray from a cell's middle, one a cell's side.
std::vector<Step> ray(double angle, int steps) {
  std::vector<Step> cells;
  for (int i = 0; i <= steps; ++i)
    cells.push_back({static_cast<int>(std::lround(i * std::cos(angle))),
                     static_cast<int>(std::lround(i * std::sin(angle)))});
  return cells;
}

struct Direction {
  double angle;
  std::vector<Step> ahead, back;  ///< along the gap
  std::vector<Step> left, right;  ///< across it
};

/// What is beside a gap.
struct Jamb {
  double thin = 0;    ///< share of its length that is wall with floor on both sides
  double corner = 0;  ///< share with floor on one side only
  double middle = 0;  ///< cells, of the wall, to the left of the line
  int face = 0;       ///< cells to the one face that is seen, negative to the right; 0 for none
};

class Search {
 public:
  Search(const CellMask& walls, const CellMask& surfaces, double resolution,
         const TopologyOptions& o, Threads threads)
      : walls_(walls),
        surfaces_(surfaces),
        resolution_(resolution),
        options_(o),
        distances_(squared_distances(walls, threads)) {
    narrowest_ = o.narrowest_door / resolution;
    nearest_ = std::max(1.0, 0.5 * narrowest_ - 1);
    reach_ = static_cast<int>(std::ceil(0.5 * o.widest_opening / resolution));
    jamb_ = std::max(2, static_cast<int>(std::lround(o.jamb / resolution)));
    long_ = std::max(jamb_ + 1, static_cast<int>(std::lround(kLong / resolution)));
    thick_ = static_cast<int>(std::lround(o.thickest_wall / resolution));
    ahead_ = static_cast<int>(std::lround(0.35 / resolution));
    for (int k = 0; k < kDirections; ++k) {
      const double a = std::numbers::pi * k / kDirections, h = std::numbers::pi / 2;
      const int across = std::max(thick_, ahead_) + 2;
      directions_.push_back({a, ray(a, reach_ + long_ + 2), ray(a + 2 * h, reach_ + long_ + 2),
                             ray(a + h, across), ray(a - h, across)});
    }
  }

  std::vector<DoorGap> row(int iy) const {
    std::vector<DoorGap> found;
    for (int ix = 0; ix < walls_.width; ++ix) {
      const auto distance = distances_[walls_.index(ix, iy)];
      if (distance < nearest_ * nearest_ || distance > reach_ * reach_) continue;
      for (const Direction& d : directions_)
        if (const auto gap = look(ix, iy, d)) found.push_back(*gap);
    }
    return found;
  }

 private:
  /// Steps to the first wall cell, from `first` on, or more than `last`.
  int run(int ix, int iy, const std::vector<Step>& ray, int first, int last) const {
    int i = first;
    while (i <= last && !walls_.at(ix + ray[i].dx, iy + ray[i].dy)) ++i;
    return i;
  }

  /// Steps across to the floor, or more than thick_; also where no surface was seen between: what
  /// stands in a room hides the floor behind it, which is no wall.
  int to_floor(int ix, int iy, const std::vector<Step>& across) const {
    for (int i = 1; i <= thick_; ++i)
      if (floor(ix + across[i].dx, iy + across[i].dy) &&
          floor(ix + across[i + 1].dx, iy + across[i + 1].dy)) {
        bool seen = false;
        for (int k = std::max(0, i - kFace); k < i; ++k)
          seen = seen || surfaces_.at(ix + across[k].dx, iy + across[k].dy);
        return seen ? i : thick_ + 1;
      }
    return thick_ + 1;
  }
  bool floor(int ix, int iy) const { return walls_.inside(ix, iy) && !walls_.at(ix, iy); }

  /// What is beside the gap's end, from `first` + 1 on, `length` steps. Wall counts as long as it
  /// goes on in the line's direction.
  Jamb jamb(int ix, int iy, const std::vector<Step>& ray, int first, int length,
            const Direction& d) const {
    Jamb jamb;
    int thin = 0, corner = 0, face = 0, side = 0;
    for (int i = first + 1; i <= first + length; ++i) {
      const int x = ix + ray[i].dx, y = iy + ray[i].dy;
      if (!walls_.at(x, y) && !walls_.at(x + d.left[1].dx, y + d.left[1].dy) &&
          !walls_.at(x + d.right[1].dx, y + d.right[1].dy))
        continue;
      const int left = to_floor(x, y, d.left), right = to_floor(x, y, d.right);
      if (left + right - 1 <= thick_) {
        const double middle = 0.5 * (left - right);
        if (thin == 0) jamb.middle = middle;
        if (std::abs(middle - jamb.middle) <= kStraight) ++thin;
      } else if (std::min(left, right) <= thick_) {
        const int here = std::min(left, right), at = left < right ? 1 : -1;
        if (corner == 0) face = here, side = at;
        if (at == side && std::abs(here - face) <= kStraight) ++corner;
      }
    }
    jamb.face = side * face;
    jamb.thin = static_cast<double>(thin) / length;
    jamb.corner = static_cast<double>(corner) / length;
    return jamb;
  }

  /// Floor before and behind the middle.
  bool passable(int ix, int iy, const Direction& d) const {
    for (int i = 1; i <= ahead_; ++i)
      if (!floor(ix + d.left[i].dx, iy + d.left[i].dy) ||
          !floor(ix + d.right[i].dx, iy + d.right[i].dy))
        return false;
    return true;
  }

  std::optional<DoorGap> look(int ix, int iy, const Direction& d) const {
    // In the middle of a door nothing is much nearer than its jambs.
    const double nearest = std::sqrt(distances_[walls_.index(ix, iy)]);
    const int first = std::max(1, static_cast<int>(nearest) - 1);
    const int last = std::min(reach_, static_cast<int>(kNearer * nearest) + 2);
    const int ahead = run(ix, iy, d.ahead, first, last);
    if (ahead > last || 2 * ahead < narrowest_ - 2) return std::nullopt;
    const int back = run(ix, iy, d.back, first, last);
    if (std::abs(ahead - back) > 1) return std::nullopt;
    const double width = (ahead + back - 1) * resolution_;
    if (width < options_.narrowest_door || width > options_.widest_opening) return std::nullopt;
    const Jamb a = jamb(ix, iy, d.ahead, ahead, jamb_, d);
    const Jamb b = jamb(ix, iy, d.back, back, jamb_, d);
    const double least = std::min(a.thin, b.thin), most = std::max(a.thin, b.thin);
    const bool opening = width > options_.widest_door;
    const Jamb& other = a.thin < b.thin ? a : b;
    const bool both = least >= kThin && std::abs(a.middle - b.middle) <= kInLine;
    const bool corner =
        most >= kOneSide || (most >= kThin && other.thin + other.corner >= kOneSide);
    const bool faces = std::min(a.thin + a.corner, b.thin + b.corner) >= kOneSide &&
                       a.face * b.face > 0 && std::abs(a.face - b.face) <= kInLine;
    if (!(both || ((corner || faces) && !opening)) || !passable(ix, iy, d)) return std::nullopt;
    const Jamb far_a = jamb(ix, iy, d.ahead, ahead, long_, d);
    const Jamb far_b = jamb(ix, iy, d.back, back, long_, d);
    const double straight = 0.5 * (far_a.thin + far_a.corner + far_b.thin + far_b.corner);
    if (straight * 2 * kLong < kWallInLine) return std::nullopt;
    const double score = 0.5 * (least + most) + 0.1 * other.corner - 0.2 * width + 0.3 * straight -
                         0.02 * (std::abs(a.middle) + std::abs(b.middle));
    return DoorGap{ix,
                   iy,
                   d.ahead[ahead - 1].dx,
                   d.ahead[ahead - 1].dy,
                   d.back[back - 1].dx,
                   d.back[back - 1].dy,
                   d.angle,
                   width,
                   score};
  }

  const CellMask &walls_, &surfaces_;
  double resolution_;
  const TopologyOptions& options_;
  std::vector<std::int32_t> distances_;
  double nearest_ = 0;    // cells from a gap's middle to the wall
  double narrowest_ = 0;  // cells
  int reach_ = 0, jamb_ = 0, long_ = 0, thick_ = 0, ahead_ = 0;  // cells
  std::vector<Direction> directions_;
};

bool overlap(const DoorGap& a, const DoorGap& b, double resolution) {
  const double apart = std::hypot(a.ix - b.ix, a.iy - b.iy) * resolution;
  return apart < 0.25 * (a.width + b.width) + 0.2;
}

}  // namespace

std::vector<DoorGap> find_door_gaps(const CellMask& walls, const CellMask& surfaces,
                                    double resolution, const TopologyOptions& options,
                                    Threads threads) {
  const Search search(walls, surfaces, resolution, options, threads);
  std::vector<std::vector<DoorGap>> rows(static_cast<std::size_t>(walls.height));
  parallel_for(threads, rows.size(),
               [&](std::size_t iy) { rows[iy] = search.row(static_cast<int>(iy)); });
  std::vector<DoorGap> all, best;
  for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const DoorGap& a, const DoorGap& b) { return a.score > b.score; });
  for (const DoorGap& gap : all)
    if (std::none_of(best.begin(), best.end(),
                     [&](const DoorGap& b) { return overlap(gap, b, resolution); }))
      best.push_back(gap);
  return best;
}

}  // namespace majak::map
