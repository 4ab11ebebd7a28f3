// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_raster.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

Segment wall(const Vec2& a, const Vec2& b) {
  Segment s;
  s.a = a, s.b = b;
  return s;
}

/// A room of 4 x 3 m seen from inside.
std::vector<Segment> room() {
  return {wall({0, 0}, {4, 0}), wall({4, 0}, {4, 3}), wall({4, 3}, {0, 3}), wall({0, 3}, {0, 0})};
}

TEST(SegmentRaster, ARoomIsFreeInsideAndUnknownOutside) {
  const KnownMap map = known_map(room());
  for (const Segment& s : room())
    for (double u = 0; u <= 1; u += 0.01)
      EXPECT_EQ(map.at(Vec2(s.a + u * (s.b - s.a))), CellState::occupied);
  for (double x = 0.15; x < 3.86; x += 0.05)
    for (double y = 0.15; y < 2.86; y += 0.05)
      EXPECT_EQ(map.at(Vec2(x, y)), CellState::free) << x << " " << y;
  EXPECT_EQ(map.at(Vec2(-0.08, 1)), CellState::unknown);
  EXPECT_EQ(map.at(0, 0), CellState::unknown);
}

TEST(SegmentRaster, BehindAWallNothingIsKnown) {
  auto walls = room();
  walls.push_back(wall({2.02, 2}, {2.02, 1}));  // seen from x > 2 only: its left
  const KnownMap map = known_map(walls);
  EXPECT_EQ(map.at(Vec2(2.2, 1.5)), CellState::free);
  EXPECT_EQ(map.at(Vec2(2.02, 1.5)), CellState::occupied);
}

TEST(SegmentRaster, BeforeASingleWallALittleIsFree) {
  const std::vector<Segment> one = {wall({0, 0}, {2, 0})};
  EXPECT_EQ(known_map(one).at(Vec2(1, 0.04)), CellState::occupied);
  EXPECT_TRUE(known_map(one).area(CellState::occupied) > 0);
}

TEST(SegmentRaster, NothingAndTooMuch) {
  EXPECT_TRUE(known_map(std::vector<Segment>{}).cells.empty());
  EXPECT_THROW(known_map(std::vector{wall({0, 0}, {1e6, 1e6})}), Error);
}

}  // namespace
}  // namespace majak::map
