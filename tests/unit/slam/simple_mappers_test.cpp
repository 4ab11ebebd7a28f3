// SPDX-License-Identifier: Apache-2.0
// Incremental maximum likelihood, EKF-SLAM as a method of mapping, and the corners that it sees.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/slam/corners.hpp"
#include "majak/slam/ekf_mapper.hpp"
#include "majak/slam/incremental_ml.hpp"
#include "tests/support/ascii_room.hpp"
#include "tests/unit/slam/simulated.hpp"

namespace majak::slam {
namespace {

using fixture::all_around;
using fixture::AsciiRoom;
using fixture::Laser;

const AsciiRoom& room() {
  static const AsciiRoom room({
      "############",
      "#..........#",
      "#..........#",
      "#....##....#",
      "#.a..##....#",
      "#..........#",
      "############",
  });
  return room;
}

// Of that room by eye: the four inside, and of the block those that 'a' sees.
std::vector<Vec2> seen_from_a() {
  return {{0.5, 0.5}, {5.5, 0.5}, {0.5, 3.0}, {5.5, 3.0}, {2.5, 1.0}, {2.5, 2.0}, {3.5, 1.0}};
}

double nearest(const std::vector<Vec2>& all, const Vec2& p) {
  double least = 1e9;
  for (const Vec2& q : all) least = std::min(least, (q - p).norm());
  return least;
}

TEST(Corners, AreWhereWallsMeetOrEnd) {
  const Pose2 at = room().pose('a', 0.4);
  const auto corners = find_corners(room().scan(at, all_around(720)));
  ASSERT_GE(corners.size(), 4U);
  for (const Corner& c : corners) EXPECT_LT(nearest(seen_from_a(), at * c.p_robot), 0.03);
  for (const Vec2& inside : {Vec2(0.5, 0.5), Vec2(0.5, 3.0)}) {
    double least = 1e9;
    for (const Corner& c : corners) least = std::min(least, (at * c.p_robot - inside).norm());
    EXPECT_LT(least, 1e-3);
  }
}

TEST(Corners, DoNotHangOnTheMounting) {
  const Pose2 at = room().pose('a');
  Laser laser = all_around(720);
  const auto straight = find_corners(room().scan(at, laser));
  laser.T_robot_laser = {0.3, -0.1, 2.0};
  const Pose2 T_map_robot = at * laser.T_robot_laser.inverse();
  const auto mounted = find_corners(room().scan(T_map_robot, laser));
  ASSERT_FALSE(straight.empty());
  for (const Corner& c : mounted) {  // the beams are others: ends lie between other ones
    double least = 1e9;
    for (const Corner& s : straight)
      least = std::min(least, (T_map_robot * c.p_robot - at * s.p_robot).norm());
    EXPECT_LT(least, 0.03);
  }
}

TEST(Corners, ErrAsMuchAsTheySay) {
  const Pose2 at = room().pose('a');
  double sum = 0;
  int count = 0;
  for (int seed = 1; seed <= 60; ++seed) {
    Laser laser = all_around(360);
    laser.noise = 0.01, laser.seed = seed;
    for (const Corner& c : find_corners(room().scan(at, laser), {.wall_sigma = 0})) {
      const Vec2 p = at * c.p_robot;
      for (const Vec2& truth : {Vec2(0.5, 0.5), Vec2(0.5, 3.0)}) {
        const Vec2 off = p - truth;
        if (off.norm() > 0.1) continue;
        sum += off.dot(c.covariance.inverse() * off);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 100);
  EXPECT_GT(sum / count, 1.0);  // 2 if honest
  EXPECT_LT(sum / count, 3.0);
}

TEST(Corners, ThereAreNoneInNothing) {
  EXPECT_TRUE(find_corners(Scan{}).empty());
  Scan blind = room().scan(room().pose('a'));
  std::fill(blind.ranges.begin(), blind.ranges.end(), kNoReturn);
  EXPECT_TRUE(find_corners(blind).empty());
}

template <class Method>
Mapping run(Method& method, const std::vector<Event>& events) {
  for (const Event& event : events) method.add(event);
  return method.finish();
}

PathError shape(const Site& site) {
  return shape_error_of(site, [](const PosedScan& s) { return s.estimate.T_map_robot; });
}

TEST(IncrementalMl, NeverMovesWhatIsPlaced) {
  IncrementalMl method({}, {}, {});
  std::vector<Estimate> told;
  for (const Event& event : building_run())
    if (const auto estimate = method.add(event)) told.push_back(*estimate);
  const Mapping mapping = method.finish();
  EXPECT_FALSE(mapping.posterior);
  EXPECT_GT(mapping.belief_bytes, 100000U);
  EXPECT_LT(shape(mapping.site).rms, 0.1);
  std::size_t keys = 0;
  for (const PosedScan& s : mapping.site.scans) {
    const auto then = std::find_if(told.begin(), told.end(),
                                   [&](const Estimate& e) { return e.time == s.scan.time; });
    if (!s.key || then == told.end()) continue;
    ++keys;
    EXPECT_NEAR((then->T_map_robot.translation() - s.estimate.T_map_robot.translation()).norm(), 0,
                1e-12);
  }
  EXPECT_GT(keys, 200U);
}

TEST(IncrementalMl, NothingToMapIsAnError) {
  IncrementalMl method({}, {}, {});
  EXPECT_THROW(method.finish(), Error);
}

TEST(EkfMapper, KnowsHowSureItIs) {
  EkfMapper method({}, ekf_for_rooms(), {});
  const Mapping mapping = run(method, building_run());
  EXPECT_TRUE(mapping.posterior);
  EXPECT_GT(mapping.landmarks, 30U);
  EXPECT_LT(shape(mapping.site).rms, 0.2);
  double nees = 0;
  std::size_t count = 0;
  const auto truth = truth_of(building_run());
  const PosedScan& first = mapping.site.scans.front();
  const Pose2 T_world_map = truth.at(first.scan.time) * first.estimate.T_map_robot.inverse();
  for (const PosedScan& s : mapping.site.scans) {
    const Pose2 at = T_world_map.inverse() * truth.at(s.scan.time);
    const Vec3 off(at.x - s.estimate.T_map_robot.x, at.y - s.estimate.T_map_robot.y,
                   angle_diff(at.theta, s.estimate.T_map_robot.theta));
    if (!(s.estimate.covariance.determinant() > 1e-20)) continue;
    nees += off.dot(s.estimate.covariance.inverse() * off), ++count;
  }
  ASSERT_GT(count, 1000U);
  EXPECT_LT(nees / static_cast<double>(count), 8);  // of one run, whose poses err together
}

TEST(EkfMapper, OneScanIsAMap) {
  EkfMapper method({}, ekf_for_rooms(), {});
  method.add(room().scan(room().pose('a')));
  EXPECT_EQ(method.finish().site.scans.size(), 1U);
}

}  // namespace
}  // namespace majak::slam
