// SPDX-License-Identifier: Apache-2.0
// How far the nearest marked cell is, for every cell of a grid: exact, in integers, in linear time
// (Felzenszwalb and Huttenlocher 2012; the envelope without divisions after Maurer et al. 2003).
//
//   CellMask marked{.width = 3, .height = 1, .cells = {0, 0, 1}};
//   squared_distances(marked);  // 4 1 0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "majak/core/parallel.hpp"

namespace majak::map {

/// Yes or no for every cell of a grid.
struct CellMask {
  int width = 0, height = 0;        ///< cells
  std::vector<std::uint8_t> cells;  ///< 0 or 1, row by row, from low y

  bool inside(int ix, int iy) const { return ix >= 0 && iy >= 0 && ix < width && iy < height; }
  std::size_t index(int ix, int iy) const {
    return static_cast<std::size_t>(iy) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(ix);
  }
  /// False outside.
  bool at(int ix, int iy) const { return inside(ix, iy) && cells[index(ix, iy)] != 0; }
  bool operator==(const CellMask&) const = default;
};

/// Throws Error when a side is longer than 32767 cells or the cells are not width x height.
void require_valid(const CellMask& mask);

/// What squared_distances() says of every cell where none is marked.
inline constexpr std::int32_t kNoneMarked = std::numeric_limits<std::int32_t>::max();

/// Square of the distance, in cells, from each cell's middle to that of the nearest marked cell.
/// Throws Error when the mask is not valid.
std::vector<std::int32_t> squared_distances(const CellMask& marked, Threads threads = {});

/// The same along columns alone, not squared: cells up or down to the nearest marked one, at most
/// `cap`; as many as there are cells.
std::unique_ptr<std::uint16_t[]> column_distances(const CellMask& marked, int cap,
                                                  Threads threads = {});

}  // namespace majak::map
