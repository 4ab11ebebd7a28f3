// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/map/segment_ends.hpp"

namespace majak::map {
namespace {

constexpr float kOccupied = 0.62F;  // log-odds, a probability of 0.65

int cell(double v, const OccupancyGrid& grid) {
  return static_cast<int>(std::floor(v / grid.resolution()));
}

bool seen_through(const OccupancyGrid& grid, const Vec2& p) {
  const int x = cell(p.x(), grid), y = cell(p.y(), grid);
  return grid.known(x, y) && grid.log_odds(x, y) < 0 && !beside_occupied(grid, p);
}

/// From `from` to `to`, m along the segment.
Segment part(Segment s, double from, double to, const OccupancyGrid& grid) {
  const Vec2 a = s.a, way = s.direction();
  const double length = s.length(), sigma = grid.resolution() / std::sqrt(3.0);
  const double share = (to - from) / length;
  if (from > 0) s.a = a + from * way, s.sigma_a = sigma;
  if (to < length) s.b = a + to * way, s.sigma_b = sigma;
  shift_middle(s, (from + to - length) / 2);
  s.points = static_cast<std::size_t>(std::lround(share * static_cast<double>(s.points)));
  return s;
}

}  // namespace

bool beside_occupied(const OccupancyGrid& grid, const Vec2& p) {
  const int x = cell(p.x(), grid), y = cell(p.y(), grid);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (grid.log_odds(x + dx, y + dy) >= kOccupied) return true;
  return false;
}

std::vector<Segment> without_gaps(const std::vector<Segment>& segments, const OccupancyGrid& grid,
                                  double longest_gap, double min_length) {
  std::vector<Segment> parts;
  for (const Segment& s : segments) {
    const double length = s.length();
    const int steps = std::max(1, static_cast<int>(std::ceil(length / grid.resolution())));
    const double step = length / steps;
    const auto keep = [&](double from, double to) {
      if (from <= 0 && to >= length)
        parts.push_back(s);
      else if (to > from && to - from >= min_length)
        parts.push_back(part(s, from, to, grid));
    };
    double from = 0, gap = 0;  // where this part began; how long the gap at hand is
    for (int i = 0; i < steps; ++i) {
      const bool open = seen_through(grid, s.a + (i + 0.5) * step * s.direction());
      if (!open && gap >= longest_gap) {
        keep(from, i * step - gap);
        from = i * step;
      }
      gap = open ? gap + step : 0;
    }
    keep(from, gap >= longest_gap ? length - gap : length);
  }
  return parts;
}

}  // namespace majak::map
