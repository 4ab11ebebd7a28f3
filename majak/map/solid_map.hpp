// SPDX-License-Identifier: Apache-2.0
// The solid of a place that a laser out of the plane has seen: what is flat as rectangles, what is
// not as the small triangles of neighbouring beams, coloured by how strong the echoes were. MATH
// 22.3.
//
//   SolidPoints points(site, looking("up"));
//   while (auto event = log.next()) ...  // points.add(scan)
//   const SolidCloud cloud = points.cloud();
//   const Solid solid = build_solid(cloud, find_planes(cloud));
#pragma once

#include "majak/map/planes.hpp"
#include "majak/map/solid.hpp"
#include "majak/map/solid_points.hpp"

namespace majak::map {

struct SolidOptions {
  double close = 0.25;  ///< m; gaps in a plane up to twice as wide are filled
};

inline void describe(OptionFields& fields, SolidOptions& o) {
  fields.add("solid.close", o.close, {"m", "gaps in planes up to twice as wide are filled", 0, 10});
}

/// A part a plane, named "wall 1", "floor 1" (faces up), "ceiling 1" (faces down) or "slope 1", and
/// last "rest": triangles of which a corner is of no plane. Colours are greys by the logarithm of
/// the intensity; without intensities each plane has a hue of its own.
/// Throws Error when an option is out of its range.
Solid build_solid(const SolidCloud& cloud, const PlaneMap& planes,
                  const SolidOptions& options = {});

/// All points as one cloud, "points", and all triangles as they are, "mesh".
Solid points_solid(const SolidCloud& cloud);
Solid mesh_solid(const SolidCloud& cloud);

}  // namespace majak::map
