// SPDX-License-Identifier: Apache-2.0
// Maps to be localized on, as they lie about: the folder of a run, its site.majak, PGM or PNG with
// a YAML beside it in the map_server convention, a bare picture and the size of its pixels, or
// walls as GeoJSON, WKT, DXF or SVG.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "majak/core/site.hpp"
#include "majak/io/png.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/segments.hpp"

namespace majak::io {

struct MapInput {
  std::optional<Site> site;            ///< of a run: where its scans saw surfaces is known
  std::optional<map::KnownMap> known;  ///< of a picture
  std::vector<map::Segment> segments;  ///< of a file of walls (io/segment_reader)
  /// From the map's own frame, whose axes are the picture's, to that of the YAML file.
  Pose2 T_world_map;
};

/// `resolution`: m, side of a pixel of a picture without a YAML; 0: not told. Throws Error (file,
/// what is wrong, what to do).
MapInput read_map(const std::filesystem::path& path, double resolution = 0);

/// How grey values become cells (map_server: 0 is occupied, 254 free, 205 unknown).
struct MapKey {
  double resolution = 0.05;  ///< m
  double occupied = 0.65;    ///< probabilities of being occupied above this ...
  double free = 0.196;       ///< ... and below this
  bool negate = false;       ///< white is occupied
  bool percent = false;      ///< "raw": values are 0 ... 100, more is unknown
};
map::KnownMap known_map(const Image& picture, const MapKey& key);

/// Binary or plain PGM, 8 or 16 bits. Throws Error (name, what is wrong).
Image decode_pgm(const std::string& bytes, const std::string& name);

}  // namespace majak::io
