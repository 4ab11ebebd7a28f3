// SPDX-License-Identifier: Apache-2.0
#include "majak/map/returns.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

/// A robot that drives along x, 1 m a second, and looks ahead, left and right.
PosedScan at(int second) {
  PosedScan posed;
  posed.scan.time = second * kSecond;
  posed.scan.start_angle = -kPi / 2;
  posed.scan.angle_step = kPi / 2;
  posed.scan.ranges = {2, 3, 4};
  posed.estimate.T_map_robot = {double(second), 0, 0};
  return posed;
}

Site drive(int seconds) {
  Site site;
  site.source_name = "drive.log";
  for (int s = 0; s < seconds; ++s) {
    site.scans.push_back(at(s));
    site.truth.push_back({s * kSecond, {double(s), 0, 0}});
    if (s > 0) site.constraints.push_back({.from = std::size_t(s - 1), .to = std::size_t(s)});
  }
  return site;
}

TEST(CountReturns, EveryReturnIsInItsCell) {
  const ReturnCounts counts = count_returns(drive(3), 1.0);
  EXPECT_EQ(counts.returns, 9);
  EXPECT_EQ(counts.scans, 3);
  for (int x = 0; x < 3; ++x) EXPECT_EQ(counts.cells(x, -2), 1);
  for (int x = 0; x < 3; ++x) EXPECT_EQ(counts.cells(x, 4), 1);
  for (int x = 3; x < 6; ++x) EXPECT_EQ(counts.cells(x, 0), 1);
  int sum = 0;
  counts.cells.for_each([&](int, int, int n) { sum += n; });
  EXPECT_EQ(sum, 9);
}

TEST(CountReturns, WhatIsNoReturnIsCountedAsSuch) {
  Site site = drive(4);
  site.scans[0].scan.ranges = {kNoReturn, kInvalidRange, 31};
  site.scans[1].estimate.health = Health::lost;
  site.scans[2].estimate.T_map_robot.x = std::numeric_limits<double>::quiet_NaN();
  const ReturnCounts counts = count_returns(site, 1.0, 30);
  EXPECT_EQ(counts.scans, 2);
  EXPECT_EQ(counts.no_returns, 1);
  EXPECT_EQ(counts.unknown, 1);
  EXPECT_EQ(counts.returns, 3);
}

TEST(CountReturns, StopsAtTheMostThatACellCanSay) {
  Site site;
  site.scans.assign(70000, at(0));
  const ReturnCounts counts = count_returns(site, 1.0);
  EXPECT_EQ(counts.cells(3, 0), 65535);
  EXPECT_EQ(counts.returns, 210000);
}

TEST(Selected, ByTime) {
  const Site part = selected(drive(10), {.from = 3, .to = 5});
  ASSERT_EQ(part.scans.size(), 3U);
  EXPECT_EQ(part.scans.front().scan.time, 3 * kSecond);
  ASSERT_EQ(part.constraints.size(), 2U);
  EXPECT_EQ(part.constraints[0].from, 0U);
  EXPECT_EQ(part.constraints[1].to, 2U);
  EXPECT_EQ(part.truth.size(), 3U);
  EXPECT_EQ(part.source_name, "drive.log");
}

TEST(Selected, ByPlace) {
  const Site part = selected(drive(10), {.near = Vec2(7, 1), .radius = 1.5});
  ASSERT_EQ(part.scans.size(), 3U);
  EXPECT_EQ(part.scans.front().estimate.T_map_robot.x, 6);
}

TEST(Selected, EverythingIsTheSame) {
  const Site site = drive(5);
  const Site part = selected(site, {});
  EXPECT_EQ(part.scans.size(), site.scans.size());
  EXPECT_EQ(part.constraints.size(), site.constraints.size());
}

TEST(Selected, NothingIsSaid) {
  EXPECT_THROW(selected(drive(5), {.from = 100}), Error);
  EXPECT_THROW(selected(Site{}, {}), Error);
}

}  // namespace
}  // namespace majak::map
