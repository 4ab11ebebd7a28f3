// SPDX-License-Identifier: Apache-2.0
// Segments for other programs: SVG for browsers, DXF for CAD, GeoJSON and WKT for GIS. All are in
// the metres of the map's frame (GeoJSON too: no place on Earth is claimed), with 0.1 mm, and keep
// the way from a to b: the side a surface was seen from is to its left.
#pragma once

#include <span>
#include <string>

#include "majak/map/segments.hpp"

namespace majak::io {

/// One <line> a segment in a drawing of 1 m a unit, y up, 1 m of margin around.
std::string segments_svg(std::span<const map::Segment> segments);

/// DXF of AutoCAD R12 (AC1009): a LINE a segment on layer WALLS.
std::string segments_dxf(std::span<const map::Segment> segments);

/// A FeatureCollection of LineStrings. Properties: length (m), points, scans, sigma_offset (m, at
/// the middle), sigma_angle (rad), sigma_a and sigma_b (m, of the ends along the line).
std::string segments_geojson(std::span<const map::Segment> segments);

/// One MULTILINESTRING.
std::string segments_wkt(std::span<const map::Segment> segments);

}  // namespace majak::io
