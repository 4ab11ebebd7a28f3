// SPDX-License-Identifier: Apache-2.0
#include "majak/match/map_surfaces.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/ascii_map.hpp"

namespace majak::match {
namespace {

TEST(MapSurfaces, AStraightWallFacesItsFreeSide) {
  const auto map = fixture::ascii_map({"            ",  //
                                       "############",  //
                                       "............",  //
                                       "............"},
                                      0.05);
  const auto surfels = surfaces(map);
  ASSERT_GE(surfels.surfels().size(), 10U);
  for (const map::Surfel& s : surfels.surfels()) {
    EXPECT_NEAR(s.y, 2.5 * 0.05, 1e-6);
    EXPECT_NEAR(s.ny, -1, 1e-6);
    EXPECT_NEAR(s.nx, 0, 1e-6);
  }
}

// A wall at 26.6 degrees, as cells draw it.
TEST(MapSurfaces, ASlantedWallIsSmoothedOut) {
  std::vector<std::string> lines(24, std::string(40, '.'));
  for (int x = 0; x < 40; ++x)
    lines[static_cast<std::size_t>(21 - x / 2)][static_cast<std::size_t>(x)] = '#';
  for (int x = 0; x < 40; ++x)
    for (int y = 22 - x / 2; y < 24; ++y)
      lines[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = ' ';
  const auto surfels = surfaces(fixture::ascii_map(lines, 0.05));
  const Vec2 normal = Vec2(-1, 2).normalized();
  int inner = 0;
  for (const map::Surfel& s : surfels.surfels()) {
    if (s.x < 0.2 || s.x > 1.8) continue;
    ++inner;
    EXPECT_GT(s.nx * normal.x() + s.ny * normal.y(), std::cos(0.12));
  }
  EXPECT_GT(inner, 25);
}

TEST(MapSurfaces, InsideSolidThingsThereAreNone) {
  const auto surfels =
      surfaces(fixture::ascii_map({".....", ".###.", ".###.", ".###.", "....."}, 0.2));
  EXPECT_EQ(surfels.surfels().size(), 8U);
}

TEST(MapSurfaces, ALoneCellIsAPoint) {
  const auto surfels = surfaces(fixture::ascii_map({"...", ".#.", "..."}, 0.2));
  ASSERT_EQ(surfels.surfels().size(), 1U);
  EXPECT_EQ(surfels.surfels()[0].nx, 0);
  EXPECT_EQ(surfels.surfels()[0].ny, 0);
}

}  // namespace
}  // namespace majak::match
