// SPDX-License-Identifier: Apache-2.0
// The returns of a scan as points with surface normals: what every matcher works on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/map/surfel_map.hpp"

namespace majak::match {

/// Points in the robot's frame (m), one array a coordinate so that loops vectorise.
struct ScanPoints {
  Vec2 laser = Vec2::Zero();  ///< m, where the beams begin
  std::vector<float> x, y;
  /// Unit normals. (0, 0): a small thing without a surface (a leg, a trunk), a point to be met
  /// itself; or a stray return of which nothing is known, see `target`.
  std::vector<float> nx, ny;
  /// May others be matched to it? Not to a stray return: along a wall seen at a flat angle these
  /// lie a metre apart, and matching points to them would hold the robot where it was.
  std::vector<std::uint8_t> target;

  std::size_t size() const { return x.size(); }
};

struct ScanPointsOptions {
  double max_range = 60.0;      ///< m, longer returns are not matched
  double min_range = 0.05;      ///< m, shorter ones are the robot itself
  double normal_window = 0.25;  ///< m, neighbours this near on both sides make the normal
  double point_size = 0.15;     ///< m, a cluster without a surface up to this size is a point
  double max_flatness = 0.35;   ///< rms off the line over rms along it, above which it is no line
  Vec3 twist = Vec3::Zero();  ///< m/s, m/s, rad/s in the robot's axes while the mirror turned; the
                              ///< points are then as seen from where beam 0 was fired
  double mirror_turn = 1.0 / 75;  ///< s, one turn of the mirror
  double range_offset = 0;        ///< m, taken off every range
};

/// Where the beams of a scan point to in the robot's frame; kept from scan to scan, because sines
/// would cost as much as the matching.
struct BeamDirections {
  double start = 0, step = 0;  ///< rad
  std::vector<float> cos, sin;

  void update(const Scan& scan);
};

/// s after beam 0 at which a beam was fired. A laser fires every degree: a finer scan is put
/// together from several turns of the mirror.
double beam_time(const Scan& scan, std::size_t beam, double mirror_turn);

/// Returns of `scan` as points. `with_normals` costs a line fit a point.
ScanPoints scan_points(const Scan& scan, const ScanPointsOptions& options, bool with_normals,
                       BeamDirections& directions);
ScanPoints scan_points(const Scan& scan, const ScanPointsOptions& options, bool with_normals);

/// What stands alone before its background, up to `size` m wide (a person, a post, a chair's leg),
/// left out: such things may walk. `depth`: m, by which all beside it must be farther off.
ScanPoints without_lone_things(const ScanPoints& points, double size = 1.0, double depth = 0.3);

/// Merges points with normals into `map`, SurfelMap or SharedSurfelMap, seen from T_map_robot.
template <class Map>
void add_to(Map& map, const ScanPoints& points, const Pose2& T_map_robot);

}  // namespace majak::match
