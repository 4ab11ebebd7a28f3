// SPDX-License-Identifier: Apache-2.0
#include "majak/map/occupancy_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace majak::map {

namespace {

constexpr std::size_t kTileCells = OccupancyGrid::kTileSize * OccupancyGrid::kTileSize;

std::uint64_t tile_key(int tx, int ty) {
  return (std::uint64_t{static_cast<std::uint32_t>(tx)} << 32) | static_cast<std::uint32_t>(ty);
}

std::size_t cell_in_tile(int ix, int iy) {
  constexpr int kMask = OccupancyGrid::kTileSize - 1;
  return static_cast<std::size_t>((iy & kMask) * OccupancyGrid::kTileSize + (ix & kMask));
}

}  // namespace

std::int16_t* OccupancyGrid::tile(int tx, int ty) {
  const auto [place, is_new] = index_.try_emplace(tile_key(tx, ty), tiles_.size());
  if (is_new) {
    places_.push_back({tx, ty});
    tiles_.emplace_back(kTileCells, kUnknown);
  }
  return tiles_[place->second].data();
}

const std::int16_t* OccupancyGrid::find_tile(int tx, int ty) const {
  const auto place = index_.find(tile_key(tx, ty));
  return place == index_.end() ? nullptr : tiles_[place->second].data();
}

std::int16_t OccupancyGrid::stored(int ix, int iy) const {
  const std::int16_t* cells = find_tile(ix >> kTileBits, iy >> kTileBits);
  return cells ? cells[cell_in_tile(ix, iy)] : kUnknown;
}

float OccupancyGrid::log_odds(int ix, int iy) const {
  const std::int16_t value = stored(ix, iy);
  return value == kUnknown ? 0.0F : static_cast<float>(value * kUnit);
}

void OccupancyGrid::set_log_odds(int ix, int iy, float log_odds) {
  tile(ix >> kTileBits, iy >> kTileBits)[cell_in_tile(ix, iy)] =
      static_cast<std::int16_t>(std::lround(log_odds / kUnit));
}

void OccupancyGrid::copy_row(int x0, int iy, int width, std::int16_t* out) const {
  for (int ix = x0; ix < x0 + width;) {
    const int next = std::min(((ix >> kTileBits) + 1) << kTileBits, x0 + width);
    const std::int16_t* cells = find_tile(ix >> kTileBits, iy >> kTileBits);
    if (cells) {
      std::copy_n(cells + cell_in_tile(ix, iy), next - ix, out);
    } else {
      std::fill_n(out, next - ix, kUnknown);
    }
    out += next - ix;
    ix = next;
  }
}

CellBox OccupancyGrid::bounds() const {
  int x_low = std::numeric_limits<int>::max(), x_high = std::numeric_limits<int>::min();
  int y_low = x_low, y_high = x_high;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    for (int y = 0; y < kTileSize; ++y) {
      const auto row = tiles_[i].begin() + y * kTileSize;
      const auto is_known = [](std::int16_t v) { return v != kUnknown; };
      const auto first = std::find_if(row, row + kTileSize, is_known);
      if (first == row + kTileSize) continue;
      auto last = row + kTileSize - 1;
      while (!is_known(*last)) --last;
      x_low = std::min(x_low, places_[i].tx * kTileSize + static_cast<int>(first - row));
      x_high = std::max(x_high, places_[i].tx * kTileSize + static_cast<int>(last - row));
      y_low = std::min(y_low, places_[i].ty * kTileSize + y);
      y_high = std::max(y_high, places_[i].ty * kTileSize + y);
    }
  }
  if (x_low > x_high) return {};
  return {x_low, y_low, x_high - x_low + 1, y_high - y_low + 1};
}

double OccupancyGrid::known_area() const {
  std::ptrdiff_t cells = 0;
  for (const auto& tile : tiles_) {
    cells +=
        static_cast<std::ptrdiff_t>(tile.size()) - std::count(tile.begin(), tile.end(), kUnknown);
  }
  return static_cast<double>(cells) * resolution_ * resolution_;
}

std::size_t OccupancyGrid::bytes() const {
  const std::size_t per_tile = kTileCells * sizeof(std::int16_t) + sizeof(Place) +
                               sizeof(std::vector<std::int16_t>) + 4 * sizeof(std::size_t);
  return sizeof(*this) + tiles_.size() * per_tile;
}

}  // namespace majak::map
