// SPDX-License-Identifier: Apache-2.0
// An occupancy grid as pictures: map.png to look at, map.pgm + map.yaml for programs that read the
// map_server convention (dark is occupied, p = (255 - value) / 255, origin at the lower left).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "majak/io/png.hpp"
#include "majak/map/known_map.hpp"
#include "majak/map/occupancy_grid.hpp"

namespace majak::io {

/// Where a picture of the grid lies in the map.
struct MapFrame {
  map::CellBox box;           ///< cells shown, a margin of unknown ones around the known
  int cells_per_pixel = 1;    ///< along a side; more than 1 when the grid would exceed max_pixels
  int width = 0, height = 0;  ///< pixels
  double pixel = 0;           ///< m, side of a pixel
  double x0 = 0, y0 = 0;      ///< m, the lower left corner of the lower left pixel
};

MapFrame frame_of(const map::OccupancyGrid& grid, std::size_t max_pixels = std::size_t{1} << 25);

/// Grey picture, the top row at high y: unknown grey, free white, occupied black, unsure between.
/// Where several cells share a pixel, the most occupied known one is shown.
Image shaded_map(const map::OccupancyGrid& grid, const MapFrame& frame);

/// The three values of the map_server convention: 0 occupied, 254 free, 205 unknown or undecided.
Image trinary_map(const map::OccupancyGrid& grid, const MapFrame& frame);

Image trinary_map(const map::KnownMap& known);

/// Binary PGM (P5) of a grey picture.
std::string pgm_text(const Image& image);

/// map.yaml for an image of that name.
std::string map_yaml(const MapFrame& frame, const std::string& image_name);
std::string map_yaml(const map::KnownMap& known, const std::string& image_name);

/// Writes map.png, map.pgm and map.yaml into the folder, each whole or not at all.
void write_map_files(const std::filesystem::path& folder, const map::OccupancyGrid& grid);

/// keepout.pgm and keepout.yaml, the same size as map.pgm: forbidden zones occupied and all else
/// free, as the keepout filter of Nav2 wants it. A site without such zones leaves neither file.
void write_keepout_files(const std::filesystem::path& folder, const map::OccupancyGrid& grid,
                         const Site& site);

}  // namespace majak::io
