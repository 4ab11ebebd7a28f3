// SPDX-License-Identifier: Apache-2.0
#include "majak/map/rectangles.hpp"

#include <algorithm>

namespace majak::map {
namespace {

auto row(CellMask& mask, const CellBox& box, int iy) {
  return mask.cells.begin() + static_cast<std::ptrdiff_t>(mask.index(box.x0, iy));
}

CellBox grown_from(CellMask& mask, int ix, int iy) {
  CellBox box{ix, iy, 1, 1};
  while (mask.at(ix + box.width, iy)) ++box.width;
  const auto all_set = [&](int y) {
    return y < mask.height &&
           std::all_of(row(mask, box, y), row(mask, box, y) + box.width, [](auto c) { return c; });
  };
  while (all_set(iy + box.height)) ++box.height;
  return box;
}

}  // namespace

std::vector<CellBox> rectangles_of(CellMask mask) {
  require_valid(mask);
  std::vector<CellBox> boxes;
  for (int iy = 0; iy < mask.height; ++iy)
    for (int ix = 0; ix < mask.width; ++ix) {
      if (!mask.at(ix, iy)) continue;
      boxes.push_back(grown_from(mask, ix, iy));
      for (int y = iy; y < iy + boxes.back().height; ++y)
        std::fill_n(row(mask, boxes.back(), y), boxes.back().width, std::uint8_t{0});
    }
  return boxes;
}

}  // namespace majak::map
