// SPDX-License-Identifier: Apache-2.0
// Walls out of the files that segment_files writes, and out of others' as far as they are straight
// lines: GeoJSON (lines and polygons), WKT, the LINEs of a DXF, the <line>s of an SVG.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "majak/map/segments.hpp"

namespace majak::io {

/// Does this file name's end tell of such a file? .geojson, .json, .wkt, .dxf, .svg
bool is_segment_file(const std::filesystem::path& path);

/// `text` of a file whose name ends in `kind` (".wkt" ...). Metres; a wall shows to its left; lines
/// without length are left out. Throws Error (name, what is wrong).
std::vector<map::Segment> parse_segments(const std::string& text, const std::string& kind,
                                         const std::string& name);

}  // namespace majak::io
