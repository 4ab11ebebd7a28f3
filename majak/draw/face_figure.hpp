// SPDX-License-Identifier: Apache-2.0
// What figures of faces have in common: a sheet that fits the place, and cells as pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "majak/draw/figure.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/tiles.hpp"

namespace majak::draw {

/// One panel in metres of the map's frame, 1000 points wide and as high as the marks ask.
Figure map_sheet(std::string title, std::vector<Mark> marks, std::vector<LegendEntry> legend = {});

/// Cells as pixels, `colour` of each. A box larger than `max_pixels` along a side is drawn with
/// every n-th cell. Nothing for an empty box.
std::optional<Picture> cells_picture(const map::CellBox& box, double resolution,
                                     const std::function<Colour(int ix, int iy)>& colour);

/// As map.png: unknown grey, free white, occupied black.
Picture grid_picture(const map::OccupancyGrid& grid);

}  // namespace majak::draw
