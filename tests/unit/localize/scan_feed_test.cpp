// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/scan_feed.hpp"

#include <gtest/gtest.h>

namespace majak::localize {
namespace {

Scan scan_at(double seconds, int laser = 0) {
  Scan scan;
  scan.time = from_seconds(seconds);
  scan.laser = laser;
  scan.ranges = {1, 2, 3};
  return scan;
}

TEST(ScanFeed, WaitsForTheOdometryBehindAScan) {
  ScanFeed feed;
  feed.add(Odometry{from_seconds(0), {0, 0, 0}, {}, {}});
  feed.add(scan_at(0));
  ASSERT_TRUE(feed.next());
  feed.add(scan_at(1));
  EXPECT_FALSE(feed.next());
  feed.add(Odometry{from_seconds(2), {2, 0, 0}, {}, {}});
  const auto fed = feed.next();
  ASSERT_TRUE(fed);
  EXPECT_TRUE(fed->by_wheels);
  EXPECT_NEAR(fed->T_previous_robot.x, 1, 1e-12);
  EXPECT_GT(fed->covariance(0, 0), 0);
  EXPECT_FALSE(feed.next());
}

TEST(ScanFeed, AtTheEndNothingIsKeptBack) {
  ScanFeed feed;
  feed.add(Odometry{from_seconds(0), {0, 0, 0}, {}, {}});
  for (int k = 0; k < 4; ++k) feed.add(scan_at(k));
  while (feed.next()) continue;
  feed.end();
  int more = 0;
  while (feed.next()) ++more;
  EXPECT_EQ(more, 3);
}

TEST(ScanFeed, TheScansOwnRecordsNeedNoWaiting) {
  ScanFeed feed;
  for (int k = 0; k < 3; ++k) {
    Scan scan = scan_at(k);
    scan.T_odom_robot = Pose2{0.5 * k, 0, 0.1 * k};
    feed.add(scan);
    const auto fed = feed.next();
    ASSERT_TRUE(fed);
    if (k == 0) {
      EXPECT_EQ(fed->T_previous_robot, Pose2{});
    } else {
      EXPECT_NEAR(fed->T_previous_robot.theta, 0.1, 1e-12);
    }
  }
}

TEST(ScanFeed, WithoutWheelsTheRobotGoesOnAsItWent) {
  ScanFeed feed;
  for (int k = 0; k < 12; ++k) {
    feed.add(scan_at(0.1 * k));
    const auto fed = feed.next();
    ASSERT_TRUE(fed);
    EXPECT_FALSE(fed->by_wheels);
    if (k == 11) {
      EXPECT_NEAR(fed->T_previous_robot.x, 0.05, 1e-9);
    }
    feed.observe({0.05, 0, 0}, true);
  }
}

TEST(ScanFeed, SpeedAndSteeringAreWheelsToo) {
  ScanFeed feed;
  for (int k = 0; k <= 40; ++k) {
    feed.add(WheelMotion{from_seconds(0.1 * k), 2.0, 0});
    if (k % 10 == 5) feed.add(scan_at(0.1 * k));
  }
  feed.end();
  feed.next();
  const auto fed = feed.next();
  ASSERT_TRUE(fed);
  EXPECT_TRUE(fed->by_wheels);
  EXPECT_NEAR(fed->T_previous_robot.x, 2.0, 1e-6);
}

TEST(ScanFeed, OtherLasersArePassedOver) {
  ScanFeed feed;
  feed.add(scan_at(0, 1));
  feed.end();
  EXPECT_FALSE(feed.next());
}

}  // namespace
}  // namespace majak::localize
