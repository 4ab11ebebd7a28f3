// SPDX-License-Identifier: Apache-2.0
#include "majak/map/distance_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "majak/core/random.hpp"
#include "tests/support/ascii_map.hpp"

namespace majak::map {
namespace {

/// A floor lies next to it.
bool seen(const KnownMap& map, int ix, int iy) {
  int floor = 0;
  for (int k = 0; k < 9; ++k) floor += map.at(ix + k % 3 - 1, iy + k / 3 - 1) == CellState::free;
  return floor > 0;
}

/// The slow twin: every occupied cell is asked.
double nearest(const KnownMap& map, int ix, int iy, double reach) {
  double best = reach;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      if (map.at(x, y) == CellState::occupied && seen(map, x, y))
        best = std::min(best, std::hypot(x - ix, y - iy) * map.resolution);
  return best;
}

KnownMap random_map(std::uint64_t seed, double share) {
  RandomStream random(seed);
  KnownMap map;
  map.resolution = 0.1;
  map.x0 = -1.7;
  map.y0 = 0.3;
  map.width = 23 + static_cast<int>(random.below(20));
  map.height = 17 + static_cast<int>(random.below(20));
  for (int i = 0; i < map.width * map.height; ++i)
    map.cells.push_back(random.uniform() < share ? CellState::occupied : CellState::free);
  return map;
}

TEST(DistanceField, EqualsTheSlowTwin) {
  for (const double share : {0.0, 0.002, 0.02, 0.3, 1.0})
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const KnownMap map = random_map(seed, share);
      const DistanceField field(map, 1.3);
      for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
          ASSERT_NEAR(field.at(x, y), nearest(map, x, y, 1.3), 1e-6) << x << ' ' << y;
    }
}

TEST(DistanceField, AWallIsSeenFromTheFloor) {
  const DistanceField field(fixture::ascii_map({".######", ".######", ".######", ".######"}));
  EXPECT_EQ(field.at(0, 2), 1);
  EXPECT_EQ(field.at(1, 2), 0);
  EXPECT_EQ(field.at(2, 2), 1);  // no beam comes here
  EXPECT_EQ(field.at(6, 2), 5);
}

TEST(DistanceField, OutsideTheMapIsFar) {
  const DistanceField field(fixture::ascii_map({"#."}), 4);
  EXPECT_EQ(field.at(0, 0), 0);
  EXPECT_EQ(field.at(2, 0), 4);
  EXPECT_EQ(field.at(Vec2(0.5, -0.5)), 4);
}

TEST(DistanceField, ARayMeetsTheFirstWall) {
  const DistanceField field(fixture::ascii_map({"########",  //
                                                "#......#",  //
                                                "#..#...#",  //
                                                "#......#",  //
                                                "########"}));
  EXPECT_NEAR(field.cast({1.5, 2.5}, {1, 0}, 100), 1.5, 0.2);
  EXPECT_NEAR(field.cast({1.5, 1.5}, {1, 0}, 100), 5.5, 0.2);
  EXPECT_NEAR(field.cast({1.5, 1.5}, {0, -1}, 100), 0.5, 0.2);
  EXPECT_EQ(field.cast({3.5, 2.5}, {1, 0}, 100), 0);
  EXPECT_TRUE(std::isinf(field.cast({1.5, 1.5}, {1, 0}, 3)));
}

// The slow twin of a ray: steps of a hundredth of a cell.
TEST(DistanceField, RaysEqualTheSlowTwin) {
  const KnownMap map = random_map(7, 0.03);
  const DistanceField field(map);
  RandomStream random(3);
  int corners = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p(map.x0 + random.uniform(0, map.width * map.resolution),
                 map.y0 + random.uniform(0, map.height * map.resolution));
    const double angle = random.uniform(-kPi, kPi);
    const Vec2 direction(std::cos(angle), std::sin(angle));
    double slow = 0;
    while (slow < 3 && map.at(p + slow * direction) != CellState::occupied)
      slow += 0.01 * map.resolution;
    const double fast = field.cast(p, direction, 3);
    // A corner may be cut by less than a step.
    if (slow >= 3)
      EXPECT_GT(fast, 2.9);
    else if (fast < slow + 0.3 * map.resolution)
      EXPECT_NEAR(fast, slow, 0.3 * map.resolution);
    else
      ++corners;
  }
  EXPECT_LT(corners, 60);
}

}  // namespace
}  // namespace majak::map
