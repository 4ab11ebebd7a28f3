// SPDX-License-Identifier: Apache-2.0
#include "majak/match/map_surfaces.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/map/edits.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::match {
namespace {

constexpr int kAround = 2;         // cells on each side that a normal is taken from
constexpr double kFlatness = 0.5;  // rms off the line over rms along it, above which it is none

bool borders_on_free(const map::KnownMap& map, int ix, int iy) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (map.at(ix + dx, iy + dy) == map::CellState::free) return true;
  return false;
}

constexpr double kSpacing = 0.05;  // m, of the surfels of a segment

void add_to(map::SurfelMap& surfels, const map::Segment& s) {
  const Vec2 n = s.normal();
  const int pieces = std::max(1, static_cast<int>(std::lround(s.length() / kSpacing)));
  for (int i = 0; i < pieces; ++i) {
    const Vec2 p = s.a + (s.b - s.a) * (i + 0.5) / pieces;
    surfels.add(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(n.x()),
                static_cast<float>(n.y()));
  }
}

}  // namespace

map::SurfelMap surfaces(const Site& site) {
  map::SurfelMap surfels;
  const bool keys =
      std::any_of(site.scans.begin(), site.scans.end(), [](const PosedScan& s) { return s.key; });
  BeamDirections directions;
  for (const PosedScan& posed : site.scans) {
    if ((keys && !posed.key) || posed.estimate.health == Health::lost) continue;
    add_to(surfels, scan_points(posed.scan, {}, true, directions), posed.estimate.T_map_robot);
  }
  for (map::Segment wall : map::drawn_walls(site, 1)) {
    add_to(surfels, wall);
    std::swap(wall.a, wall.b);  // who drew it did not say which side is seen
    add_to(surfels, wall);
  }
  return surfels;
}

map::SurfelMap surfaces(std::span<const map::Segment> segments) {
  map::SurfelMapOptions options;
  options.merge_radius = 0.4 * kSpacing;
  map::SurfelMap surfels(options);
  for (const map::Segment& s : segments) add_to(surfels, s);
  return surfels;
}

map::SurfelMap surfaces(const map::KnownMap& map) {
  map::SurfelMapOptions options;
  options.cell = std::max(options.cell, map.resolution);
  options.merge_radius = 0.5 * map.resolution;
  map::SurfelMap surfels(options);
  const auto shows = [&](int ix, int iy) {
    return map.at(ix, iy) == map::CellState::occupied && borders_on_free(map, ix, iy);
  };
  for (int iy = 0; iy < map.height; ++iy)
    for (int ix = 0; ix < map.width; ++ix) {
      if (!shows(ix, iy)) continue;
      // Mean and spread of the surface cells around, and where the free ones lie, in cells.
      Vec2 mean = Vec2::Zero(), free = Vec2::Zero();
      Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
      double n = 0;
      for (int dy = -kAround; dy <= kAround; ++dy)
        for (int dx = -kAround; dx <= kAround; ++dx) {
          const Vec2 d(dx, dy);
          if (map.at(ix + dx, iy + dy) == map::CellState::free) free += d;
          if (!shows(ix + dx, iy + dy)) continue;
          mean += d, spread += d * d.transpose(), n += 1;
        }
      mean /= n;
      spread = spread / n - mean * mean.transpose();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
      const double across = std::max(0.0, axes.eigenvalues()(0)), along = axes.eigenvalues()(1);
      Vec2 normal = Vec2::Zero(), at = Vec2::Zero();
      if (along > 0 && across < kFlatness * kFlatness * along) {
        normal = axes.eigenvectors().col(0);
        if (normal.dot(free) < 0) normal = -normal;
        at = normal * normal.dot(mean);  // onto the line through the mean
      }
      const Vec2 p = map.centre(ix, iy) + at * map.resolution;
      surfels.add(static_cast<float>(p.x()), static_cast<float>(p.y()),
                  static_cast<float>(normal.x()), static_cast<float>(normal.y()));
    }
  return surfels;
}

}  // namespace majak::match
