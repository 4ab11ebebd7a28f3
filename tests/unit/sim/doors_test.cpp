// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/doors.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "majak/sim/buildings.hpp"
#include "majak/sim/furnished_room.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::sim {
namespace {

TEST(SimDoors, ALeafTurnsOnItsHinge) {
  Door door;
  door.closed = {{0, 0}, {1, 0}};
  door.changes = {10 * kSecond, 30 * kSecond};
  EXPECT_FALSE(door.open_at(9 * kSecond));
  EXPECT_TRUE(door.open_at(20 * kSecond));
  EXPECT_FALSE(door.open_at(40 * kSecond));
  EXPECT_EQ(door.opening(5 * kSecond), 0);
  EXPECT_NEAR(door.opening(10 * kSecond + Door::kMoves / 2), 0.5, 1e-9);
  EXPECT_EQ(door.opening(20 * kSecond), 1);
  EXPECT_NEAR(door.opening(30 * kSecond + Door::kMoves / 4), 0.75, 1e-9);
  const auto at = [&](double s) { return leaves({door}, from_seconds(s)).at(0); };
  EXPECT_LT((at(5).b - Vec2(1, 0)).norm(), 1e-12);
  EXPECT_LT((at(20).b - Vec2(0, 1)).norm(), 1e-12);
  for (double s = 8; s < 14; s += 0.1) EXPECT_NEAR((at(s).b - at(s).a).norm(), 1, 1e-12);
  door.slides = true;
  EXPECT_TRUE(leaves({door}, 20 * kSecond).empty());
  EXPECT_NEAR(at(10.5).b.x(), 0.5, 1e-9);
}

TEST(SimDoors, KeepOutOfTheRobotsWay) {
  const World world(building());
  const Path path = plan_tour(world, {.short_tour = true});
  ASSERT_GE(world.scene().doorways.size(), 20U);
  const Duration run = 200 * kSecond;
  std::size_t changes = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto doors = draw_doors(world.scene(), path, 40, run, seed);
    for (const Door& door : doors) {
      changes += door.changes.size();
      EXPECT_TRUE(std::is_sorted(door.changes.begin(), door.changes.end()));
      for (const Duration t : {Duration{0}, run / 2, run})
        for (const Segment& leaf : leaves({door}, t))
          for (const Vec2& p : path.points) ASSERT_GT(distance_to(leaf, p), 0.3);
    }
  }
  // 200 s with a change each 40 s, of 20 doors in 20 runs.
  EXPECT_NEAR(static_cast<double>(changes) / 20 / 20, 5, 0.6);
}

// A beam ends at a leaf that is shut.
TEST(SimDoors, TheLaserSeesThem) {
  Scene scene;
  scene.segments = {{{-1, 5}, {1, 5}}, {{-1, 0}, {-1, 5}}};
  const World world(scene);
  const Segment leaf{{-0.5, 2}, {0.5, 2}};
  const Hit hit = world.cast({0, 0}, kPi / 2, 80, {}, {&leaf, 1});
  EXPECT_NEAR(hit.range, 2, 1e-12);
  EXPECT_NEAR(hit.incidence, 0, 1e-7);
  EXPECT_EQ(hit.object, 2);
  EXPECT_NEAR(world.cast({0, 0}, kPi / 2, 80).range, 5, 1e-12);
}

TEST(SimDoors, NoneMoveUnlessAsked) {
  const World world(building());
  Path path = plan_tour(world, {.short_tour = true});
  path.points.resize(60);
  SimulationOptions options;
  EXPECT_TRUE(Simulator(world, path, options).doors().empty());
  options.door_period = 5;
  EXPECT_GE(Simulator(world, path, options).doors().size(), 15U);
}

TEST(FurnishedRoom, ThingsStandFreeAndElsewhereEachTime) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Furnishing first = furnish(seed, 0), second = furnish(seed, 1);
    EXPECT_EQ(first, furnish(seed, 0));
    for (std::size_t k = 0; k < kMovables; ++k) {
      ASSERT_TRUE(first[k] && second[k]);
      EXPECT_NE(*first[k], *second[k]);
    }
    const Furnishing moved = moved_one(first, 2, seed);
    EXPECT_GE((moved[2]->translation() - first[2]->translation()).norm(), 0.5);
    for (const std::size_t k : {0U, 1U, 3U}) EXPECT_EQ(moved[k], first[k]);
    // The robot gets round without touching anything.
    const World world(furnished_room(moved));
    for (const Vec2& p : plan_tour(world).points) ASSERT_GT(world.clearance(p), 0.3);
  }
  int absent = 0;
  for (std::uint64_t visit = 0; visit < 25; ++visit)
    for (const auto& pose : furnish(5, visit, 0.3)) absent += !pose;
  EXPECT_NEAR(absent, 30, 14);
}

}  // namespace
}  // namespace majak::sim
