// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/known_map.hpp"

#include <gtest/gtest.h>

#include "majak/sim/buildings.hpp"
#include "majak/sim/tour.hpp"

namespace majak::sim {
namespace {

TEST(SimKnownMap, WallsAreOccupiedAndWaysFree) {
  for (const std::string& name : built_in_names()) {
    const World world(built_in(name));
    const bool fenced = name != "yard" && name != "park";
    const map::KnownMap map = known_map(world, name == "park" ? 0.2 : 0.05);
    for (const Segment& s : world.scene().segments)
      EXPECT_EQ(map.at((s.a + s.b) / 2), map::CellState::occupied) << name;
    for (const Vec2& p : plan_tour(world).points)
      EXPECT_EQ(map.at(p), map::CellState::free) << name;
    if (fenced) {
      EXPECT_EQ(map.at(world.low() - Vec2(0.1, 0.1)), map::CellState::unknown) << name;
    }
  }
}

// Every occupied cell has a surface within it, every free one has none.
TEST(SimKnownMap, CellsAgreeWithTheWorld) {
  const World world(built_in("building"));
  const map::KnownMap map = known_map(world, 0.1);
  for (int iy = 0; iy < map.height; iy += 3)
    for (int ix = 0; ix < map.width; ix += 3) {
      const double clearance = world.clearance(map.centre(ix, iy));
      if (map.at(ix, iy) == map::CellState::occupied) {
        EXPECT_LT(clearance, 0.0708);
      }
      if (map.at(ix, iy) == map::CellState::free) {
        EXPECT_GT(clearance, 0.038);
      }
    }
}

}  // namespace
}  // namespace majak::sim
