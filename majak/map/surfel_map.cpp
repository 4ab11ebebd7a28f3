// SPDX-License-Identifier: Apache-2.0
#include "majak/map/surfel_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/simd.hpp"

namespace majak::map {

template <class Arrays>
BasicSurfelMap<Arrays>::BasicSurfelMap(const SurfelMapOptions& options)
    : options_(options), inverse_cell_(static_cast<float>(1.0 / options.cell)) {
  clear();
}

template <class Arrays>
void BasicSurfelMap<Arrays>::clear() {
  blocks_wide_ = blocks_high_ = 0;
  blocks_.assign(1, 0);
  tiles_.assign(kTilesInBlock, 0);
  nearest_.clear();
  nearest_.resize(kCellsInTile, kNone);
  distance2_.clear();
  distance2_.resize(kCellsInTile, 0.0F);
  surfels_.clear();
  count_.clear();
  behind_.clear();
}

template <class Arrays>
std::size_t BasicSurfelMap<Arrays>::tables_bytes() const {
  return (blocks_.capacity() + tiles_.capacity()) * sizeof(std::int32_t);
}

template <class Arrays>
std::size_t BasicSurfelMap<Arrays>::bytes() const {
  return tables_bytes() + Arrays::bytes(nearest_) + Arrays::bytes(distance2_) +
         Arrays::bytes(surfels_) + Arrays::bytes(count_) + Arrays::bytes(behind_);
}

template <class Arrays>
double BasicSurfelMap<Arrays>::share_of_bytes() const requires std::same_as<Arrays, SharedArrays> {
  return static_cast<double>(tables_bytes()) + nearest_.share_of_bytes() +
         distance2_.share_of_bytes() + surfels_.share_of_bytes() + count_.share_of_bytes() +
         behind_.share_of_bytes();
}

template <class Arrays>
MAJAK_VECTORIZED void BasicSurfelMap<Arrays>::nearest(const float* x, const float* y, std::size_t n,
                                                      std::uint32_t* surfel) const {
  for (std::size_t i = 0; i < n; ++i) surfel[i] = nearest(x[i], y[i]);
}

template <class Arrays>
void BasicSurfelMap<Arrays>::add(float x, float y, float nx, float ny) {
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
      Arrays::write(behind_, at) = static_cast<std::uint32_t>(surfels_.size());
      break;
    }
    at = behind;
  }
  surfels_.push_back({x, y, nx, ny});
  count_.push_back(1.0F);
  behind_.push_back(kNone);
  stamp(static_cast<std::uint32_t>(surfels_.size() - 1));
}

template <class Arrays>
void BasicSurfelMap<Arrays>::merge(std::uint32_t index, float x, float y, float nx, float ny) {
  Surfel& s = Arrays::write(surfels_, index);
  float& count = Arrays::write(count_, index);
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

template <class Arrays>
MAJAK_VECTORIZED void BasicSurfelMap<Arrays>::stamp(std::uint32_t index) {
  const Surfel s = surfels_[index];
  const auto cell = static_cast<float>(options_.cell), reach = static_cast<float>(options_.reach);
  const int x0 = cell_of(s.x - reach), x1 = cell_of(s.x + reach);
  const int y0 = cell_of(s.y - reach), y1 = cell_of(s.y + reach);
  for (int ty = y0 >> kTileBits; ty <= y1 >> kTileBits; ++ty) {
    for (int tx = x0 >> kTileBits; tx <= x1 >> kTileBits; ++tx) {
      const std::size_t tile = tile_begin(tx, ty);
      const int bx = tx * kTileSize, by = ty * kTileSize;
      const int first = std::max(x0, bx), last = std::min(x1, bx + kTileSize - 1);
      for (int iy = std::max(y0, by); iy <= std::min(y1, by + kTileSize - 1); ++iy) {
        const float dy = (static_cast<float>(iy) + 0.5F) * cell - s.y;
        const std::size_t row = tile + static_cast<std::size_t>(in_tile(first, iy));
        float* distance2 = &Arrays::write(distance2_, row);
        std::uint32_t* nearest = &Arrays::write(nearest_, row);
        for (int k = 0; k <= last - first; ++k) {
          const float dx = (static_cast<float>(first + k) + 0.5F) * cell - s.x;
          const float d2 = dx * dx + dy * dy;
          const bool nearer = d2 < distance2[k];
          distance2[k] = nearer ? d2 : distance2[k];
          nearest[k] = nearer ? index : nearest[k];
        }
      }
    }
  }
}

template <class Arrays>
std::size_t BasicSurfelMap<Arrays>::tile_begin(int tile_x, int tile_y) {
  const int block_x = tile_x >> kBlockBits, block_y = tile_y >> kBlockBits;
  if (block_x < block_x0_ || block_x >= block_x0_ + blocks_wide_ || block_y < block_y0_ ||
      block_y >= block_y0_ + blocks_high_)
    grow(block_x, block_y);
  std::int32_t& block = blocks_[static_cast<std::size_t>(block_y - block_y0_) *
                                    static_cast<std::size_t>(blocks_wide_) +
                                static_cast<std::size_t>(block_x - block_x0_)];
  if (block == 0) {
    block = static_cast<std::int32_t>(tiles_.size() / kTilesInBlock);
    tiles_.resize(tiles_.size() + kTilesInBlock, 0);
  }
  std::int32_t& tile = tiles_[static_cast<std::size_t>(block) * kTilesInBlock +
                              static_cast<std::size_t>(in_block(tile_x, tile_y))];
  if (tile == 0) {
    tile = static_cast<std::int32_t>(nearest_.size() / kCellsInTile);
    const auto reach = static_cast<float>(options_.reach);
    nearest_.resize(nearest_.size() + kCellsInTile, kNone);
    distance2_.resize(distance2_.size() + kCellsInTile, reach * reach);
  }
  return static_cast<std::size_t>(tile) * kCellsInTile;
}

// The rectangle of blocks grows by half on the side where it must; behind its end is one for all
// that lies outside.
template <class Arrays>
void BasicSurfelMap<Arrays>::grow(int block_x, int block_y) {
  int x0 = block_x0_, y0 = block_y0_, x1 = x0 + blocks_wide_, y1 = y0 + blocks_high_;
  if (blocks_wide_ == 0) {
    x0 = block_x, y0 = block_y, x1 = block_x + 1, y1 = block_y + 1;
  } else {
    const int margin_x = (x1 - x0) / 2, margin_y = (y1 - y0) / 2;
    if (block_x < x0) x0 = block_x - margin_x;
    if (block_x >= x1) x1 = block_x + 1 + margin_x;
    if (block_y < y0) y0 = block_y - margin_y;
    if (block_y >= y1) y1 = block_y + 1 + margin_y;
  }
  const auto wide = static_cast<std::size_t>(x1 - x0), high = static_cast<std::size_t>(y1 - y0);
  std::vector<std::int32_t> blocks(wide * high + 1, 0);
  for (int row = 0; row < blocks_high_; ++row) {
    const auto from = blocks_.begin() + static_cast<std::ptrdiff_t>(row) * blocks_wide_;
    std::copy(from, from + blocks_wide_,
              blocks.begin() + static_cast<std::ptrdiff_t>(row + block_y0_ - y0) * (x1 - x0) +
                  (block_x0_ - x0));
  }
  blocks_ = std::move(blocks);
  block_x0_ = x0, block_y0_ = y0;
  blocks_wide_ = x1 - x0, blocks_high_ = y1 - y0;
}

void OlderSurfels::nearest(const float* x, const float* y, std::size_t n,
                           std::uint32_t* surfel) const {
  map_.nearest(x, y, n, surfel);
  for (std::size_t i = 0; i < n; ++i)
    if (surfel[i] >= count_) surfel[i] = SharedSurfelMap::kNone;
}

template class BasicSurfelMap<OwnArrays>;
template class BasicSurfelMap<SharedArrays>;

}  // namespace majak::map
