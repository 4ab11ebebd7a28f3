// SPDX-License-Identifier: Apache-2.0
#include "majak/map/surfel_map.hpp"

#include <algorithm>
#include <cmath>

namespace majak::map {

SurfelMap::SurfelMap(const SurfelMapOptions& options)
    : options_(options), inverse_cell_(static_cast<float>(1.0 / options.cell)) {}

void SurfelMap::clear() {
  std::fill(tile_index_.begin(), tile_index_.end(), -1);
  nearest_.clear();
  distance2_.clear();
  surfels_.clear();
  count_.clear();
  behind_.clear();
}

std::size_t SurfelMap::bytes() const {
  return tile_index_.capacity() * sizeof(std::int32_t) +
         nearest_.capacity() * (sizeof(std::uint32_t) + sizeof(float)) +
         surfels_.capacity() * (sizeof(Surfel) + sizeof(float) + sizeof(std::uint32_t));
}

void SurfelMap::nearest(const float* x, const float* y, std::size_t n,
                        std::uint32_t* surfel) const {
  for (std::size_t i = 0; i < n; ++i) surfel[i] = nearest(x[i], y[i]);
}

void SurfelMap::add(float x, float y, float nx, float ny) {
  const auto merge2 = static_cast<float>(options_.merge_radius * options_.merge_radius);
  // Both sides of a thin wall, or the sides of an edge, are surfaces of their own in one place:
  // what was put behind a surfel is asked in turn. After the last of them no further one is begun
  // there.
  std::uint32_t at = nearest(x, y);
  for (int sides = 0; at != kNone; ++sides) {
    const Surfel& s = surfels_[at];
    const float dx = x - s.x, dy = y - s.y;
    if (dx * dx + dy * dy >= merge2) break;
    const bool same_side =
        s.nx * nx + s.ny * ny > 0.5F || (nx == 0 && ny == 0) || (s.nx == 0 && s.ny == 0);
    if (same_side || sides == kMostSides) return merge(at, x, y, nx, ny);
    const std::uint32_t behind = behind_[at];
    if (behind == kNone) {
      behind_[at] = static_cast<std::uint32_t>(surfels_.size());
      break;
    }
    at = behind;
  }
  surfels_.push_back({x, y, nx, ny});
  count_.push_back(1.0F);
  behind_.push_back(kNone);
  stamp(static_cast<std::uint32_t>(surfels_.size() - 1));
}

void SurfelMap::merge(std::uint32_t index, float x, float y, float nx, float ny) {
  Surfel& s = surfels_[index];
  float& count = count_[index];
  const float gain = 1.0F / (count + 1.0F);
  s.x += gain * (x - s.x);
  s.y += gain * (y - s.y);
  if (nx != 0 || ny != 0) {
    const float mx = s.nx + gain * (nx - s.nx), my = s.ny + gain * (ny - s.ny);
    const float norm = std::sqrt(mx * mx + my * my);
    if (norm > 1e-6F) s.nx = mx / norm, s.ny = my / norm;
  }
  count = std::min(count + 1.0F, static_cast<float>(options_.max_count));
}

void SurfelMap::stamp(std::uint32_t index) {
  const Surfel& s = surfels_[index];
  const auto cell = static_cast<float>(options_.cell), reach = static_cast<float>(options_.reach);
  const int x0 = cell_of(s.x - reach), x1 = cell_of(s.x + reach);
  const int y0 = cell_of(s.y - reach), y1 = cell_of(s.y + reach);
  const float reach2 = reach * reach;
  for (int ty = y0 >> kTileBits; ty <= y1 >> kTileBits; ++ty) {
    for (int tx = x0 >> kTileBits; tx <= x1 >> kTileBits; ++tx) {
      const std::size_t tile = tile_begin(tx, ty);
      const int bx = tx * kTileSize, by = ty * kTileSize;
      const int first = std::max(x0, bx), last = std::min(x1, bx + kTileSize - 1);
      for (int iy = std::max(y0, by); iy <= std::min(y1, by + kTileSize - 1); ++iy) {
        const float dy = (static_cast<float>(iy) + 0.5F) * cell - s.y;
        const float bound = reach2 - dy * dy;
        const std::size_t row = tile + in_tile(first, iy);
        float* distance2 = &distance2_[row];
        std::uint32_t* nearest = &nearest_[row];
        for (int k = 0; k <= last - first; ++k) {
          const float dx = (static_cast<float>(first + k) + 0.5F) * cell - s.x;
          const float d2 = dx * dx + dy * dy;
          const bool nearer = d2 < distance2[k] && dx * dx <= bound;
          distance2[k] = nearer ? d2 : distance2[k];
          nearest[k] = nearer ? index : nearest[k];
        }
      }
    }
  }
}

std::size_t SurfelMap::tile_begin(int tile_x, int tile_y) {
  if (static_cast<unsigned>(tile_x - tile_x0_) >= tiles_wide_ ||
      static_cast<unsigned>(tile_y - tile_y0_) >= tiles_high_)
    grow(tile_x, tile_y);
  std::int32_t& tile = tile_index_[static_cast<std::size_t>(tile_y - tile_y0_) * tiles_wide_ +
                                   static_cast<std::size_t>(tile_x - tile_x0_)];
  constexpr std::size_t kCells = std::size_t{1} << (2 * kTileBits);
  if (tile < 0) {
    tile = static_cast<std::int32_t>(nearest_.size() / kCells);
    nearest_.resize(nearest_.size() + kCells, kNone);
    distance2_.resize(distance2_.size() + kCells, 1e30F);
  }
  return static_cast<std::size_t>(tile) * kCells;
}

// The index of tiles is a dense rectangle that grows by half on the side where it must.
void SurfelMap::grow(int tile_x, int tile_y) {
  int x0 = tile_x0_, y0 = tile_y0_;
  int x1 = x0 + static_cast<int>(tiles_wide_), y1 = y0 + static_cast<int>(tiles_high_);
  if (tiles_wide_ == 0) {
    x0 = tile_x - 4, y0 = tile_y - 4, x1 = tile_x + 5, y1 = tile_y + 5;
  } else {
    const int margin_x = 4 + (x1 - x0) / 2, margin_y = 4 + (y1 - y0) / 2;
    if (tile_x < x0) x0 = tile_x - margin_x;
    if (tile_x >= x1) x1 = tile_x + margin_x;
    if (tile_y < y0) y0 = tile_y - margin_y;
    if (tile_y >= y1) y1 = tile_y + margin_y;
  }
  std::vector<std::int32_t> index(
      static_cast<std::size_t>(x1 - x0) * static_cast<std::size_t>(y1 - y0), -1);
  for (unsigned row = 0; row < tiles_high_; ++row)
    for (unsigned col = 0; col < tiles_wide_; ++col)
      index[static_cast<std::size_t>(static_cast<int>(row) + tile_y0_ - y0) *
                static_cast<std::size_t>(x1 - x0) +
            static_cast<std::size_t>(static_cast<int>(col) + tile_x0_ - x0)] =
          tile_index_[row * tiles_wide_ + col];
  tile_index_ = std::move(index);
  tile_x0_ = x0, tile_y0_ = y0;
  tiles_wide_ = static_cast<unsigned>(x1 - x0), tiles_high_ = static_cast<unsigned>(y1 - y0);
}

}  // namespace majak::map
