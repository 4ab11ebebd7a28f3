// SPDX-License-Identifier: Apache-2.0
// Segments for other programs: SVG for browsers, DXF for CAD, GeoJSON and WKT for GIS. All are in
// the metres of the map's frame (GeoJSON too: no place on Earth is claimed), with 0.1 mm, and keep
// the way from a to b: the side a surface was seen from is to its left.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "majak/map/segments.hpp"

namespace majak::io {

/// Corners of polygons, map frame: where robots must not go. io/segment_reader takes none of them
/// for walls.
using Zones = std::vector<std::vector<Vec2>>;

/// One <line> a segment in a drawing of 1 m a unit, y up, 1 m of margin around; a <polygon> a zone.
std::string segments_svg(std::span<const map::Segment> segments, const Zones& forbidden);

/// DXF of AutoCAD R12 (AC1009): a LINE a segment on layer WALLS, a closed POLYLINE a zone on layer
/// FORBIDDEN.
std::string segments_dxf(std::span<const map::Segment> segments, const Zones& forbidden);

/// A FeatureCollection of LineStrings. Properties: length (m), points, scans, sigma_offset (m, at
/// the middle), sigma_angle (rad), sigma_a and sigma_b (m, of the ends along the line). A zone is a
/// Polygon of the kind "forbidden".
std::string segments_geojson(std::span<const map::Segment> segments, const Zones& forbidden);

/// One MULTILINESTRING; with zones a GEOMETRYCOLLECTION of it and a POLYGON each.
std::string segments_wkt(std::span<const map::Segment> segments, const Zones& forbidden);

/// The same without zones.
std::string segments_svg(std::span<const map::Segment> segments);
std::string segments_dxf(std::span<const map::Segment> segments);
std::string segments_geojson(std::span<const map::Segment> segments);
std::string segments_wkt(std::span<const map::Segment> segments);

}  // namespace majak::io
