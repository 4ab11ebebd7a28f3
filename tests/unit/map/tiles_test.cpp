// SPDX-License-Identifier: Apache-2.0
#include "majak/map/tiles.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <vector>

namespace majak::map {
namespace {

using Written = std::map<std::pair<int, int>, int>;

/// Far apart, negative, on tiles' borders.
Written scattered() {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> place(-200, 200);
  Written cells = {{{-1, -1}, 5}, {{0, 0}, 6}, {{63, 64}, 7}, {{-64, -65}, 8}, {{5000, -9000}, 9}};
  for (int i = 1; i <= 300; ++i) cells[{place(random), place(random)}] = i;
  return cells;
}

Tiles<int> tiles_of(const Written& written) {
  Tiles<int> tiles(-7);
  for (const auto& [at, value] : written) tiles(at.first, at.second) = value;
  return tiles;
}

TEST(Tiles, HoldWhatWasWrittenAndAreBlankElsewhere) {
  const Written written = scattered();
  const Tiles<int> tiles = tiles_of(written);
  for (const auto& [at, value] : written) EXPECT_EQ(tiles(at.first, at.second), value);
  for (int ix = -210; ix < 210; ++ix)
    for (int iy = -210; iy < 210; ++iy)
      if (!written.contains({ix, iy})) ASSERT_EQ(tiles(ix, iy), -7) << ix << ' ' << iy;
}

TEST(Tiles, EveryCellIsMetOnce) {
  const Written written = scattered();
  Written met;
  std::size_t cells = 0;
  tiles_of(written).for_each([&](int ix, int iy, int value) {
    ++cells;
    if (value != -7) met[{ix, iy}] = value;
  });
  EXPECT_EQ(met, written);
  EXPECT_EQ(cells % (Tiles<int>::kSize * Tiles<int>::kSize), 0U);
}

TEST(Tiles, BoundsAreTight) {
  Written written = {{{-3, 70}, 1}, {{130, -5}, 2}, {{10, 10}, 3}};
  const auto is_set = [](int v) { return v >= 0; };
  EXPECT_EQ(tiles_of(written).bounds(is_set), (CellBox{-3, -5, 134, 76}));
  EXPECT_EQ(Tiles<int>(-7).bounds(is_set), CellBox{});
  EXPECT_EQ(tiles_of({{{1, 1}, -1}}).bounds(is_set), CellBox{});
}

TEST(Tiles, RowsAreCopiedAcrossTilesAndHoles) {
  const Tiles<int> tiles = tiles_of({{{-70, 3}, 1}, {{-1, 3}, 2}, {{200, 3}, 4}});
  std::vector<int> row(300);
  tiles.copy_row(-80, 3, 300, row.data());
  for (int i = 0; i < 300; ++i) EXPECT_EQ(row[static_cast<std::size_t>(i)], tiles(i - 80, 3)) << i;
  EXPECT_EQ(row[10], 1);
}

TEST(Tiles, TakeMemoryForWhatWasWritten) {
  Tiles<int> tiles;
  tiles(0, 0) = 1;
  const std::size_t one = tiles.bytes();
  tiles(63, 63) = 1;
  EXPECT_EQ(tiles.bytes(), one);
  tiles(1 << 29, 0) = 1;
  EXPECT_LT(tiles.bytes(), 2 * one);
}

}  // namespace
}  // namespace majak::map
