// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/mapped_drive.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::draw {
namespace {

/// A robot that sees one thing straight ahead, from each of these poses.
MappedDrive looks_ahead(float range, std::vector<Pose2> poses) {
  MappedDrive drive;
  Scan scan;
  scan.angle_step = kPi / 180;
  scan.ranges = {range};
  drive.truth = std::move(poses);
  drive.site.scans.assign(drive.truth.size(), {.scan = scan});
  return drive;
}

std::vector<Point> cells_of(const MappedDrive& drive) {
  return map_cells(drive, drive.truth, 0, drive.truth.size(), 0.1);
}

TEST(MapCells, ThreeReturnsMakeOne) {
  const Pose2 here{1, 2, kPi / 2};
  EXPECT_TRUE(cells_of(looks_ahead(3.04F, {here, here})).empty());
  const auto cells = cells_of(looks_ahead(3.04F, {here, here, here}));
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_NEAR(cells[0].x, 1, 0.0501);
  EXPECT_NEAR(cells[0].y, 5.05, 1e-9);
}

TEST(MapCells, OfTheScansThatAreAskedForAndNear) {
  const Pose2 here{0.05, 0.05, 0}, there{0.05, 7.05, 0};
  const MappedDrive drive = looks_ahead(4, {here, here, here, there, there, there});
  EXPECT_EQ(cells_of(drive).size(), 2U);
  const auto later = map_cells(drive, drive.truth, 3, 6, 0.1);
  ASSERT_EQ(later.size(), 1U);
  EXPECT_NEAR(later[0].y, 7.05, 1e-9);
  EXPECT_TRUE(cells_of(looks_ahead(10.5F, {here, here, here})).empty());
}

TEST(MappedDrive, AllWaysBeginAtTheTruthAndTheEstimateKeepsToIt) {
  const sim::World world(sim::ring());
  const sim::Path path = sim::plan_tour(world, {.short_tour = true});
  std::vector<Event> events = sim::simulate(world, path, {});
  events.resize(events.size() / 4);
  while (!std::holds_alternative<Truth>(events.back())) events.pop_back();
  const MappedDrive drive = map_drive(events, {});
  ASSERT_GT(drive.truth.size(), 100U);
  for (const auto* poses : {&drive.wheels, &drive.matching, &drive.closed}) {
    ASSERT_EQ(poses->size(), drive.truth.size());
    EXPECT_LT(place_errors(drive, *poses).front(), 1e-12);
    EXPECT_NEAR(angle_diff(poses->front().theta, drive.truth.front().theta), 0, 1e-12);
  }
  EXPECT_LT(place_errors(drive, drive.closed).back(), 0.1);
  EXPECT_EQ(drive.truth.front().translation(), path.start.translation());
}

TEST(AddPlan, EveryWallAndEveryRoundThing) {
  const sim::World world(sim::ring());
  std::vector<Mark> marks;
  add_plan(marks, world, {});
  EXPECT_EQ(marks.size(), world.scene().segments.size() + world.scene().discs.size());
}

}  // namespace
}  // namespace majak::draw
