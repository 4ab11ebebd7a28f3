// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/floor_plans.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "majak/core/error.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/known_map.hpp"
#include "majak/sim/tour.hpp"

namespace majak::sim {
namespace {

constexpr std::uint64_t kSeeds = 12;

TEST(FloorPlans, TheTourGoesIntoEveryRoom) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const GeneratedBuilding office = generated_building(seed);
    const Path path = plan_tour(World(office.scene));
    std::set<int> visited;
    for (const Vec2& p : path.points) visited.insert(office.place_at(p));
    visited.erase(-1);
    EXPECT_EQ(visited.size(), office.places.size()) << "seed " << seed;
  }
}

TEST(FloorPlans, EqualSeedsGiveEqualBuildingsAndOthersDoNot) {
  const Scene a = generated_building(3).scene, b = built_in("office-3"),
              other = generated_building(4).scene;
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t i = 0; i < a.segments.size(); ++i) EXPECT_EQ(a.segments[i].a, b.segments[i].a);
  EXPECT_NE(a.segments.size(), other.segments.size());
  EXPECT_THROW(built_in("office-"), Error);
  EXPECT_THROW(built_in("office-3x"), Error);
}

// From the middle of a door one step to either side is into the two places that it joins, and there
// is nothing between its jambs; just beyond them is wall.
TEST(FloorPlans, DoorsJoinTheirPlaces) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const GeneratedBuilding office = generated_building(seed);
    const World world(office.scene);
    for (const TrueDoor& door : office.doors) {
      const Vec2 across = Vec2(door.along.y(), door.along.x()) * (office.wall / 2 + 0.02);
      EXPECT_EQ(office.place_at(door.centre - across), door.from);
      EXPECT_EQ(office.place_at(door.centre + across), door.to);
      EXPECT_EQ(office.place_at(door.centre), -1);
      const double angle = std::atan2(door.along.y(), door.along.x());
      for (const double way : {angle, angle + kPi})
        EXPECT_NEAR(world.cast(door.centre, way, 9).range, door.width / 2, 1e-9)
            << "seed " << seed << " at " << door.centre.transpose();
    }
  }
}

// Without its doors every place would be closed: what is free belongs to places and doors.
TEST(FloorPlans, FreeFloorIsOfPlacesAndDoors) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const GeneratedBuilding office = generated_building(seed);
    const World world(office.scene);
    const map::KnownMap map = known_map(world, 0.1);
    for (int iy = 0; iy < map.height; ++iy)
      for (int ix = 0; ix < map.width; ++ix) {
        const Vec2 p = map.centre(ix, iy);
        if (map.at(ix, iy) != map::CellState::free || office.place_at(p) >= 0) continue;
        const bool near_door =
            std::any_of(office.doors.begin(), office.doors.end(), [&](const TrueDoor& d) {
              const Vec2 offset = p - d.centre;
              return std::abs(offset.dot(d.along)) < d.width / 2 &&
                     offset.squaredNorm() - std::pow(offset.dot(d.along), 2) <
                         std::pow(office.wall / 2 + 0.1, 2);
            });
        const bool near_wall = world.clearance(p) < office.wall;
        EXPECT_TRUE(near_door || near_wall) << seed << " " << p.transpose();
      }
  }
}

}  // namespace
}  // namespace majak::sim
