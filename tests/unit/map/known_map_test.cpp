// SPDX-License-Identifier: Apache-2.0
#include "majak/map/known_map.hpp"

#include <gtest/gtest.h>

#include "tests/support/ascii_map.hpp"

namespace majak::map {
namespace {

TEST(KnownMap, FromAGridHasItsCellsAndAMargin) {
  OccupancyGrid grid(0.5);
  grid.set_log_odds(-3, 2, 2.0F);
  grid.set_log_odds(-2, 2, -1.0F);
  grid.set_log_odds(-2, 3, 0.3F);  // neither
  const KnownMap map = known_map(grid);
  EXPECT_EQ(map.width, 4);
  EXPECT_EQ(map.height, 4);
  EXPECT_DOUBLE_EQ(map.x0, -2.0);
  EXPECT_DOUBLE_EQ(map.y0, 0.5);
  EXPECT_EQ(map.at(1, 1), CellState::occupied);
  EXPECT_EQ(map.at(2, 1), CellState::free);
  EXPECT_EQ(map.at(2, 2), CellState::unknown);
  EXPECT_EQ(map.all(CellState::free), std::vector<std::uint32_t>{6});
  EXPECT_DOUBLE_EQ(map.area(CellState::occupied), 0.25);
}

TEST(KnownMap, APlaceAndItsCellAgree) {
  OccupancyGrid grid(0.5);
  grid.set_log_odds(-3, 2, 2.0F);
  const KnownMap map = known_map(grid);
  EXPECT_EQ(map.at(Vec2(-1.26, 1.26)), CellState::occupied);
  EXPECT_EQ(map.at(Vec2(-1.76, 1.26)), CellState::unknown);
  EXPECT_TRUE(map.centre(1, 1).isApprox(Vec2(-1.25, 1.25)));
  for (int iy = 0; iy < map.height; ++iy)
    for (int ix = 0; ix < map.width; ++ix) {
      EXPECT_EQ(map.column(map.centre(ix, iy).x()), ix);
      EXPECT_EQ(map.row(map.centre(ix, iy).y()), iy);
    }
}

TEST(KnownMap, OutsideNothingIsKnown) {
  const KnownMap map = fixture::ascii_map({"##", ".#"});
  EXPECT_EQ(map.at(0, 0), CellState::free);
  EXPECT_EQ(map.at(-1, 0), CellState::unknown);
  EXPECT_EQ(map.at(0, 2), CellState::unknown);
  EXPECT_EQ(map.at(Vec2(1e9, -1e9)), CellState::unknown);
}

TEST(KnownMap, OfAnEmptyGridHasNothing) {
  const KnownMap map = known_map(OccupancyGrid(0.1));
  EXPECT_EQ(map.area(CellState::free), 0);
  EXPECT_TRUE(map.all(CellState::occupied).empty());
}

}  // namespace
}  // namespace majak::map
