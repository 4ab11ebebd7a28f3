// SPDX-License-Identifier: Apache-2.0
#include "majak/map/rectangles.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::map {
namespace {

CellMask filled(int width, int height, const std::vector<CellBox>& boxes) {
  CellMask mask{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height))};
  for (const CellBox& box : boxes)
    for (int y = box.y0; y < box.y0 + box.height; ++y)
      for (int x = box.x0; x < box.x0 + box.width; ++x) ++mask.cells[mask.index(x, y)];
  return mask;
}

TEST(Rectangles, ARectangleIsOne) {
  const std::vector<CellBox> one{{2, 1, 5, 3}};
  EXPECT_EQ(rectangles_of(filled(9, 6, one)), one);
}

TEST(Rectangles, AnAngleIsTwo) {
  const std::vector<CellBox> two{{0, 0, 5, 1}, {0, 1, 1, 4}};
  EXPECT_EQ(rectangles_of(filled(5, 5, two)), two);
}

TEST(Rectangles, NothingIsNone) { EXPECT_TRUE(rectangles_of(filled(4, 4, {})).empty()); }

TEST(Rectangles, CoverEachSetCellOnceAndNoOther) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    RandomStream random(seed);
    CellMask mask = filled(17, 11, {});
    for (auto& cell : mask.cells) cell = random.uniform() < 0.7;
    EXPECT_EQ(filled(17, 11, rectangles_of(mask)), mask) << seed;
  }
}

TEST(Rectangles, AMaskOfAnotherSizeIsRefused) {
  EXPECT_THROW(rectangles_of({3, 2, {1, 1}}), Error);
}

}  // namespace
}  // namespace majak::map
