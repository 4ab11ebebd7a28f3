// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/rooms.hpp"

#include <gtest/gtest.h>

#include "majak/map/occupancy_grid.hpp"
#include "majak/sim/known_map.hpp"
#include "majak/sim/surveyed_site.hpp"

namespace majak::eval {
namespace {

/// As if everything had been found.
map::Topology true_topology(const sim::GeneratedBuilding& office) {
  const map::KnownMap floor = sim::known_map(sim::World(office.scene));
  map::Topology t{floor.resolution, floor.x0, floor.y0, floor.width, floor.height, {}, {}, {}, {}};
  t.labels.assign(floor.cells.size(), -1);
  t.rooms.resize(office.places.size());
  for (const std::uint32_t c : floor.all(map::CellState::free))
    t.labels[c] = office.place_at(t.centre(c));
  for (const sim::TrueDoor& d : office.doors)
    t.doors.push_back(
        {d.centre, d.along, d.width, std::min(d.from, d.to), std::max(d.from, d.to), d.opening});
  return t;
}

TEST(RoomScore, TheTruthIsPerfectInAnyFrame) {
  const sim::GeneratedBuilding office = sim::generated_building(104);
  const RoomScore s = score_rooms(true_topology(office), Pose2{}, office);
  EXPECT_DOUBLE_EQ(s.mean_overlap(), 1);
  EXPECT_EQ(s.doors_found, s.true_doors);
  EXPECT_EQ(s.false_doors, 0);
  map::Topology shifted = true_topology(office);
  shifted.x0 += 4;
  for (map::Doorway& d : shifted.doors) d.centre.x() += 4;
  EXPECT_GT(score_rooms(shifted, Pose2{-4, 0, 0}, office).mean_overlap(), 0.97);
  EXPECT_EQ(score_rooms(shifted, Pose2{-4, 0, 0}, office).doors_found, s.true_doors);
  EXPECT_LT(score_rooms(shifted, Pose2{}, office).mean_overlap(), 0.5);
}

TEST(RoomScore, CountsWhatIsMissingAndWhatIsInvented) {
  const sim::GeneratedBuilding office = sim::generated_building(104);
  map::Topology t = true_topology(office);
  const RoomScore all = score_rooms(t, Pose2{}, office);
  t.doors[0].centre += Vec2(0, 50);
  const RoomScore s = score_rooms(t, Pose2{}, office);
  EXPECT_EQ(s.doors_found, all.doors_found - 1);
  EXPECT_EQ(s.false_doors, 1);
  for (auto& label : t.labels) label = label >= 0 ? 0 : label;  // one room for all
  EXPECT_LT(score_rooms(t, Pose2{}, office).mean_overlap(), 0.2);
  t.rooms.clear();
  for (auto& label : t.labels) label = -1;
  EXPECT_EQ(score_rooms(t, Pose2{}, office).mean_overlap(), 0);
}

TEST(RoomScore, ABuildingThatWasDrivenThrough) {
  const sim::GeneratedBuilding office = sim::generated_building(106);
  const sim::World world(office.scene);
  const Site site = sim::surveyed_site(world, sim::plan_tour(world));
  const map::Topology t = map::build_topology(map::known_map(map::build_occupancy_grid(site)));
  const RoomScore s = score_rooms(t, Pose2{}, office);
  EXPECT_GT(s.mean_overlap(), 0.95);
  EXPECT_EQ(s.doors_found, s.true_doors);
  EXPECT_EQ(s.false_doors, 0);
}

}  // namespace
}  // namespace majak::eval
