// SPDX-License-Identifier: Apache-2.0
// SurfelMap: surface elements (a mean point, a normal, a count) with a grid that knows for every
// cell the nearest of them. A look-up costs one array access, a scan is merged in a few
// microseconds, and a wall seen a hundred times is one row of well averaged surfels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace majak::map {

struct Surfel {
  float x = 0, y = 0;    ///< m, mean of the merged points
  float nx = 0, ny = 0;  ///< unit normal towards the side it was seen from; (0, 0): not a surface
};

struct SurfelMapOptions {
  double cell = 0.05;          ///< m
  double reach = 0.30;         ///< m, a cell knows surfels no farther than this
  double merge_radius = 0.05;  ///< m, nearer points are merged into the surfel
  double max_count = 50;       ///< a surfel's memory: later points move it by 1 / max_count
};

class SurfelMap {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffU;

  explicit SurfelMap(const SurfelMapOptions& options = {});

  /// Index of the surfel nearest to the cell of (x, y), or kNone.
  std::uint32_t nearest(float x, float y) const {
    const int ix = cell_of(x), iy = cell_of(y);
    const unsigned tx = static_cast<unsigned>((ix >> kTileBits) - tile_x0_);
    const unsigned ty = static_cast<unsigned>((iy >> kTileBits) - tile_y0_);
    if (tx >= tiles_wide_ || ty >= tiles_high_) return kNone;
    const std::int32_t tile = tile_index_[ty * tiles_wide_ + tx];
    if (tile < 0) return kNone;
    return nearest_[(static_cast<std::size_t>(tile) << (2 * kTileBits)) + in_tile(ix, iy)];
  }
  /// The same for n points at once.
  void nearest(const float* x, const float* y, std::size_t n, std::uint32_t* surfel) const;

  const Surfel& surfel(std::uint32_t index) const { return surfels_[index]; }
  const std::vector<Surfel>& surfels() const { return surfels_; }

  /// Merges a point with its normal (map frame) into the surfel it lies on, or makes a new one.
  void add(float x, float y, float nx, float ny);

  /// Forgets everything, keeps the memory.
  void clear();
  std::size_t bytes() const;

 private:
  static constexpr int kMostSides = 3;  // beside the first, in one place
  static constexpr int kTileBits = 4;
  static constexpr int kTileSize = 1 << kTileBits;
  static constexpr float kShift = 65536;  // makes coordinates positive, where truncation is floor

  int cell_of(float v) const {
    return static_cast<int>(v * inverse_cell_ + kShift) - static_cast<int>(kShift);
  }
  static std::size_t in_tile(int ix, int iy) {
    return static_cast<std::size_t>(((iy & (kTileSize - 1)) << kTileBits) | (ix & (kTileSize - 1)));
  }
  void merge(std::uint32_t index, float x, float y, float nx, float ny);
  void stamp(std::uint32_t index);
  std::size_t tile_begin(int tile_x, int tile_y);
  void grow(int tile_x, int tile_y);

  SurfelMapOptions options_;
  float inverse_cell_;
  int tile_x0_ = 0, tile_y0_ = 0;
  unsigned tiles_wide_ = 0, tiles_high_ = 0;
  std::vector<std::int32_t> tile_index_;
  std::vector<std::uint32_t> nearest_;  // surfel of each cell, tile by tile
  std::vector<float> distance2_;        // m^2, from it to the cell's centre
  std::vector<Surfel> surfels_;
  std::vector<float> count_;           // merged points of each surfel
  std::vector<std::uint32_t> behind_;  // another side of the same place, or kNone
};

}  // namespace majak::map
