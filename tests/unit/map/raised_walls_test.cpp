// SPDX-License-Identifier: Apache-2.0
#include "majak/map/raised_walls.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::map {
namespace {

using Eigen::Vector3f;

Segment wall(const Vec2& a, const Vec2& b) {
  Segment s;
  s.a = a, s.b = b;
  return s;
}

Vector3f face_normal(const SolidPart& part, std::size_t quad) {
  const auto& q = part.quads[quad];
  return (part.vertices[q[1]] - part.vertices[q[0]])
      .cross(part.vertices[q[3]] - part.vertices[q[0]])
      .normalized();
}

TEST(AddRectangle, IsSeenFromItsNormalsSide) {
  SolidPart part;
  add_rectangle(part, {1, 2, 3}, {2, 0, 0}, {0, 3, 0}, {1, 2, 3});
  ASSERT_EQ(part.quads.size(), 1u);
  EXPECT_EQ(part.vertices[2], Vector3f(3, 5, 3));
  for (const Vector3f& n : part.normals) EXPECT_EQ(n, Vector3f(0, 0, 1));
  EXPECT_EQ(face_normal(part, 0), Vector3f(0, 0, 1));
  EXPECT_EQ(part.colours[3], (Rgb{1, 2, 3}));
}

TEST(RaisedWalls, StandUprightAndFaceWhoSawThem) {
  const std::vector<Segment> walls{wall({0, 0}, {4, 0}), wall({4, 1}, {3, -2})};
  const Solid solid = raise_walls(walls, {}, {.height = 2});
  ASSERT_EQ(solid.parts.size(), 1u);
  const SolidPart& part = solid.parts[0];
  ASSERT_EQ(part.quads.size(), walls.size());
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const Vec2 n = walls[i].normal();
    const Vector3f expected(static_cast<float>(n.x()), static_cast<float>(n.y()), 0);
    EXPECT_LT((face_normal(part, i) - expected).norm(), 1e-6);
    for (const std::uint32_t v : part.quads[i]) {
      EXPECT_LT((part.normals[v] - expected).norm(), 1e-6);
      const Vec2 p = part.vertices[v].head<2>().cast<double>();
      EXPECT_LT(distance_to(walls[i], p), 1e-6);
      EXPECT_TRUE(part.vertices[v].z() == 0 || part.vertices[v].z() == 2);
    }
  }
}

TEST(RaisedWalls, FloorIsWhatIsFree) {
  KnownMap map{0.5, -1, 2, 4, 3, std::vector<CellState>(12, CellState::free)};
  map.cells[map.index(3, 2)] = CellState::occupied;
  const Solid solid = raise_walls({}, map, {.floor_cell = 0.5});
  ASSERT_EQ(solid.parts.size(), 1u);
  const SolidPart& floor = solid.parts[0];
  EXPECT_EQ(floor.name, "floor");
  float area = 0;
  for (const auto& q : floor.quads)
    area += (floor.vertices[q[1]] - floor.vertices[q[0]])
                .cross(floor.vertices[q[3]] - floor.vertices[q[0]])
                .z();
  EXPECT_FLOAT_EQ(area, 11 * 0.25f);
  EXPECT_EQ(floor.vertices[floor.quads[0][0]], Vector3f(-1, 2, 0));
}

TEST(RaisedWalls, CellsOfAFloorAreFreeWhereMostOfThemIs) {
  KnownMap map{0.1, 0, 0, 4, 2, std::vector<CellState>(8, CellState::free)};
  map.cells[0] = map.cells[1] = CellState::unknown;  // half of the first coarse cell
  const Solid solid = raise_walls({}, map, {.floor_cell = 0.2});
  ASSERT_EQ(solid.parts[0].quads.size(), 1u);
  EXPECT_NEAR(solid.parts[0].vertices[0].x(), 0.2f, 1e-6);
}

TEST(RaisedWalls, NothingGivesNothing) {
  EXPECT_TRUE(raise_walls({}, KnownMap{}).parts.empty());
  EXPECT_TRUE(raise_walls(Site{}).parts.empty());
}

TEST(RaisedWalls, OfASimulatedBuildingAreWellFormed) {
  const sim::World world(sim::built_in("building"));
  sim::SimulationOptions options;
  options.scan_rate = 2;
  Site site;
  for (const Event& event :
       sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), options)) {
    if (const auto* scan = std::get_if<Scan>(&event)) site.scans.emplace_back().scan = *scan;
    if (const auto* truth = std::get_if<Truth>(&event))
      site.scans.back().estimate.T_map_robot = truth->T_world_robot;
  }
  const Solid solid = raise_walls(site);
  ASSERT_EQ(solid.parts.size(), 2u);
  EXPECT_TRUE(well_formed(solid));
  EXPECT_GT(solid.parts[0].quads.size(), 30u);
  const Solid without = raise_walls(site, {.floor = false});
  EXPECT_EQ(without.parts.size(), 1u);
  EXPECT_EQ(count(without).quads, solid.parts[0].quads.size());
}

TEST(RaisedWalls, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(raise_walls({}, {}, {.height = 0}), Error);
  EXPECT_THROW(raise_walls({}, {}, {.height = std::numeric_limits<double>::quiet_NaN()}), Error);
  EXPECT_THROW(raise_walls({}, {}, {.floor_cell = 0}), Error);
}

TEST(WellFormed, ToldFromWhatIsNot) {
  Solid solid{{SolidPart{.name = "one"}}};
  add_rectangle(solid.parts[0], {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {});
  EXPECT_TRUE(well_formed(solid));
  Solid far = solid, bare = solid, infinite = solid;
  far.parts[0].triangles.push_back({0, 1, 4});
  bare.parts[0].normals.pop_back();
  infinite.parts[0].vertices[0].x() = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(well_formed(far));
  EXPECT_FALSE(well_formed(bare));
  EXPECT_FALSE(well_formed(infinite));
}

}  // namespace
}  // namespace majak::map
