// SPDX-License-Identifier: Apache-2.0
#include "majak/io/victoria_park.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "log_fixtures.hpp"

namespace majak::io {
namespace {

using testing::Read;

std::string scan_text(double time, const std::string& range = "5.00", int beams = 361) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", time);
  std::string scan = text;
  for (int i = 0; i < beams; ++i) scan += "\t" + range;
  return scan;
}

Read read_park(const std::string& laser, const std::string& drive = "", const std::string& gps = "",
               const char* order = nullptr) {
  VictoriaPark::Files files;
  files.laser = open_bytes_in_memory(laser).bytes;
  files.drive = open_bytes_in_memory(drive).bytes;
  files.gps = open_bytes_in_memory(gps).bytes;
  if (order != nullptr) files.order = open_bytes_in_memory(order).bytes;
  VictoriaPark park(std::move(files));
  return testing::read_all(park);
}

TEST(VictoriaPark, ScansStandInARowWithoutLineEnds) {
  const Read read = read_park(scan_text(0.852, "79.89") + "\t" + scan_text(1.065, "81.91"));
  const auto scans = read.all<Scan>();
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[0].time, 852000000);
  EXPECT_EQ(scans[0].ranges.size(), 361u);
  EXPECT_EQ(scans[0].ranges[360], 79.89f);
  EXPECT_EQ(scans[1].ranges[0], kNoReturn);
  EXPECT_NEAR(degrees(scans[0].start_angle), -90, 1e-9);
  EXPECT_NEAR(degrees(scans[0].angle(360)), 90, 1e-9);
  EXPECT_EQ(scans[0].T_robot_laser, (Pose2{3.78, 0.5, 0}));
  EXPECT_TRUE(read.report.empty());
}

TEST(VictoriaPark, TheSpeedIsThatOfTheAxle) {
  const auto motion =
      read_park("", "0.973\t 2.000\t 0.0000\r\n0.998\t 2.000\t 0.5\r\n").all<WheelMotion>();
  ASSERT_EQ(motion.size(), 2u);
  EXPECT_EQ(motion[0].speed, 2.0);
  EXPECT_EQ(motion[1].time, 998000000);
  EXPECT_EQ(motion[1].steering, 0.5);
  // Law: the wheel runs on a circle that is H nearer to the centre of turning.
  const double radius = 2.83 / std::tan(0.5);
  EXPECT_NEAR(motion[1].speed / 2.0, radius / (radius - 0.76), 1e-12);
}

TEST(VictoriaPark, GpsRowsAreNorthThenEast) {
  const auto fixes = read_park("", "", "1.001\t  0.05\t -0.08\r\n").all<GpsFix>();
  ASSERT_EQ(fixes.size(), 1u);
  EXPECT_EQ(fixes[0].north, 0.05);
  EXPECT_EQ(fixes[0].east, -0.08);
}

std::string kinds(const Read& read) {
  std::string order;
  for (const Event& event : read.events) order += "SOWGT"[event.index()];
  return order;
}

TEST(VictoriaPark, WithoutAnOrderRecordsAreMergedByTime) {
  const Read read =
      read_park(scan_text(2) + "\t" + scan_text(4), "1 0 0\n3 0 0\n", "0 0 0\n5 0 0\n");
  EXPECT_EQ(kinds(read), "GWSWSG");
}

TEST(VictoriaPark, TheOrderFileDecides) {
  const Read read = read_park(scan_text(2) + "\t" + scan_text(4), "1 0 0\n3 0 0\n",
                              "0 0 0\n5 0 0\n", "2 3 1\n1 2 1\n3 2 2\n0 1 1\n4 3 2\n5 1 2\n");
  EXPECT_EQ(kinds(read), "SWWGSG");
}

TEST(VictoriaPark, WhatTheOrderForgetsComesByTimeAndWhatItInventsIsPassedOver) {
  const Read read = read_park(scan_text(2), "1 0 0\n3 0 0\n", "", "2 3 1\n9 3 2\n9 7 1\nx y z\n");
  EXPECT_EQ(kinds(read), "SWW");
  EXPECT_EQ(read.noticed("name no sensor"), 2);
}

TEST(VictoriaPark, ALostRangeCostsNoMoreThanItsNeighbours) {
  std::string laser;
  for (int i = 0; i < 10; ++i) laser += scan_text(100 + 0.2 * i, "5.00", i == 4 ? 360 : 361) + "\t";
  const Read read = read_park(laser);
  const auto scans = read.all<Scan>();
  EXPECT_EQ(scans.size(), 9u);
  EXPECT_EQ(scans.back().time, 101800000000);
  EXPECT_EQ(scans.back().ranges[360], 5.0f);
  EXPECT_EQ(read.noticed("do not begin with a time"), 1);
}

TEST(VictoriaPark, BadValuesAndRowsAreCounted) {
  std::string laser = scan_text(1);
  laser.replace(laser.find("5.00"), 4, "oops");
  laser.replace(laser.find("5.00"), 4, "-1.0");
  const Read read = read_park(laser, "1 2\n2 0 0\nx y z\n\n3 nan 0\n4 0 0", "1 1\n");
  EXPECT_TRUE(std::isnan(read.all<Scan>()[0].ranges[0]));
  EXPECT_EQ(read.noticed("marked invalid"), 2);
  EXPECT_EQ(read.noticed("DRS.txt"), 3);
  EXPECT_EQ(read.first_line("DRS.txt"), 1);
  EXPECT_EQ(read.all<WheelMotion>().size(), 2u);
  EXPECT_EQ(read.noticed("GPS.txt"), 1);
}

TEST(VictoriaPark, EveryTruncationGivesWholeScans) {
  const std::string laser = scan_text(1) + "\t" + scan_text(2) + "\t";
  for (std::size_t size = 0; size < laser.size(); size += 13) {
    const auto scans = read_park(laser.substr(0, size)).all<Scan>();
    EXPECT_LE(scans.size(), 2u);
    for (const Scan& scan : scans) EXPECT_EQ(scan.ranges.size(), 361u);
  }
  EXPECT_EQ(read_park(laser.substr(0, laser.size() / 2 + 100)).noticed("cut off"), 1);
}

}  // namespace
}  // namespace majak::io
