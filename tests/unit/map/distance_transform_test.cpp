// SPDX-License-Identifier: Apache-2.0
#include "majak/map/distance_transform.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::map {
namespace {

CellMask empty_mask(int width, int height) {
  return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height))};
}

CellMask random_mask(std::uint64_t seed, double share, int longest = 40) {
  RandomStream random(seed);
  CellMask mask = empty_mask(1 + static_cast<int>(random.below(longest)),
                             1 + static_cast<int>(random.below(longest)));
  for (auto& cell : mask.cells) cell = random.uniform() < share;
  return mask;
}

/// The slow twin: every marked cell is asked.
std::int32_t nearest(const CellMask& mask, int ix, int iy) {
  std::int32_t best = kNoneMarked;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (mask.at(x, y)) best = std::min(best, (x - ix) * (x - ix) + (y - iy) * (y - iy));
  return best;
}

TEST(SquaredDistances, EqualTheSlowTwin) {
  for (const double share : {0.0, 0.002, 0.02, 0.3, 0.9, 1.0})
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const CellMask mask = random_mask(seed, share);
      const auto squares = squared_distances(mask);
      ASSERT_EQ(squares.size(), mask.cells.size());
      for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
          ASSERT_EQ(squares[mask.index(x, y)], nearest(mask, x, y)) << x << ' ' << y;
    }
}

TEST(SquaredDistances, AreZeroOnMarkedCellsAlone) {
  const CellMask mask = random_mask(3, 0.1);
  const auto squares = squared_distances(mask);
  for (std::size_t i = 0; i < squares.size(); ++i) EXPECT_EQ(squares[i] == 0, mask.cells[i] == 1);
}

// From a cell to the next one the distance changes by one cell at most.
TEST(SquaredDistances, ChangeNoFasterThanOneGoes) {
  CellMask mask = empty_mask(300, 200);
  RandomStream random(7);
  for (int k = 0; k < 12; ++k) mask.cells[random.below(mask.cells.size())] = 1;
  const auto squares = squared_distances(mask);
  const auto d = [&](int x, int y) { return std::sqrt(squares[mask.index(x, y)]); };
  for (int y = 0; y + 1 < mask.height; ++y)
    for (int x = 0; x + 1 < mask.width; ++x) {
      ASSERT_LE(std::abs(d(x, y) - d(x + 1, y)), 1 + 1e-12);
      ASSERT_LE(std::abs(d(x, y) - d(x, y + 1)), 1 + 1e-12);
    }
}

// Rows as columns, and the other way round: the two passes differ, what they say does not.
TEST(SquaredDistances, DoNotTellRowsFromColumns) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const CellMask mask = random_mask(seed, 0.03, 90);
    CellMask turned = empty_mask(mask.height, mask.width), mirrored = mask;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        turned.cells[turned.index(y, x)] = mask.at(x, y);
        mirrored.cells[mask.index(mask.width - 1 - x, y)] = mask.at(x, y);
      }
    const auto squares = squared_distances(mask), across = squared_distances(turned),
               back = squared_distances(mirrored);
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        ASSERT_EQ(squares[mask.index(x, y)], across[turned.index(y, x)]);
        ASSERT_EQ(squares[mask.index(x, y)], back[mask.index(mask.width - 1 - x, y)]);
      }
  }
}

TEST(SquaredDistances, OneCellIsACone) {
  CellMask mask = empty_mask(31, 17);
  mask.cells[mask.index(20, 5)] = 1;
  const auto squares = squared_distances(mask);
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 31; ++x)
      EXPECT_EQ(squares[mask.index(x, y)], (x - 20) * (x - 20) + (y - 5) * (y - 5));
}

TEST(SquaredDistances, OneRowOneColumnNothing) {
  const std::vector<std::int32_t> expected{4, 1, 0, 1, 1, 0};
  EXPECT_EQ(squared_distances({6, 1, {0, 0, 1, 0, 0, 1}}), expected);
  EXPECT_EQ(squared_distances({1, 6, {0, 0, 1, 0, 0, 1}}), expected);
  EXPECT_EQ(squared_distances({2, 1, {0, 0}}), (std::vector<std::int32_t>(2, kNoneMarked)));
  EXPECT_TRUE(squared_distances({}).empty());
}

TEST(SquaredDistances, ReachAcrossTheLongestGrid) {
  CellMask mask = empty_mask(32767, 2);
  mask.cells[0] = 1;
  EXPECT_EQ(squared_distances(mask).back(), 32766 * 32766 + 1);
  std::swap(mask.width, mask.height);
  EXPECT_EQ(squared_distances(mask).back(), 32766 * 32766 + 1);
}

TEST(SquaredDistances, AreTheSameForAnyNumberOfThreads) {
  CellMask mask = empty_mask(700, 450);
  RandomStream random(1);
  for (int k = 0; k < 500; ++k) mask.cells[random.below(mask.cells.size())] = 1;
  EXPECT_EQ(squared_distances(mask), squared_distances(mask, {3}));
}

TEST(SquaredDistances, RefuseWhatIsNoGrid) {
  EXPECT_THROW(squared_distances({2, 2, {0, 1, 0}}), Error);
  EXPECT_THROW(squared_distances({-1, 0, {}}), Error);
  EXPECT_THROW(squared_distances(empty_mask(32768, 1)), Error);
}

TEST(ColumnDistances, GoUpAndDownAsFarAsAsked) {
  const CellMask mask{2, 6, {0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
  EXPECT_THAT(std::span(column_distances(mask, 3).get(), 12),
              testing::ElementsAre(1, 3, 0, 3, 1, 3, 2, 3, 3, 3, 3, 3));
  EXPECT_THAT(std::span(column_distances(mask, 0).get(), 12), testing::Each(0));
}

}  // namespace
}  // namespace majak::map
