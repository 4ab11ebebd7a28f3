// SPDX-License-Identifier: Apache-2.0
#include "majak/map/route.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

#include "majak/core/random.hpp"
#include "tests/support/carved_map.hpp"

namespace majak::map {
namespace {

using fixture::Area;
using fixture::carved_map;

const std::vector<Area> kWing{
    {0, 0, 12, 1.6}, {0, 1.8, 5, 6}, {5.2, 1.8, 12, 6}, {2, 1.6, 2.9, 1.8}, {8, 1.6, 8.8, 1.8}};

double length_of(const std::vector<Vec2>& way) {
  double sum = 0;
  for (std::size_t i = 1; i < way.size(); ++i) sum += (way[i] - way[i - 1]).norm();
  return sum;
}

TEST(Route, GoesThroughBothDoors) {
  const KnownMap known = carved_map(kWing);
  const Topology t = build_topology(known);
  const Vec2 from(1, 5), to(11, 5);
  const Route route = find_route(known, t, from, to);
  ASSERT_TRUE(route.found);
  EXPECT_THAT(route.rooms,
              testing::ElementsAre(t.room_at(from), t.room_at({6, 0.8}), t.room_at(to)));
  ASSERT_EQ(route.doors.size(), 2U);
  EXPECT_LT(t.doors[route.doors[0]].centre.x(), 5);
  EXPECT_GT(t.doors[route.doors[1]].centre.x(), 5);
  EXPECT_NEAR((route.way.front() - from).norm(), 0, 0.06);
  EXPECT_NEAR((route.way.back() - to).norm(), 0, 0.06);
  EXPECT_NEAR(route.length, length_of(route.way), 1e-9);
  EXPECT_GE(route.narrowest, 0.25);
}

TEST(Route, ThereAndBackAreEquallyLong) {
  const KnownMap known = carved_map(kWing);
  const Topology t = build_topology(known);
  RouteOptions plain;
  plain.wall_cost = 0;
  EXPECT_NEAR(find_route(known, t, {1, 5}, {11, 5}, plain).length,
              find_route(known, t, {11, 5}, {1, 5}, plain).length, 1e-9);
}

TEST(Route, ALargerRobotFindsNoWay) {
  const KnownMap known = carved_map(kWing);
  const Topology t = build_topology(known);
  RouteOptions o;
  o.radius = 0.5;
  EXPECT_FALSE(find_route(known, t, {1, 5}, {11, 5}, o).found);
  EXPECT_TRUE(find_route(known, t, {1, 5}, {4, 3}, o).found);
  EXPECT_FALSE(find_route(known, t, {1, 5}, {40, 3}, o).found);
  EXPECT_FALSE(find_route(known, t, {1, 5}, {std::nan(""), 3}, o).found);
}

// Slow twin: Bellman and Ford, every cell again until nothing changes.
TEST(Route, AsShortAsTheSlowTwin) {
  RandomStream random(5);
  for (int round = 0; round < 6; ++round) {
    KnownMap known;
    known.resolution = 1;
    known.width = known.height = 12;
    for (int i = 0; i < 144; ++i)
      known.cells.push_back(random.uniform() < 0.25 ? CellState::occupied : CellState::free);
    known.cells.front() = known.cells.back() = CellState::free;
    RouteOptions o;
    o.radius = o.wall_cost = 0;
    const Route route = find_route(known, build_topology(known), {0.5, 0.5}, {11.5, 11.5}, o);
    std::vector<double> cost(144, std::numeric_limits<double>::infinity());
    cost[0] = 0;
    for (int again = 0; again < 144; ++again)
      for (int c = 0; c < 144; ++c)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const int x = c % 12 + dx, y = c / 12 + dy;
            if (known.at(c % 12, c / 12) == CellState::free && known.at(x, y) == CellState::free)
              cost[c] = std::min(cost[c], cost[y * 12 + x] + std::hypot(dx, dy));
          }
    EXPECT_EQ(route.found, std::isfinite(cost[143]));
    if (route.found) {
      EXPECT_NEAR(route.length, cost[143], 1e-9);
    }
  }
}

TEST(Route, KeepsToTheMiddleWhereWallsCost) {
  const KnownMap known = carved_map({{0, 0, 12, 1.6}});
  const Topology t = build_topology(known);
  RouteOptions o;
  const Route clear = find_route(known, t, {0.4, 0.8}, {11.6, 0.8}, o);
  for (const Vec2& p : clear.way) EXPECT_NEAR(p.y(), 0.8, 0.11);
}

Topology random_graph(RandomStream& random, int rooms, int doors) {
  Topology t;
  t.rooms.resize(rooms);
  for (Room& room : t.rooms) room.widest_spot = {random.uniform(0, 20), random.uniform(0, 20)};
  for (int d = 0; d < doors; ++d) {
    const int a = static_cast<int>(random.below(rooms)), b = static_cast<int>(random.below(rooms));
    if (a == b) continue;
    Doorway door;
    door.centre = {random.uniform(0, 20), random.uniform(0, 20)};
    door.from = std::min(a, b);
    door.to = std::max(a, b);
    t.doors.push_back(door);
  }
  return t;
}

// Slow twin: all ways that go through no door twice.
double shortest_by_trying(const Topology& t, int room, const Vec2& at, int to,
                          std::vector<bool>& used) {
  double best =
      room == to ? (t.rooms[to].widest_spot - at).norm() : std::numeric_limits<double>::infinity();
  for (std::size_t d = 0; d < t.doors.size(); ++d) {
    const Doorway& door = t.doors[d];
    if (used[d] || (door.from != room && door.to != room)) continue;
    used[d] = true;
    best = std::min(best, (door.centre - at).norm() +
                              shortest_by_trying(t, door.from == room ? door.to : door.from,
                                                 door.centre, to, used));
    used[d] = false;
  }
  return best;
}

TEST(GraphRoute, AsShortAsTheSlowTwin) {
  RandomStream random(8);
  int found = 0;
  for (int round = 0; round < 40; ++round) {
    const Topology t = random_graph(random, 5, 7);
    const GraphRoute route = graph_route(t, 0, 4);
    std::vector<bool> used(t.doors.size(), false);
    const double slow = shortest_by_trying(t, 0, t.rooms[0].widest_spot, 4, used);
    ASSERT_EQ(!route.rooms.empty(), std::isfinite(slow));
    if (route.rooms.empty()) continue;
    ++found;
    EXPECT_NEAR(route.length, slow, 1e-9);
    ASSERT_EQ(route.rooms.size(), route.doors.size() + 1);
    EXPECT_EQ(route.rooms.front(), 0);
    EXPECT_EQ(route.rooms.back(), 4);
    for (std::size_t i = 0; i < route.doors.size(); ++i) {
      const Doorway& d = t.doors[route.doors[i]];
      EXPECT_TRUE(d.from == route.rooms[i] || d.to == route.rooms[i]);
      EXPECT_TRUE(d.from == route.rooms[i + 1] || d.to == route.rooms[i + 1]);
    }
  }
  EXPECT_GT(found, 20);
}

TEST(GraphRoute, AgreesWithTheWayOverCells) {
  const KnownMap known = carved_map(kWing);
  const Topology t = build_topology(known);
  const int a = t.room_at({1, 5}), b = t.room_at({11, 5});
  const GraphRoute graph = graph_route(t, a, b);
  const Route cells = find_route(known, t, t.rooms[a].widest_spot, t.rooms[b].widest_spot);
  EXPECT_EQ(graph.rooms, cells.rooms);
  EXPECT_EQ(graph.doors, cells.doors);
  EXPECT_LT(graph.length, cells.length + 0.2);
}

}  // namespace
}  // namespace majak::map
