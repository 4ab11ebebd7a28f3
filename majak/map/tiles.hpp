// SPDX-License-Identifier: Apache-2.0
// Tiles: a grid of cells without borders, kept in square tiles where something was written, so that
// memory follows the place and not its bounding box.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace majak::map {

/// Cells [x0, x0 + width) x [y0, y0 + height).
struct CellBox {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  bool operator==(const CellBox&) const = default;
};

template <class Cell>
class Tiles {
 public:
  static constexpr int kBits = 6;
  static constexpr int kSize = 1 << kBits;  ///< cells along a tile's side

  /// `blank`: what cells are before they are written.
  explicit Tiles(Cell blank = {}) : blank_(std::move(blank)) {}

  /// The kSize x kSize cells of a tile, row by row from low y; cell (ix, iy) is in tile
  /// (ix >> kBits, iy >> kBits). Made when missing; valid until the next one is made.
  Cell* tile(int tx, int ty) {
    const auto [place, is_new] = index_.try_emplace(key(tx, ty), tiles_.size());
    if (is_new) {
      places_.push_back({tx, ty});
      tiles_.emplace_back(kCells, blank_);
    }
    return tiles_[place->second].data();
  }
  /// Null when missing.
  const Cell* find_tile(int tx, int ty) const {
    const auto place = index_.find(key(tx, ty));
    return place == index_.end() ? nullptr : tiles_[place->second].data();
  }

  Cell& operator()(int ix, int iy) { return tile(ix >> kBits, iy >> kBits)[in_tile(ix, iy)]; }
  /// Blank where nothing was written.
  const Cell& operator()(int ix, int iy) const {
    const Cell* cells = find_tile(ix >> kBits, iy >> kBits);
    return cells ? cells[in_tile(ix, iy)] : blank_;
  }

  /// Cells (x0 ... x0 + width - 1, iy), for walks over whole pictures.
  void copy_row(int x0, int iy, int width, Cell* out) const {
    for (int ix = x0; ix < x0 + width;) {
      const int next = std::min(((ix >> kBits) + 1) << kBits, x0 + width);
      const Cell* cells = find_tile(ix >> kBits, iy >> kBits);
      if (cells)
        std::copy_n(cells + in_tile(ix, iy), next - ix, out);
      else
        std::fill_n(out, next - ix, blank_);
      out += next - ix;
      ix = next;
    }
  }

  /// body(ix, iy, cell) for every cell of every tile, in the order in which tiles were made.
  template <class Body>
  void for_each(const Body& body) const {
    for (std::size_t i = 0; i < tiles_.size(); ++i)
      for (std::size_t c = 0; c < kCells; ++c)
        body(places_[i].tx * kSize + static_cast<int>(c % kSize),
             places_[i].ty * kSize + static_cast<int>(c / kSize), tiles_[i][c]);
  }

  /// Tight around all cells that `is_set`; empty where none is.
  template <class Predicate>
  CellBox bounds(const Predicate& is_set) const {
    int x_low = std::numeric_limits<int>::max(), x_high = std::numeric_limits<int>::min();
    int y_low = x_low, y_high = x_high;
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      for (int y = 0; y < kSize; ++y) {
        const auto row = tiles_[i].begin() + y * kSize;
        const auto first = std::find_if(row, row + kSize, is_set);
        if (first == row + kSize) continue;
        auto last = row + kSize - 1;
        while (!is_set(*last)) --last;
        x_low = std::min(x_low, places_[i].tx * kSize + static_cast<int>(first - row));
        x_high = std::max(x_high, places_[i].tx * kSize + static_cast<int>(last - row));
        y_low = std::min(y_low, places_[i].ty * kSize + y);
        y_high = std::max(y_high, places_[i].ty * kSize + y);
      }
    }
    if (x_low > x_high) return {};
    return {x_low, y_low, x_high - x_low + 1, y_high - y_low + 1};
  }

  /// Without what cells own elsewhere.
  std::size_t bytes() const {
    constexpr std::size_t kPerTile =
        kCells * sizeof(Cell) + sizeof(Place) + sizeof(std::vector<Cell>) + 4 * sizeof(std::size_t);
    return sizeof(*this) + tiles_.size() * kPerTile;
  }

 private:
  static constexpr std::size_t kCells = std::size_t{kSize} * kSize;
  struct Place {
    int tx, ty;
  };
  static std::uint64_t key(int tx, int ty) {
    return (std::uint64_t{static_cast<std::uint32_t>(tx)} << 32) | static_cast<std::uint32_t>(ty);
  }
  static std::size_t in_tile(int ix, int iy) {
    constexpr int kMask = kSize - 1;
    return static_cast<std::size_t>((iy & kMask) * kSize + (ix & kMask));
  }

  Cell blank_;
  std::unordered_map<std::uint64_t, std::size_t> index_;  // tile -> its number
  std::vector<Place> places_;                             // by number
  std::vector<std::vector<Cell>> tiles_;                  // by number
};

}  // namespace majak::map
