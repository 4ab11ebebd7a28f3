// SPDX-License-Identifier: Apache-2.0
#include "majak/map/doors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "majak/sim/world.hpp"

namespace majak::map {
namespace {

const sim::Segment kLeaf{{-0.5, 2}, {0.5, 2}};

/// Two rooms with a wall of 0.1 m between them and a doorway of 1 m in it, as a laser sees them
/// that goes to and fro before the wall. What else there is, by time: `extra`.
Site drive(double seconds, const std::function<std::vector<sim::Segment>(double)>& extra,
           double sway = 0.6) {
  sim::Scene scene;
  const auto box = [&](double x0, double y0, double x1, double y1) {
    const Vec2 p[] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    for (int i = 0; i < 4; ++i) scene.segments.push_back({p[i], p[(i + 1) % 4]});
  };
  box(-3, -1, 3, 5);
  box(-3, 1.95, -0.5, 2.05);
  box(0.5, 1.95, 3, 2.05);
  const sim::World world(scene);
  Site site;
  for (double t = 0; t < seconds; t += 0.2) {
    PosedScan s;
    s.scan.time = from_seconds(t);
    s.scan.start_angle = 0;
    s.scan.angle_step = kPi / 180;
    s.estimate.T_map_robot = {sway * std::sin(t / 3), -0.2 + 0.1 * std::cos(t / 5), 0};
    const Pose2& pose = s.estimate.T_map_robot;
    const auto leaves = extra(t);
    for (int i = 0; i <= 180; ++i)
      s.scan.ranges.push_back(static_cast<float>(
          world.cast(pose.translation(), s.scan.angle(static_cast<std::size_t>(i)), 80, {}, leaves)
              .range));
    site.scans.push_back(s);
  }
  return site;
}

std::vector<sim::Segment> shut(double t) {
  return t < 39.9 || t > 79.9 ? std::vector{kLeaf} : std::vector<sim::Segment>{};
}

TEST(Doors, ADoorThatOpensIsFound) {
  const auto doors = find_doors(build_dynamics(drive(120, shut)));
  ASSERT_EQ(doors.size(), 1U);
  const bool turned = doors[0].a.x() > doors[0].b.x();
  const Vec2 a = turned ? doors[0].b : doors[0].a, b = turned ? doors[0].a : doors[0].b;
  EXPECT_LT((a - Vec2(-0.5, 2)).norm(), 0.1);
  EXPECT_LT((b - Vec2(0.5, 2)).norm(), 0.1);
}

// The leaf that stands across, as it does when open, is no door of its own.
TEST(Doors, ALeafOnItsHingeIsOneDoor) {
  const auto swings = [](double t) {
    return std::vector{shut(t).empty() ? sim::Segment{{-0.5, 2}, {-0.5, 1}} : kLeaf};
  };
  EXPECT_EQ(find_doors(build_dynamics(drive(120, swings))).size(), 1U);
}

TEST(Doors, WhatIsNoDoor) {
  const auto nothing = [](double) { return std::vector<sim::Segment>{}; };
  EXPECT_TRUE(find_doors(build_dynamics(drive(60, nothing))).empty());
  const auto always = [](double) { return std::vector{kLeaf}; };
  EXPECT_TRUE(find_doors(build_dynamics(drive(60, always))).empty());
  // A screen in the middle of the room, put away later.
  const auto screen = [](double t) {
    return t < 40 ? std::vector{sim::Segment{{-0.5, 1}, {0.5, 1}}} : std::vector<sim::Segment>{};
  };
  EXPECT_TRUE(find_doors(build_dynamics(drive(80, screen))).empty());
}

TEST(Doors, StateIsRightWithinThreeScans) {
  const Site site = drive(120, shut);
  DoorWatch watch({{kLeaf.a, kLeaf.b}});
  EXPECT_EQ(watch.state(0), DoorState::unknown);
  bool was_shut = true;
  int since = 0;
  for (const PosedScan& scan : site.scans) {
    watch.add(scan);
    const bool is_shut = !shut(to_seconds(scan.scan.time)).empty();
    since = is_shut == was_shut ? since + 1 : 1;
    was_shut = is_shut;
    EXPECT_TRUE(watch.in_sight(0));
    if (since >= 3) {
      EXPECT_EQ(watch.state(0), is_shut ? DoorState::closed : DoorState::open);
    }
  }
}

TEST(Doors, AHistoryTellsWhen) {
  const auto histories = door_histories(drive(120, shut), {{kLeaf.a, kLeaf.b}});
  ASSERT_EQ(histories.size(), 1U);
  const auto& stays = histories[0].stays;
  ASSERT_EQ(stays.size(), 4U);
  EXPECT_EQ(stays[0].state, DoorState::unknown);
  EXPECT_EQ(stays[1].state, DoorState::closed);
  EXPECT_EQ(stays[2].state, DoorState::open);
  EXPECT_EQ(stays[3].state, DoorState::closed);
  EXPECT_NEAR(to_seconds(stays[2].begin), 40, 0.7);
  EXPECT_NEAR(to_seconds(stays[3].begin), 80, 0.7);
}

TEST(Doors, AWallThatPosesMovedIsNone) {
  Site site = drive(120, shut);
  const DynamicsMap dynamics = build_dynamics(site);
  const auto moved = doors_that_moved(site, dynamics);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].stays.size(), 4U);
  // The same cells, but in all scans the doorway is shut.
  const auto always = [](double) { return std::vector{kLeaf}; };
  EXPECT_TRUE(doors_that_moved(drive(120, always), dynamics).empty());
}

// Out of sight a belief fades.
TEST(Doors, WhatWasSeenLongAgoIsUnknown) {
  Site site = drive(10, shut);
  DoorWatch watch({{kLeaf.a, kLeaf.b}});
  for (const PosedScan& s : site.scans) watch.add(s);
  ASSERT_EQ(watch.state(0), DoorState::closed);
  PosedScan lost = site.scans.back();
  lost.estimate.health = Health::lost;
  lost.scan.time += from_seconds(1000);
  watch.add(lost);
  EXPECT_EQ(watch.state(0), DoorState::unknown);
  EXPECT_FALSE(watch.in_sight(0));
}

// Turning the whole world by a right angle turns the doors with it.
TEST(Doors, DoorsTurnWithTheWorld) {
  Site site = drive(120, shut);
  const Pose2 T_new_old{10, -7, kPi / 2};
  for (PosedScan& s : site.scans) s.estimate.T_map_robot = T_new_old * s.estimate.T_map_robot;
  const auto doors = find_doors(build_dynamics(site));
  ASSERT_EQ(doors.size(), 1U);
  const Vec2 middle = (doors[0].a + doors[0].b) / 2;
  EXPECT_LT((middle - T_new_old * Vec2(0, 2)).norm(), 0.1);
}

}  // namespace
}  // namespace majak::map
