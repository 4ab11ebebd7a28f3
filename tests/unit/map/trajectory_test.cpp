// SPDX-License-Identifier: Apache-2.0
#include "majak/map/trajectory.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace majak::map {
namespace {

Site site_of(const std::vector<std::pair<double, Pose2>>& stops) {
  Site site;
  for (const auto& [time, pose] : stops) {
    PosedScan& posed = site.scans.emplace_back();
    posed.scan.time = from_seconds(time);
    posed.estimate.T_map_robot = pose;
  }
  return site;
}
double apart(const Pose2& a, const Pose2& b) { return log(between(a, b)).norm(); }

const Pose2 kA{1, 2, 0.5}, kB{2, 2.5, 1.5};

TEST(Trajectory, IsTheScansPosesAndTheArcBetween) {
  const Trajectory way(site_of({{10, kA}, {10.5, kB}}));
  EXPECT_EQ(way.at(from_seconds(10)), kA);
  EXPECT_EQ(way.at(from_seconds(10.5)), kB);
  EXPECT_LT(apart(*way.at(from_seconds(10.125)), kA * exp(0.25 * log(between(kA, kB)))), 1e-12);
}

TEST(Trajectory, SaysNothingOutsideAndInGaps) {
  const Trajectory way(site_of({{10, kA}, {10.5, kB}, {12, kA}}));
  EXPECT_FALSE(way.at(from_seconds(9.999)));
  EXPECT_FALSE(way.at(from_seconds(12.001)));
  EXPECT_FALSE(way.at(from_seconds(11)));
  EXPECT_TRUE(way.at(from_seconds(12)));
  EXPECT_TRUE(Trajectory(site_of({{10, kA}, {12, kB}}), 2 * kSecond).at(from_seconds(11)));
  EXPECT_FALSE(Trajectory(Site{}).at(0));
}

TEST(Trajectory, LeavesOutWhatIsLostNotFiniteOrTwice) {
  Site site = site_of({{1, kA}, {1.2, {9, 9, 0}}, {1.4, kB}, {1.4, {7, 7, 0}}, {1.3, {8, 8, 8}}});
  site.scans[1].estimate.health = Health::lost;
  site.scans[4].estimate.T_map_robot.x = std::numeric_limits<double>::quiet_NaN();
  const Trajectory way(site);
  EXPECT_LT(apart(*way.at(from_seconds(1.2)), interpolate(kA, kB, 0.5)), 1e-9);
  EXPECT_EQ(way.at(from_seconds(1.4)), kB);
}

}  // namespace
}  // namespace majak::map
