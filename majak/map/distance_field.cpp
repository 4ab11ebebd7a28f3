// SPDX-License-Identifier: Apache-2.0
#include "majak/map/distance_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace majak::map {
namespace {

constexpr float kFar = 1e12F;
// A floor lies next to it. What has none no beam ever met: the inside and the far side of a drawn
// wall.
bool can_be_seen(const KnownMap& map, int ix, int iy) {
  if (map.at(ix, iy) != CellState::occupied) return false;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (map.at(ix + dx, iy + dy) == CellState::free) return true;
  return false;
}

// Lower envelope of the parabolas y = f[q] + (x - q)^2: d[x] is its height at x. `at` and `from`
// are scratch: which parabola counts, and from where on.
void envelope(const float* f, int n, float* d, std::vector<int>& at, std::vector<float>& from) {
  int k = -1;
  for (int q = 0; q < n; ++q) {
    if (f[q] >= kFar) continue;
    const auto value = [&](int p) { return f[p] + static_cast<float>(p) * static_cast<float>(p); };
    float begin = -std::numeric_limits<float>::infinity();
    while (k >= 0) {
      begin = (value(q) - value(at[k])) / (2.0F * static_cast<float>(q - at[k]));
      if (begin > from[k]) break;
      --k;
    }
    if (k < 0) begin = -std::numeric_limits<float>::infinity();
    at[++k] = q;
    from[k] = begin;
  }
  if (k < 0) {
    std::fill(d, d + n, kFar);
    return;
  }
  int i = 0;
  for (int x = 0; x < n; ++x) {
    while (i < k && from[i + 1] < static_cast<float>(x)) ++i;
    const auto off = static_cast<float>(x - at[i]);
    d[x] = f[at[i]] + off * off;
  }
}

}  // namespace

DistanceField::DistanceField(const KnownMap& map, double reach)
    : resolution_(map.resolution),
      x0_(map.x0),
      y0_(map.y0),
      width_(map.width),
      height_(map.height),
      reach_(static_cast<float>(reach)),
      distances_(map.cells.size()) {
  const auto longest = static_cast<std::size_t>(std::max({width_, height_, 1}));
  std::vector<float> in(longest), out(longest), from(longest);
  std::vector<int> at(longest);
  // Squared distances in cells: down each column, then along each row.
  for (int x = 0; x < width_; ++x) {
    for (int y = 0; y < height_; ++y) in[y] = can_be_seen(map, x, y) ? 0 : kFar;
    envelope(in.data(), height_, out.data(), at, from);
    for (int y = 0; y < height_; ++y) distances_[map.index(x, y)] = out[y];
  }
  for (int y = 0; y < height_; ++y) {
    float* row = distances_.data() + map.index(0, y);
    std::copy_n(row, width_, in.begin());
    envelope(in.data(), width_, row, at, from);
    for (int x = 0; x < width_; ++x)
      row[x] = std::min(reach_, static_cast<float>(std::sqrt(row[x]) * resolution_));
  }
}

double DistanceField::cast(const Vec2& p_map, const Vec2& direction, double max_range) const {
  // The nearest occupied centre is d off this cell's centre: a disc of d less half a cell's
  // diagonal at either end is empty.
  const double slack = std::sqrt(2.0) * resolution_, least = 0.2 * resolution_;
  for (double way = 0; way <= max_range;) {
    const double d = at(p_map + way * direction);
    if (d <= 0) return way;
    way += std::max(least, d - slack);
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace majak::map
