// SPDX-License-Identifier: Apache-2.0
#include "majak/map/room_labels.hpp"

#include <gmock/gmock.h>

#include "majak/core/error.hpp"
#include "tests/support/carved_map.hpp"

namespace majak::map {
namespace {

using fixture::Area;
using fixture::carved_map;

/// The wing, all of it moved by (dx, dy).
Topology wing(double dx = 0, double dy = 0, bool left_room = true) {
  std::vector<Area> floors{{0, 0, 12, 1.6}, {5.2, 1.8, 12, 6}, {8, 1.6, 8.8, 1.8}};
  if (left_room) {
    floors.push_back({0, 1.8, 5, 6});
    floors.push_back({2, 1.6, 2.9, 1.8});
  }
  for (Area& a : floors) a = {a.x0 + dx, a.y0 + dy, a.x1 + dx, a.y1 + dy};
  return build_topology(carved_map(floors));
}

TEST(RoomLabels, ByRule) {
  EXPECT_THAT(room_names(wing()), testing::UnorderedElementsAre("corridor 1", "room 1", "room 2"));
}

TEST(RoomLabels, SurviveARebuild) {
  const Topology before = wing();
  const std::vector<RoomLabel> labels{label_at(before, {0.3, 5.8}, "kitchen"),
                                      label_at(before, {6, 0.8}, "main street")};
  for (const double shift : {0.0, 0.15, 0.5}) {
    const Topology after = wing(shift, shift);
    const auto names = room_names(after, labels);
    EXPECT_EQ(names[after.room_at({3 + shift, 4 + shift})], "kitchen");
    EXPECT_EQ(names[after.room_at({6 + shift, 0.8 + shift})], "main street");
    const auto matches = match_labels(after, labels);
    // At 0.5 m the label's point is outside of its room, whose floor it still is.
    EXPECT_EQ(matches[0].fate, shift < 0.5 ? LabelFate::kept : LabelFate::moved);
    EXPECT_GT(matches[0].overlap, 0.75);
  }
}

TEST(RoomLabels, ALabelWithoutItsRoomIsReportedAndNotGivenToAnother) {
  const std::vector<RoomLabel> labels{label_at(wing(), {2, 4}, "kitchen")};
  const Topology after = wing(0, 0, false);
  EXPECT_EQ(match_labels(after, labels)[0].fate, LabelFate::lost);
  EXPECT_EQ(match_labels(after, labels)[0].room, -1);
  for (const std::string& name : room_names(after, labels)) EXPECT_NE(name, "kitchen");
}

TEST(RoomLabels, WhenAWallIsTakenOutTheLabelGoesWithTheFloor) {
  const Topology before = wing();
  const std::vector<RoomLabel> labels{label_at(before, {2, 4}, "left"),
                                      label_at(before, {8, 4}, "right")};
  const Topology after = build_topology(
      carved_map({{0, 0, 12, 1.6}, {0, 1.8, 12, 6}, {2, 1.6, 2.9, 1.8}, {8, 1.6, 8.8, 1.8}}));
  const auto matches = match_labels(after, labels);
  EXPECT_EQ(matches[0].room, after.room_at({2, 4}));
  EXPECT_EQ(matches[1].room, matches[0].room);
  EXPECT_EQ(room_names(after, labels)[matches[0].room], "right");  // the later one
}

TEST(RoomLabels, WithoutAnOutlineThePointDecides) {
  const Topology t = wing();
  const std::vector<RoomLabel> labels{{"kitchen", {2, 4}, {}}, {"moon", {40, 4}, {}}};
  const auto matches = match_labels(t, labels);
  EXPECT_EQ(matches[0].room, t.room_at({2, 4}));
  EXPECT_EQ(matches[1].fate, LabelFate::lost);
}

TEST(RoomLabels, NeedARoom) { EXPECT_THROW(label_at(wing(), {-5, 0}, "x"), Error); }

TEST(RoomLabels, EvidenceSaysWhy) {
  const Topology t = wing();
  EXPECT_EQ(evidence_of(t.rooms[t.room_at({6, 0.8})]), "1.5 m wide and 8 times as long");
  EXPECT_THAT(evidence_of(t.rooms[t.room_at({2, 4})]), testing::HasSubstr("1 door"));
}

}  // namespace
}  // namespace majak::map
