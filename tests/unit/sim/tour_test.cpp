// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/tour.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "majak/core/error.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/plan.hpp"

namespace majak::sim {
namespace {

double distance_to(const std::vector<Vec2>& points, const Vec2& p) {
  double best = 1e9;
  for (const Vec2& q : points) best = std::min(best, (p - q).norm());
  return best;
}

TEST(Tour, KeepsClearOfWallsAndVisitsEveryPlaceInOrder) {
  for (const std::string& name : built_in_names()) {
    for (const bool short_tour : {false, true}) {
      const World world(built_in(name));
      TourOptions options;
      options.short_tour = short_tour;
      const Path path = plan_tour(world, options);
      for (const Vec2& p : path.points) {
        // The clearance is kept at the centres of cells of 0.2 m.
        EXPECT_GT(world.clearance(p), options.clearance - 0.15) << name << " " << p.transpose();
      }
      auto from = path.points.begin();
      for (const Vec2& place : short_tour ? world.scene().short_tour : world.scene().tour) {
        from = std::find_if(from, path.points.end(),
                            [&](const Vec2& p) { return (p - place).norm() < 0.4; });
        EXPECT_NE(from, path.points.end()) << name << " " << place.transpose();
      }
    }
  }
}

TEST(Tour, PointsAreEvenlySpaced) {
  const Path path = plan_tour(World(ring()));
  double longest = 0;
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    longest = std::max(longest, (path.points[i] - path.points[i - 1]).norm());
  }
  EXPECT_LE(longest, kPathStep + 1e-9);
  EXPECT_NEAR(length(path.points), kPathStep * static_cast<double>(path.points.size() - 1),
              0.02 * length(path.points));  // corners are cut by a little
}

TEST(Tour, ShortToursAreShort) {
  for (const std::string& name : {std::string("building"), std::string("ring")}) {
    TourOptions options;
    options.short_tour = true;
    const double way = length(plan_tour(World(built_in(name)), options).points);
    EXPECT_TRUE(way > 80 && way < 120) << name << " " << way;
  }
}

TEST(Tour, OfTheLargeRingIsALapAndAQuarter) {
  const World world(large_ring());
  const Path path = plan_tour(world, {.short_tour = true});
  const double lap = 2 * (57.8 + 37.8), more = 28.9 + 14.9;  // along the middle of the corridor
  EXPECT_NEAR(length(path.points), lap + more, 2);
}

TEST(Tour, OfTheNestedRingsGoesRoundTheSmallOneOnItsWay) {
  const double small = 2 * (18 + 12), large = 2 * (57.8 + 37.8), more = 6 + 14.9;
  EXPECT_NEAR(length(plan_tour(World(nested_rings())).points), 3 * small + large + more, 6);
}

TEST(Tour, LapsRepeatIt) {
  const World world(ring());
  TourOptions options;
  options.short_tour = true;
  const double once = length(plan_tour(world, options).points);
  options.laps = 3;
  EXPECT_NEAR(length(plan_tour(world, options).points), 3 * once, 45);
}

constexpr const char* kTwoRooms =
    "##############################\n"
    "#............................#\n"
    "#............................#\n"
    "#..............#.............#\n"
    "#>.............#.............#\n"
    "#..............#.............#\n"
    "##############################\n";

TEST(Tour, MadeUpToursReachTheWholeFloorAndComeHome) {
  const World world(parse_plan(kTwoRooms, "plan", 0.5));
  TourOptions options;
  options.spacing = 2;
  const Path path = plan_tour(world, options);
  for (double x = 1; x < 14; x += 0.5) {
    for (double y = 1; y < 3; y += 0.5) {
      if (world.clearance({x, y}) > 0.4) {
        EXPECT_LT(distance_to(path.points, {x, y}), 2.2) << x << " " << y;
      }
    }
  }
  EXPECT_LT((path.points.back() - world.scene().start.translation()).norm(), 0.3);
}

TEST(Tour, ImpossibleToursSayWhere) {
  const World closed(parse_plan("#########\n#>.#..1.#\n#..#....#\n#########\n", "plan", 1));
  EXPECT_THAT([&] { plan_tour(closed); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("no way to (6.5")));
  const World narrow(parse_plan("###\n#>#\n###\n", "plan", 0.3));
  EXPECT_THAT([&] { plan_tour(narrow); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("no room")));
}

TEST(Tour, NeverStartsOnTheOtherSideOfAWall) {
  // Outside there is room, within half a metre of the start.
  const World tiny(parse_plan("######\n#>...#\n######\n", "plan", 0.3));
  EXPECT_THAT([&] { plan_tour(tiny); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("no room")));
}

TEST(Tour, SmallRoomsAreTouredToo) {
  const World room(parse_plan("########\n#>.....#\n#......#\n#......#\n########\n", "plan", 0.5));
  EXPECT_GT(length(plan_tour(room).points), 3);
}

}  // namespace
}  // namespace majak::sim
