// SPDX-License-Identifier: Apache-2.0
#include "majak/io/tum.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <vector>

namespace majak::io {
namespace {

TEST(FormatStamp, HasSixDecimalsOfTheLog) {
  EXPECT_EQ(format_stamp(976052857337530000), "976052857.337530");
  EXPECT_EQ(format_stamp(0), "0.000000");
  EXPECT_EQ(format_stamp(1'000), "0.000001");
  EXPECT_EQ(format_stamp(-1'500'000'000), "-1.500000");
}

TEST(FormatStamp, RoundsToTheNearestMicrosecond) {
  EXPECT_EQ(format_stamp(499), "0.000000");
  EXPECT_EQ(format_stamp(500), "0.000001");
  EXPECT_EQ(format_stamp(-499), "0.000000");
  EXPECT_EQ(format_stamp(-500), "-0.000001");
  EXPECT_EQ(format_stamp(999'999'500), "1.000000");
}

TEST(FormatStamp, HoldsTheEndsOfTime) {
  EXPECT_EQ(format_stamp(std::numeric_limits<Time>::max()), "9223372036.854776");
  EXPECT_EQ(format_stamp(std::numeric_limits<Time>::min()), "-9223372036.854776");
}

PosedScan posed(Time time, const Pose2& pose) {
  PosedScan p;
  p.scan.time = time;
  p.estimate.time = time + 5;  // the scan's stamp counts
  p.estimate.T_map_robot = pose;
  return p;
}

TEST(TumText, WritesALineForEveryScanInTheirOrder) {
  Site site;
  site.scans = {posed(2'000'000'000, {1.5, -2.25, 0}), posed(1'000'000'000, {0, -1e-9, kPi / 2}),
                posed(3, {0, 0, -kPi / 3}), posed(4'000, {1e6, 0, kPi})};
  EXPECT_EQ(tum_text(site),
            "2.000000 1.500000 -2.250000 0 0 0 0.000000000 1.000000000\n"
            "1.000000 0.000000 0.000000 0 0 0 0.707106781 0.707106781\n"
            "0.000000 0.000000 0.000000 0 0 0 -0.500000000 0.866025404\n"
            "0.000004 1000000.000000 0.000000 0 0 0 1.000000000 0.000000000\n");
}

TEST(TumText, OfNoScansIsEmpty) { EXPECT_EQ(tum_text(Site{}), ""); }

TEST(TumText, KeepsTheHeadingToABillionth) {
  for (double theta = -3.14; theta < 3.14; theta += 0.0321) {
    Site site;
    site.scans = {posed(0, {0, 0, theta})};
    double qz = 0, qw = 0;
    ASSERT_EQ(std::sscanf(tum_text(site).c_str(), "%*s %*s %*s 0 0 0 %lf %lf", &qz, &qw), 2);
    EXPECT_NEAR(2 * std::atan2(qz, qw), theta, 2e-9);
  }
}

TEST(EstimatesTum, HasTheEstimatesOwnTimes) {
  const std::vector<Estimate> estimates = {{.time = 2'500'000'000, .T_map_robot = {1, 2, kPi / 2}},
                                           {.time = 1'000, .T_map_robot = {}}};
  EXPECT_EQ(estimates_tum(estimates),
            "2.500000 1.000000 2.000000 0 0 0 0.707106781 0.707106781\n"
            "0.000001 0.000000 0.000000 0 0 0 0.000000000 1.000000000\n");
}

TEST(CovarianceCsv, ReadsRowByRow) {
  Estimate e;
  e.time = kSecond;
  e.covariance << 1, 0.25, 3e-9, 0.25, 2, -0.5, 3e-9, -0.5, 1e-3;
  EXPECT_EQ(covariance_csv({&e, 1}),
            "time,xx,xy,xt,yy,yt,tt,health\n1.000000,1,0.25,3e-09,2,-0.5,0.001,ok\n");
  EXPECT_EQ(covariance_csv({}), "time,xx,xy,xt,yy,yt,tt,health\n");
}

}  // namespace
}  // namespace majak::io
