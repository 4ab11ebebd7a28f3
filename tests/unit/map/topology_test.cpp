// SPDX-License-Identifier: Apache-2.0
#include "majak/map/topology.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>

#include "majak/core/error.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/region_outline.hpp"
#include "majak/sim/floor_plans.hpp"
#include "majak/sim/known_map.hpp"
#include "tests/support/carved_map.hpp"

namespace majak::map {
namespace {

using fixture::Area;
using fixture::carved_map;

// Two rooms over a corridor; walls of 0.2 m, doors of 0.9 and 0.8 m.
const std::vector<Area> kWing{{0, 0, 12, 1.6},     // corridor
                              {0, 1.8, 5, 6},      // left room
                              {5.2, 1.8, 12, 6},   // right room
                              {2, 1.6, 2.9, 1.8},  // their doors
                              {8, 1.6, 8.8, 1.8}};

KnownMap office_cells(std::uint64_t seed) {
  return sim::known_map(sim::World(sim::generated_building(seed).scene));
}

KnownMap mirrored(KnownMap map) {
  for (int iy = 0; iy < map.height; ++iy)
    std::reverse(map.cells.begin() + static_cast<std::ptrdiff_t>(map.index(0, iy)),
                 map.cells.begin() + static_cast<std::ptrdiff_t>(map.index(0, iy)) + map.width);
  return map;
}

TEST(Topology, TwoRoomsOverACorridor) {
  const Topology t = build_topology(carved_map(kWing));
  ASSERT_EQ(t.rooms.size(), 3U);
  const int corridor = t.room_at({6, 0.8}), left = t.room_at({2, 4}), right = t.room_at({8, 4});
  EXPECT_NE(left, right);
  EXPECT_EQ(t.rooms[corridor].kind, RoomKind::corridor);
  EXPECT_EQ(t.rooms[left].kind, RoomKind::room);
  EXPECT_NEAR(t.rooms[left].area, 5 * 4.2, 0.2);  // and half of its doorway
  EXPECT_NEAR(t.rooms[left].clearance, 2.1, 0.05);
  ASSERT_EQ(t.doors.size(), 2U);
  for (const Doorway& d : t.doors) {
    const bool first = d.centre.x() < 5;
    EXPECT_NEAR(d.centre.x(), first ? 2.45 : 8.4, 0.06);
    EXPECT_NEAR(d.centre.y(), 1.7, 0.11);
    EXPECT_NEAR(d.width, first ? 0.9 : 0.8, 0.051);
    EXPECT_NEAR(std::abs(d.along.x()), 1, 1e-12);
    EXPECT_FALSE(d.opening);
    EXPECT_EQ(std::minmax(d.from, d.to), std::minmax(corridor, first ? left : right));
  }
  EXPECT_EQ(t.rooms[corridor].doors, 2);
}

// From topology back to cells: labels, the rooms' cells and the free floor say the same.
TEST(Topology, RoomsShareOutTheFloor) {
  const KnownMap known = office_cells(114);
  const Topology t = build_topology(known);
  std::size_t labelled = 0;
  for (std::size_t r = 0; r < t.rooms.size(); ++r) {
    EXPECT_TRUE(std::is_sorted(t.rooms[r].cells.begin(), t.rooms[r].cells.end()));
    for (const std::uint32_t c : t.rooms[r].cells) EXPECT_EQ(t.labels[c], static_cast<int>(r));
    labelled += t.rooms[r].cells.size();
    EXPECT_NEAR(t.rooms[r].area,
                static_cast<double>(t.rooms[r].cells.size()) * t.resolution * t.resolution, 1e-9);
  }
  EXPECT_EQ(labelled, t.labels.size() - std::count(t.labels.begin(), t.labels.end(), -1));
  for (const std::uint32_t c : known.all(CellState::free)) EXPECT_GE(t.labels[c], 0);
}

// Side by side, one room follows another only in a doorway.
TEST(Topology, LabelsChangeInDoorwaysAlone) {
  for (const std::uint64_t seed : {114, 118}) {
    const Topology t = build_topology(office_cells(seed));
    int changes = 0;
    for (std::uint32_t c = 0; c + 1 < t.labels.size(); ++c)
      for (const std::uint32_t n : {c + 1, c + static_cast<std::uint32_t>(t.width)}) {
        if (n >= t.labels.size() || t.labels[c] < 0 || t.labels[n] < 0) continue;
        if (t.labels[c] == t.labels[n]) continue;
        ++changes;
        const Vec2 p = 0.5 * (t.centre(c) + t.centre(n));
        EXPECT_TRUE(std::any_of(t.doors.begin(), t.doors.end(),
                                [&](const Doorway& d) {
                                  const Vec2 off = p - d.centre;
                                  return std::abs(off.dot(d.along)) <= d.width / 2 + 0.1 &&
                                         std::abs(off.x() * d.along.y() - off.y() * d.along.x()) <=
                                             0.15;
                                }))
            << "seed " << seed << " at " << p.transpose();
      }
    EXPECT_GT(changes, 100);
  }
}

TEST(Topology, AMirrorChangesNothingButTheSide) {
  const KnownMap known = office_cells(114);
  const Topology a = build_topology(known), b = build_topology(mirrored(known));
  ASSERT_EQ(a.rooms.size(), b.rooms.size());
  ASSERT_EQ(a.doors.size(), b.doors.size());
  const auto areas = [](const Topology& t) {
    std::vector<double> areas;
    for (const Room& room : t.rooms) areas.push_back(room.area);
    std::sort(areas.begin(), areas.end());
    return areas;
  };
  const auto first = areas(a), second = areas(b);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(first[i], second[i], 0.2);
}

TEST(Topology, ThreadsChangeNothing) {
  const KnownMap known = office_cells(114);
  const Topology one = build_topology(known);
  for (const int threads : {2, 8}) {
    const Topology many = build_topology(known, {}, {threads});
    EXPECT_EQ(one.labels, many.labels);
    ASSERT_EQ(one.doors.size(), many.doors.size());
    for (std::size_t i = 0; i < one.doors.size(); ++i)
      EXPECT_EQ(one.doors[i].centre, many.doors[i].centre);
  }
}

TEST(Topology, FurnitureIsFloorOfItsRoomAndPiersAreWall) {
  std::vector<Area> floors = kWing;
  floors.push_back({3.9, 1.6, 4.8, 1.8});  // a second door, 1 m beside the first
  const Topology t = build_topology(carved_map(floors, {{8, 3.5, 9.6, 4.3}}));
  ASSERT_EQ(t.rooms.size(), 3U);
  EXPECT_EQ(t.doors.size(), 3U);
  ASSERT_EQ(t.furniture.size(), 1U);
  EXPECT_NEAR((t.furniture[0].centre - Vec2(8.8, 3.9)).norm(), 0, 0.05);
  EXPECT_NEAR(t.furniture[0].size.x(), 1.6, 0.051);
  EXPECT_EQ(t.furniture[0].room, t.room_at({6, 5}));
  EXPECT_EQ(t.room_at({8.8, 3.9}), t.room_at({6, 5}));
}

TEST(Topology, ALeafThatStandsOpenPartsNothing) {
  for (const double length : {0.5, 0.85}) {
    const Topology t = build_topology(carved_map(kWing, {{2.0, 1.8, 2.05, 1.8 + length}}));
    EXPECT_EQ(t.rooms.size(), 3U);
    EXPECT_EQ(t.doors.size(), 2U);
  }
}

TEST(Topology, NarrowsBetweenDesksAreNoDoors) {
  const Topology t = build_topology(carved_map(
      kWing, {{5.2, 3.6, 8, 4.4}, {8.9, 3.6, 12, 4.4}}));  // 0.9 m between two long desks
  EXPECT_EQ(t.rooms.size(), 3U);
  EXPECT_EQ(t.room_at({6, 2.5}), t.room_at({6, 5.5}));
}

TEST(Topology, AWideGapIsAnOpening) {
  std::vector<Area> floors = kWing;
  floors.push_back({7, 1.6, 9.6, 1.8});  // 2.6 m
  const Topology t = build_topology(carved_map(floors));
  ASSERT_EQ(t.doors.size(), 2U);
  EXPECT_EQ(std::count_if(t.doors.begin(), t.doors.end(), [](const auto& d) { return d.opening; }),
            1);
  TopologyOptions strict;
  strict.widest_opening = 2.2;
  EXPECT_EQ(build_topology(carved_map(floors), strict).rooms.size(), 2U);
}

TEST(Topology, OutlinesHoldTheirCells) {
  const Topology t = build_topology(carved_map(kWing));
  for (std::size_t r = 0; r < t.rooms.size(); ++r) {
    EXPECT_NEAR(polygon_area(t.rooms[r].outline), t.rooms[r].area, 1e-9);
    Vec2 low(1e9, 1e9), high(-1e9, -1e9);
    for (const Vec2& p : t.rooms[r].outline) low = low.cwiseMin(p), high = high.cwiseMax(p);
    for (const std::uint32_t c : t.rooms[r].cells) {
      EXPECT_TRUE((t.centre(c).array() > low.array()).all());
      EXPECT_TRUE((t.centre(c).array() < high.array()).all());
    }
  }
}

TEST(Topology, NothingAndNoWalls) {
  EXPECT_TRUE(build_topology(KnownMap{}).rooms.empty());
  EXPECT_TRUE(build_topology(known_map(build_occupancy_grid(Site{}))).rooms.empty());
  KnownMap open;
  open.width = open.height = 100;
  open.cells.assign(10000, CellState::free);
  const Topology t = build_topology(open);
  ASSERT_EQ(t.rooms.size(), 1U);
  EXPECT_TRUE(t.doors.empty());
  EXPECT_LE(t.rooms[0].clearance, 2.5);
  open.cells.assign(10000, CellState::unknown);
  EXPECT_TRUE(build_topology(open).rooms.empty());
}

TEST(Topology, WhatIsSeenThroughAWindowIsNoRoom) {
  KnownMap map = carved_map(kWing);
  for (int iy = map.row(3); iy < map.row(5); ++iy)  // floor without any surface around it
    for (int ix = map.column(12.3); ix < map.column(12.9); ++ix)
      map.cells[map.index(ix, iy)] = CellState::free;
  TopologyOptions small;
  small.smallest_room = 1.0;
  EXPECT_EQ(build_topology(map, small).rooms.size(), 3U);
}

TEST(Topology, OptionsOutOfRangeAreRefused) {
  TopologyOptions o;
  o.jamb = -1;
  EXPECT_THROW(build_topology(carved_map(kWing), o), Error);
}

}  // namespace
}  // namespace majak::map
