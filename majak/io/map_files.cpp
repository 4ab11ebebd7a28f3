// SPDX-License-Identifier: Apache-2.0
#include "majak/io/map_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstdint>
#include <vector>

#include "majak/io/atomic_file.hpp"
#include "majak/map/edits.hpp"

namespace majak::io {

namespace {

using map::OccupancyGrid;

constexpr int kMargin = 8;  ///< cells of unknown ground around the map
constexpr std::uint8_t kUnknownValue = 205, kFreeValue = 254, kOccupiedValue = 0;
constexpr double kOccupiedThreshold = 0.65;  ///< probability
constexpr double kFreeThreshold = 0.196;     ///< just below what 205 means
constexpr double kSureOccupied = 2.5;        ///< log-odds that are shown fully black
constexpr double kSureFree = -1.0;           ///< and fully white

std::uint8_t shade(std::int16_t stored) {
  if (stored == OccupancyGrid::kUnknown) return kUnknownValue;
  const double log_odds = stored * OccupancyGrid::kUnit;
  const double share =
      std::min(1.0, log_odds > 0 ? log_odds / kSureOccupied : log_odds / kSureFree);
  const double goal = log_odds > 0 ? 0.0 : 255.0;
  return static_cast<std::uint8_t>(std::lround(kUnknownValue + share * (goal - kUnknownValue)));
}

std::uint8_t trinary(std::int16_t stored) {
  if (stored == OccupancyGrid::kUnknown) return kUnknownValue;
  static const double occupied = std::log(kOccupiedThreshold / (1 - kOccupiedThreshold));
  const double log_odds = stored * OccupancyGrid::kUnit;
  return log_odds >= occupied ? kOccupiedValue : log_odds < 0 ? kFreeValue : kUnknownValue;
}

/// The tiles that exist in one row of tiles, so that the empty ground of a wide map costs nothing.
struct TileRow {
  struct Tile {
    int x0;  ///< its first cell
    const std::int16_t* cells;
  };
  int ty = INT_MIN;
  std::vector<Tile> tiles;

  void find(const OccupancyGrid& grid, int wanted_ty, int x_begin, int x_end) {
    if (wanted_ty == ty) return;
    ty = wanted_ty;
    tiles.clear();
    for (int tx = x_begin >> OccupancyGrid::kTileBits; tx << OccupancyGrid::kTileBits < x_end; ++tx)
      if (const auto* cells = grid.find_tile(tx, ty))
        tiles.push_back({tx << OccupancyGrid::kTileBits, cells});
  }
};

/// Cells of row iy into the pixels that cover them. kUnknown is the least int16, so the maximum is
/// "the most occupied known one".
void merge_row(const TileRow& row, int iy, int x_begin, int x_end, int cells_per_pixel,
               std::vector<std::int16_t>& best) {
  const std::ptrdiff_t y_in_tile = iy & (OccupancyGrid::kTileSize - 1);
  for (const TileRow::Tile& tile : row.tiles) {
    const std::int16_t* cells = tile.cells + y_in_tile * OccupancyGrid::kTileSize;
    const int begin = std::max(tile.x0, x_begin);
    const int end = std::min(tile.x0 + OccupancyGrid::kTileSize, x_end);
    auto pixel = best.begin() + (begin - x_begin) / cells_per_pixel;
    int part = (begin - x_begin) % cells_per_pixel;
    for (int ix = begin; ix < end; ++ix) {
      *pixel = std::max(*pixel, cells[ix - tile.x0]);
      if (++part < cells_per_pixel) continue;
      part = 0;
      ++pixel;
    }
  }
}

template <class ToValue>
Image render(const OccupancyGrid& grid, const MapFrame& frame, ToValue to_value) {
  std::vector<std::uint8_t> values(1U << 16);
  for (int stored = INT16_MIN; stored <= INT16_MAX; ++stored) {
    values[static_cast<std::uint16_t>(stored)] = to_value(static_cast<std::int16_t>(stored));
  }
  Image image(frame.width, frame.height, 1);
  const int n = frame.cells_per_pixel;
  const int x_begin = frame.box.x0, x_end = frame.box.x0 + frame.box.width;
  TileRow row;
  std::vector<std::int16_t> best(static_cast<std::size_t>(frame.width));
  for (int y = 0; y < frame.height; ++y) {
    std::fill(best.begin(), best.end(), OccupancyGrid::kUnknown);
    for (int sub = 0; sub < n; ++sub) {
      const int iy = frame.box.y0 + y * n + sub;
      row.find(grid, iy >> OccupancyGrid::kTileBits, x_begin, x_end);
      merge_row(row, iy, x_begin, x_end, n, best);
    }
    std::transform(best.begin(), best.end(), image.row(frame.height - 1 - y),
                   [&](std::int16_t v) { return values[static_cast<std::uint16_t>(v)]; });
  }
  return image;
}

// Ten significant digits: 0.05 * 3 prints as 0.15 and not with the dust of binary fractions.
std::string yaml_text(const std::string& image_name, double pixel, double x0, double y0) {
  return fmt::format(
      "image: {}\nresolution: {:.10g}\norigin: [{:.10g}, {:.10g}, 0]\nnegate: 0\n"
      "occupied_thresh: {}\nfree_thresh: {}\n",
      image_name, pixel, x0, y0, kOccupiedThreshold, kFreeThreshold);
}

}  // namespace

MapFrame frame_of(const OccupancyGrid& grid, std::size_t max_pixels) {
  const map::CellBox known = grid.bounds();
  MapFrame frame;
  frame.box = {known.x0 - kMargin, known.y0 - kMargin, known.width + 2 * kMargin,
               known.height + 2 * kMargin};
  const auto pixels = [&](int n) {
    return std::size_t(frame.box.width / n + 1) * std::size_t(frame.box.height / n + 1);
  };
  int n = 1;
  while (pixels(n) > std::max<std::size_t>(max_pixels, 1) &&
         n < std::max(frame.box.width, frame.box.height))
    ++n;
  frame.cells_per_pixel = n;
  frame.width = (frame.box.width + n - 1) / n;
  frame.height = (frame.box.height + n - 1) / n;
  frame.pixel = grid.resolution() * n;
  frame.x0 = frame.box.x0 * grid.resolution();
  frame.y0 = frame.box.y0 * grid.resolution();
  return frame;
}

Image shaded_map(const OccupancyGrid& grid, const MapFrame& frame) {
  return render(grid, frame, shade);
}

Image trinary_map(const OccupancyGrid& grid, const MapFrame& frame) {
  return render(grid, frame, trinary);
}

Image trinary_map(const map::KnownMap& known) {
  Image image(known.width, known.height, 1);
  for (int iy = 0; iy < known.height; ++iy)
    for (int ix = 0; ix < known.width; ++ix) {
      const map::CellState state = known.at(ix, iy);
      image.row(known.height - 1 - iy)[ix] = state == map::CellState::occupied ? kOccupiedValue
                                             : state == map::CellState::free   ? kFreeValue
                                                                               : kUnknownValue;
    }
  return image;
}

std::string pgm_text(const Image& image) {
  std::string text = fmt::format("P5\n{} {}\n255\n", image.width, image.height);
  text.append(reinterpret_cast<const char*>(image.pixels.data()), image.pixels.size());
  return text;
}

std::string map_yaml(const MapFrame& frame, const std::string& image_name) {
  return yaml_text(image_name, frame.pixel, frame.x0, frame.y0);
}

std::string map_yaml(const map::KnownMap& known, const std::string& image_name) {
  return yaml_text(image_name, known.resolution, known.x0, known.y0);
}

void write_map_files(const std::filesystem::path& folder, const OccupancyGrid& grid) {
  const MapFrame frame = frame_of(grid);
  write_file_atomically(folder / "map.png", encode_png(shaded_map(grid, frame)));
  write_file_atomically(folder / "map.pgm", pgm_text(trinary_map(grid, frame)));
  write_file_atomically(folder / "map.yaml", map_yaml(frame, "map.pgm"));
}

void write_keepout_files(const std::filesystem::path& folder, const OccupancyGrid& grid,
                         const Site& site) {
  if (map::shapes_in_map(site, EditKind::forbidden).empty()) {
    std::error_code ignored;
    for (const char* name : {"keepout.yaml", "keepout.pgm"})
      std::filesystem::remove(folder / name, ignored);
    return;
  }
  const MapFrame frame = frame_of(grid);
  map::KnownMap mask{frame.pixel, frame.x0, frame.y0, frame.width, frame.height, {}};
  mask.cells.assign(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height),
                    map::CellState::free);
  map::forbid(mask, site, map::CellState::occupied);
  write_file_atomically(folder / "keepout.pgm", pgm_text(trinary_map(mask)));
  write_file_atomically(folder / "keepout.yaml", map_yaml(frame, "keepout.pgm"));
}

}  // namespace majak::io
