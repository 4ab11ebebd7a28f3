// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/resection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "tests/unit/beacon/scatter.hpp"

namespace majak::beacon {
namespace {

const BeaconMap kHall = {{{1, {0, 0}, ""},
                          {2, {20, 2}, ""},
                          {3, {8, 19}, ""},
                          {4, {-3, 12}, ""},
                          {5, {23, 14}, ""},
                          {6, {12, -4}, ""}}};
const Pose2 kMounting{0.3, 0.1, 0.4};

std::vector<BeaconSighting> seen(const Pose2& T_map_robot, bool ranges, bool bearings,
                                 RandomStream* noise = nullptr) {
  std::vector<BeaconSighting> out;
  for (const Beacon& b : kHall.beacons) {
    const Vec2 way = (T_map_robot * kMounting).inverse() * b.p_map;
    BeaconSighting s;
    s.beacon = b.number;
    s.range_sigma = 0.05;
    s.bearing_sigma = 0.004;
    const auto error = [&] { return noise == nullptr ? 0 : noise->normal(); };
    if (ranges) s.range = way.norm() + 0.05 * error();
    if (bearings) s.bearing = std::atan2(way.y(), way.x()) + 0.004 * error();
    s.T_robot_sensor = kMounting;
    out.push_back(s);
  }
  return out;
}

Vec3 error(const PoseFix& fix, const Pose2& truth) {
  return {fix.T_map_robot.x - truth.x, fix.T_map_robot.y - truth.y,
          angle_diff(fix.T_map_robot.theta, truth.theta)};
}

TEST(Resection, IsExactWithoutNoise) {
  RandomStream random(1);
  for (int i = 0; i < 200; ++i) {
    const Pose2 pose{random.uniform(2, 18), random.uniform(3, 16), random.uniform(-kPi, kPi)};
    for (const bool ranges : {true, false}) {
      const auto fix = resect(seen(pose, ranges, true), kHall);
      EXPECT_EQ(fix.problem, FixProblem::none);
      EXPECT_LT(error(fix, pose).norm(), 1e-11);
      EXPECT_EQ(fix.dof, ranges ? 9 : 3);
    }
    auto two = seen(pose, true, true);
    two.resize(2);
    EXPECT_LT(error(resect(two, kHall), pose).norm(), 1e-11);
  }
}

TEST(Resection, ScatterIsTheStatedCovariance) {
  for (const Pose2& pose : {Pose2{9, 8, 1}, Pose2{3, 14, -2}}) {
    Scatter<3> scatter(resect(seen(pose, true, true), kHall).covariance);
    RandomStream random(2);
    for (int i = 0; i < 10000; ++i) {
      scatter.add(error(resect(seen(pose, true, true, &random), kHall), pose));
    }
    EXPECT_LT(scatter.difference(), 0.05);
  }
}

TEST(Resection, LeavesOutGrossErrorsAndUnknownBeacons) {
  const Pose2 pose{9, 8, 1};
  auto sightings = seen(pose, true, true);
  *sightings[1].range += 3;
  *sightings[4].bearing += 1;
  sightings[2].beacon = 99;
  sightings.push_back(sightings[3]);
  sightings.back().beacon = -1;
  const auto fix = resect(sightings, kHall);
  EXPECT_EQ(fix.problem, FixProblem::none);
  EXPECT_EQ(fix.unknown, 2);
  EXPECT_EQ(fix.gross, 2);
  EXPECT_LT(error(fix, pose).norm(), 1e-11);
}

TEST(Resection, BadInput) {
  const Pose2 pose{9, 8, 1};
  EXPECT_EQ(resect({}, kHall).problem, FixProblem::too_few);
  EXPECT_EQ(resect(seen(pose, true, true), {}).problem, FixProblem::too_few);
  EXPECT_EQ(resect(seen(pose, true, true), {}).unknown, 6);
  auto two = seen(pose, false, true);
  two.resize(2);
  EXPECT_EQ(resect(two, kHall).problem, FixProblem::too_few);
  EXPECT_EQ(resect(seen(pose, true, false), kHall).problem, FixProblem::too_few);  // no heading
  auto twice = seen(pose, true, true);
  twice.resize(1);
  twice.push_back(twice[0]);
  EXPECT_EQ(resect(twice, kHall).problem, FixProblem::too_few);
  auto bad = seen(pose, true, true);
  bad[0].range = std::nan("");
  EXPECT_EQ(resect(bad, kHall).problem, FixProblem::bad_value);
  bad = seen(pose, true, true);
  bad[0].bearing_sigma = 0;
  EXPECT_EQ(resect(bad, kHall).problem, FixProblem::bad_value);
  auto wrong = seen(pose, true, true);
  wrong.resize(2);
  *wrong[0].range += 5;
  EXPECT_EQ(resect(wrong, kHall).problem, FixProblem::inconsistent);
  EXPECT_THROW(resect(std::vector<BeaconSighting>(33, seen(pose, true, true)[0]), kHall), Error);
}

}  // namespace
}  // namespace majak::beacon
