// SPDX-License-Identifier: Apache-2.0
// SurfelMap: surface elements (a mean point, a normal, a count) with a grid that knows for every
// cell the nearest of them. A look-up costs one array access, a scan is merged in a few
// microseconds, and a wall seen a hundred times is one row of well averaged surfels.
// SharedSurfelMap: the same for many versions of one map; copies share what they have in common.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "majak/map/shared_array.hpp"

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

/// Where a map keeps its cells and surfels: alone, or together with its copies.
struct OwnArrays {
  template <class T, int kPageBits>
  using Array = std::vector<T>;
  template <class T>
  static T& write(std::vector<T>& array, std::size_t i) {
    return array[i];
  }
  template <class T>
  static std::size_t bytes(const std::vector<T>& array) {
    return array.capacity() * sizeof(T);
  }
};
struct SharedArrays {
  template <class T, int kPageBits>
  using Array = SharedArray<T, kPageBits>;
  template <class T, int kPageBits>
  static T& write(SharedArray<T, kPageBits>& array, std::size_t i) {
    return array.write(i);
  }
  template <class T, int kPageBits>
  static std::size_t bytes(const SharedArray<T, kPageBits>& array) {
    return array.bytes();
  }
};

template <class Arrays>
class BasicSurfelMap {
  template <class T>
  using SurfelArray = typename Arrays::template Array<T, 6>;

 public:
  static constexpr std::uint32_t kNone = 0xffffffffU;

  explicit BasicSurfelMap(const SurfelMapOptions& options = {});

  /// Index of the surfel nearest to the cell of (x, y), or kNone.
  std::uint32_t nearest(float x, float y) const {
    const int ix = cell_of(x), iy = cell_of(y);
    const int tx = ix >> kTileBits, ty = iy >> kTileBits;
    const int bx = (tx >> kBlockBits) - block_x0_, by = (ty >> kBlockBits) - block_y0_;
    const bool inside = (bx >= 0) & (bx < blocks_wide_) & (by >= 0) & (by < blocks_high_);
    const int block = blocks_.data()[inside ? by * blocks_wide_ + bx : blocks_wide_ * blocks_high_];
    const int tile = tiles_.data()[(block << (2 * kBlockBits)) + in_block(tx, ty)];
    return nearest_[static_cast<std::size_t>((tile << (2 * kTileBits)) + in_tile(ix, iy))];
  }
  /// The same for n points at once.
  void nearest(const float* x, const float* y, std::size_t n, std::uint32_t* surfel) const;

  const Surfel& surfel(std::uint32_t index) const { return surfels_[index]; }
  const SurfelArray<Surfel>& surfels() const { return surfels_; }

  /// Merges a point with its normal (map frame) into the surfel it lies on, or makes a new one.
  void add(float x, float y, float nx, float ny);

  /// Forgets everything, keeps the memory.
  void clear();
  /// Of this map, whoever else has parts of it.
  std::size_t bytes() const;
  /// A part of n maps counts by an n-th: over all copies this adds up to what they need together.
  double share_of_bytes() const requires std::same_as<Arrays, SharedArrays>;

 private:
  static constexpr int kMostSides = 3;  // beside the first, in one place
  // A tile is 16 x 16 cells, a block 32 x 32 tiles. Tile 0 and block 0 are empty ones, for all that
  // nothing was seen of, so that a look-up needs no branches.
  static constexpr int kTileBits = 4, kTileSize = 1 << kTileBits;
  static constexpr int kBlockBits = 5, kBlockSize = 1 << kBlockBits;
  static constexpr std::size_t kCellsInTile = std::size_t{1} << (2 * kTileBits);
  static constexpr std::size_t kTilesInBlock = std::size_t{1} << (2 * kBlockBits);
  template <class T>
  using CellArray = typename Arrays::template Array<T, 2 * kTileBits>;
  static constexpr float kShift = 65536;  // makes coordinates positive, where truncation is floor

  int cell_of(float v) const {
    return static_cast<int>(v * inverse_cell_ + kShift) - static_cast<int>(kShift);
  }
  static int in_tile(int ix, int iy) {
    return ((iy & (kTileSize - 1)) << kTileBits) | (ix & (kTileSize - 1));
  }
  static int in_block(int tile_x, int tile_y) {
    return ((tile_y & (kBlockSize - 1)) << kBlockBits) | (tile_x & (kBlockSize - 1));
  }
  void merge(std::uint32_t index, float x, float y, float nx, float ny);
  void stamp(std::uint32_t index);
  std::size_t tables_bytes() const;
  std::size_t tile_begin(int tile_x, int tile_y);
  void grow(int block_x, int block_y);

  SurfelMapOptions options_;
  float inverse_cell_;
  int block_x0_ = 0, block_y0_ = 0;
  int blocks_wide_ = 0, blocks_high_ = 0;
  std::vector<std::int32_t> blocks_;  // number of the block, a dense rectangle of them
  std::vector<std::int32_t> tiles_;   // number of the tile, block by block
  CellArray<std::uint32_t> nearest_;  // surfel of each cell, tile by tile
  CellArray<float> distance2_;        // m^2, from it to the cell's centre
  SurfelArray<Surfel> surfels_;
  SurfelArray<float> count_;           // merged points of each surfel
  SurfelArray<std::uint32_t> behind_;  // another side of the same place, or kNone
};

using SurfelMap = BasicSurfelMap<OwnArrays>;
using SharedSurfelMap = BasicSurfelMap<SharedArrays>;

/// A map as it was known when it had `count` surfels: younger ones are not seen. Those that were
/// there may have been moved since.
class OlderSurfels {
 public:
  OlderSurfels(const SharedSurfelMap& map, std::uint32_t count) : map_(map), count_(count) {}
  void nearest(const float* x, const float* y, std::size_t n, std::uint32_t* surfel) const;
  const Surfel& surfel(std::uint32_t index) const { return map_.surfel(index); }

 private:
  const SharedSurfelMap& map_;
  std::uint32_t count_;
};

extern template class BasicSurfelMap<OwnArrays>;
extern template class BasicSurfelMap<SharedArrays>;

}  // namespace majak::map
