// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_raster.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

constexpr double kMostCells = 268435456;
constexpr std::uint32_t kNobody = 0xffffffffU;

KnownMap empty_around(std::span<const Segment> segments, double resolution) {
  KnownMap map;
  map.resolution = resolution;
  if (segments.empty()) return map;
  Vec2 low = segments[0].a, high = low;
  for (const Segment& s : segments) {
    low = low.cwiseMin(s.a.cwiseMin(s.b));
    high = high.cwiseMax(s.a.cwiseMax(s.b));
  }
  const Vec2 first = (low / resolution).array().floor(), last = (high / resolution).array().floor();
  const Vec2 size = last - first + Vec2(3, 3);
  if (!(size.x() * size.y() <= kMostCells))
    throw Error("the segments lie too far apart for a map of cells; are they in metres?");
  map.x0 = (first.x() - 1) * resolution, map.y0 = (first.y() - 1) * resolution;
  map.width = static_cast<int>(size.x()), map.height = static_cast<int>(size.y());
  map.cells.assign(static_cast<std::size_t>(size.x() * size.y()), CellState::unknown);
  return map;
}

/// Calls visit(p) along the way from a to b in steps of at most `step`, ends included.
template <class Visit>
void walk(const Vec2& a, const Vec2& b, double step, const Visit& visit) {
  const int n = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
  for (int i = 0; i <= n; ++i) visit(Vec2(a + (b - a) * i / n));
}

class Raster {
 public:
  Raster(std::span<const Segment> segments, const SegmentRasterOptions& options)
      : segments_(segments), o_(options), map_(empty_around(segments, options.resolution)) {
    whose_.assign(map_.cells.size(), kNobody);
  }

  KnownMap drawn() {
    for (std::size_t k = 0; k < segments_.size(); ++k) draw(static_cast<std::uint32_t>(k));
    for (const Segment& s : segments_)
      walk(s.a, s.b, o_.resolution, [&](const Vec2& p) {
        for (const double angle : {0.0, kPi / 4, -kPi / 4}) clear(s, p, angle);
      });
    return std::move(map_);
  }

 private:
  void draw(std::uint32_t k) {
    const Segment& s = segments_[k];
    walk(s.a, s.b, o_.resolution / 4, [&](const Vec2& p) {
      const std::size_t cell = map_.index(map_.column(p.x()), map_.row(p.y()));
      map_.cells[cell] = CellState::occupied;
      whose_[cell] = k;
    });
  }

  /// The ray from p, on the front of s, turned by `angle` against its normal.
  void clear(const Segment& s, const Vec2& p, double angle) {
    const Vec2 n = s.normal(), t = s.direction();
    const Vec2 ray = std::cos(angle) * n + std::sin(angle) * t;
    const double step = o_.resolution / 2;
    double way = 1.5 * o_.resolution, far = o_.before;
    for (; way < o_.reach; way += step) {
      const Vec2 at = p + way * ray;
      const int x = map_.column(at.x()), y = map_.row(at.y());
      if (!map_.inside(x, y)) break;
      if (map_.cells[map_.index(x, y)] != CellState::occupied) continue;
      if (segments_[whose_[map_.index(x, y)]].normal().dot(ray) < 0) far = way;
      break;
    }
    for (double u = 1.5 * o_.resolution; u < std::min(way, far); u += step) {
      const Vec2 at = p + u * ray;
      auto& cell = map_.cells[map_.index(map_.column(at.x()), map_.row(at.y()))];
      if (cell == CellState::unknown) cell = CellState::free;
    }
  }

  std::span<const Segment> segments_;
  const SegmentRasterOptions& o_;
  KnownMap map_;
  std::vector<std::uint32_t> whose_;  // segment in each occupied cell
};

}  // namespace

KnownMap known_map(std::span<const Segment> segments, const SegmentRasterOptions& options) {
  return Raster(segments, options).drawn();
}

}  // namespace majak::map
