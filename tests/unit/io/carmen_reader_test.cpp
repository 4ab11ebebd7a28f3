// SPDX-License-Identifier: Apache-2.0
#include "majak/io/carmen_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "log_fixtures.hpp"

namespace majak::io {
namespace {

using testing::Read;
using testing::read_carmen;

std::string odom(double x, double stamp, double tv = 0) {
  char line[200];
  std::snprintf(line, sizeof line, "ODOM %.3f 0 0 %.2f 0 0 %.6f host %.6f\n", x, tv, stamp,
                stamp - 100);
  return line;
}

/// A scan of three beams by a robot at (x, 0, theta); the laser `ahead` of it.
std::string flaser(double x, double stamp, double ahead = 0, double theta = 0,
                   const char* name = "FLASER") {
  char line[300];
  std::snprintf(
      line, sizeof line, "%s 3 1.00 2.00 3.00 %.4f %.4f %.4f %.4f 0 %.4f %.6f host %.6f\n", name,
      x + ahead * std::cos(theta), ahead * std::sin(theta), theta, x, theta, stamp, stamp - 100);
  return line;
}

TEST(CarmenReader, KeepsTheOrderOfTheFile) {
  const Read read = read_carmen(odom(0, 100) + flaser(0, 100.1) +
                                "TRUEPOS 1 2 0 0 0 0 100.2 h 0.2\n" + odom(1, 100.3));
  ASSERT_EQ(read.events.size(), 4u);
  EXPECT_TRUE(std::holds_alternative<Odometry>(read.events[0]));
  EXPECT_TRUE(std::holds_alternative<Scan>(read.events[1]));
  EXPECT_TRUE(std::holds_alternative<Truth>(read.events[2]));
  EXPECT_TRUE(std::holds_alternative<Odometry>(read.events[3]));
  EXPECT_TRUE(read.report.empty());
}

TEST(CarmenReader, ALogLongerThanTheWindowComesOutWhole) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += odom(0.05 * i, 100 + i) + flaser(0.05 * i, 100.5 + i);
  const Read read = read_carmen(text);
  ASSERT_EQ(read.events.size(), 10000u);
  for (std::size_t i = 1; i < read.events.size(); ++i) {
    EXPECT_EQ(time_of(read.events[i]) - time_of(read.events[i - 1]), kSecond / 2);
  }
}

TEST(CarmenReader, StampsThatRunBackwardsAreKeptAndCounted) {
  const Read read =
      read_carmen(flaser(0, 100) + flaser(0, 99.5) + flaser(0, 99.5) + flaser(0, 101) + odom(0, 5));
  EXPECT_EQ(read.all<Scan>()[1].time, 99500000000);
  EXPECT_EQ(read.noticed("backwards"), 1);
  EXPECT_EQ(read.first_line("backwards"), 2);
}

TEST(CarmenReader, LoggerTimeWhereTheSensorClockStandsStill) {
  for (const char* stamp : {"0", "0.000000", "77.5"}) {
    std::string text;
    for (int i = 0; i < 3; ++i) {
      text +=
          std::string("FLASER 1 1.0 0 0 0 0 0 0 ") + stamp + " host " + std::to_string(i) + ".25\n";
    }
    const Read read = read_carmen(text);
    ASSERT_EQ(read.events.size(), 3u);
    EXPECT_EQ(time_of(read.events[2]), 2250000000);
    EXPECT_EQ(read.noticed("clock stands still"), 3);
  }
}

TEST(CarmenReader, OneRecordKeepsItsStamp) {
  EXPECT_EQ(time_of(read_carmen(flaser(0, 100)).events[0]), 100 * kSecond);
}

TEST(CarmenReader, MountingFromTheTwoPoses) {
  std::string text;
  for (int i = 0; i < 300; ++i) text += flaser(0.1 * i, 100 + i, -0.04, 0.01 * i);
  for (const Scan& scan : read_carmen(text).all<Scan>())
    EXPECT_EQ(scan.T_robot_laser, (Pose2{-0.04, 0, 0}));
}

TEST(CarmenReader, PosesOfACorrectedLogAreNoMounting) {
  std::string text = "PARAM robot_frontlaser_offset 0.25 h 0\n";
  for (int i = 0; i < 300; ++i) text += flaser(0.1 * i, 100 + i, 0.002 * i);
  for (const Scan& scan : read_carmen(text).all<Scan>())
    EXPECT_EQ(scan.T_robot_laser, (Pose2{0.25, 0, 0}));
}

TEST(CarmenReader, MountingFromTheParameterWhereThePosesAreTheSame) {
  const Read read = read_carmen(
      "PARAM robot_frontlaser_offset 0.11 h 0\nPARAM robot_frontlaser_side_offset 0.02\n" +
      flaser(0, 100));
  EXPECT_EQ(read.all<Scan>()[0].T_robot_laser, (Pose2{0.11, 0.02, 0}));
}

TEST(CarmenReader, ARearLaserLooksBackwards) {
  for (const char* offset : {"0.2", "-0.2"}) {
    const Read read = read_carmen(std::string("PARAM robot_rearlaser_offset ") + offset + " h 0\n" +
                                  flaser(0, 100, 0, 0, "RLASER"));
    const Scan scan = read.all<Scan>()[0];
    EXPECT_EQ(scan.laser, 1);
    EXPECT_EQ(scan.T_robot_laser, (Pose2{-0.2, 0, kPi}));
  }
  const Read stated = read_carmen("RLASER 1 2.0 -0.3 0 3.141593 0 0 0 100 h 0\n");
  EXPECT_EQ(stated.all<Scan>()[0].T_robot_laser, (Pose2{-0.3, 0, kPi}));
}

TEST(CarmenReader, NoReturnCodesOfOldSickLasers) {
  for (const char* code : {"79.9", "80.0", "81.83", "81.90", "81.91", "90", "1000"}) {
    const Read read =
        read_carmen(std::string("FLASER 3 1.00 79.50 ") + code + " 0 0 0 0 0 0 1 h 1\n");
    const auto ranges = read.all<Scan>()[0].ranges;
    EXPECT_EQ(ranges[2], kNoReturn) << code;
    EXPECT_EQ(ranges[1], 79.5f) << code;
  }
}

TEST(CarmenReader, TheParameterSaysTheLongestRange) {
  const Read read = read_carmen(
      "PARAM robot_front_laser_max 50.0 h 0\nFLASER 3 1.00 49.99 50.00 0 0 0 0 0 0 1 h 1\n");
  const Scan scan = read.all<Scan>()[0];
  EXPECT_EQ(scan.ranges[1], 49.99f);
  EXPECT_EQ(scan.ranges[2], kNoReturn);
  EXPECT_EQ(scan.max_range, 50.0f);
}

TEST(CarmenReader, AStatedMaximumRangeCountsAlsoInTheMillimetreMode) {
  const std::string config = "RAWLASER1 0 -1.570796 3.141593 1.570796 8.19 0.01 0 3 1.0 ";
  const Read read = read_carmen(config + "7.99 8.18 0 1 h 1\n");
  const Scan scan = read.all<Scan>()[0];
  EXPECT_EQ(scan.max_range, 8.0f);
  EXPECT_EQ(scan.ranges[1], 7.99f);
  EXPECT_EQ(scan.ranges[2], kNoReturn);
}

/// A corridor end that comes nearer, and beams that never come back.
std::string driving_scan(int i, const char* code) {
  char line[400];
  std::snprintf(line, sizeof line, "FLASER 5 1.0%d %s %s %.2f 1.20 %.2f 0 0 %.2f 0 0 %d.5 h %d\n",
                i % 7, code, code, 40 - 0.1 * i, 0.1 * i, 0.1 * i, 100 + i, i);
  return line;
}

TEST(CarmenReader, AnUnknownCodeIsFoundFromTheFirstScanOn) {
  for (const char* code : {"50.00", "47.11", "62.5"}) {
    std::string text;
    for (int i = 0; i < 250; ++i) text += driving_scan(i, code);
    const Read read = read_carmen(text);
    const auto scans = read.all<Scan>();
    EXPECT_EQ(scans.size(), 250u);
    for (const Scan& scan : scans) {
      EXPECT_EQ(scan.ranges[1], kNoReturn);
      EXPECT_TRUE(std::isfinite(scan.ranges[3]));
      EXPECT_NEAR(scan.max_range, std::atof(code), 0.006);
    }
    EXPECT_EQ(read.noticed("late"), 0);
  }
}

TEST(CarmenReader, ACodeThatAppearsLateIsFoundAndSaid) {
  std::string text;
  for (int i = 0; i < 600; ++i) text += driving_scan(i % 300, i < 300 ? "2.5" : "50.00");
  const Read read = read_carmen(text);
  EXPECT_EQ(read.all<Scan>().back().ranges[1], kNoReturn);
  EXPECT_EQ(read.noticed("late"), 1);
}

TEST(CarmenReader, TheResolutionParameterBeatsTheCount) {
  const auto scan_with = [](const std::string& degrees, int beams) {
    std::string text =
        "PARAM laser_front_laser_resolution " + degrees + " h 0\nFLASER " + std::to_string(beams);
    for (int i = 0; i < beams; ++i) text += " 1.0";
    return read_carmen(text + " 0 0 0 0 0 0 1 h 1\n");
  };
  EXPECT_NEAR(degrees(scan_with("0.5", 180).all<Scan>()[0].start_angle), -45, 1e-9);
  EXPECT_NEAR(degrees(scan_with("0.5", 360).all<Scan>()[0].start_angle), -90, 1e-9);
  EXPECT_NEAR(degrees(scan_with("0.25", 401).all<Scan>()[0].start_angle), -50, 1e-9);
  const Read impossible = scan_with("1.0", 361);
  EXPECT_NEAR(degrees(impossible.all<Scan>()[0].angle_step), 0.5, 1e-9);
  EXPECT_EQ(impossible.noticed("contradicts"), 1);
}

TEST(CarmenReader, BeamCountsMayChange) {
  const Read read = read_carmen(
      "FLASER 2 1 2 0 0 0 0 0 0 1 h 1\nFLASER 1 1 0 0 0 0 0 0 2 h 2\nFLASER 3 1 2 3 0 0 0 0 0 0 3 "
      "h 3\n");
  const auto scans = read.all<Scan>();
  ASSERT_EQ(scans.size(), 3u);
  EXPECT_EQ(scans[1].ranges.size(), 1u);
  EXPECT_EQ(scans[2].ranges.size(), 3u);
}

TEST(CarmenReader, RawMessagesThatRepeatALocatedScanAreLeftOut) {
  const std::string config = " 0 -1.570796 3.141593 1.570796 80 0.01 0 3 1.0 2.0 3.0 0 ";
  const std::string raw = "RAWLASER1" + config + "5.5 h 1\n";
  const std::string located = "ROBOTLASER1" + config + "0 0 0 0 0 0 0 0 0 0 0 5.5 h 1\n";
  const Read read = read_carmen(raw + located + raw + located);
  EXPECT_EQ(read.events.size(), 2u);
  EXPECT_EQ(read.noticed("repeat"), 2);
  EXPECT_EQ(read_carmen(raw + raw).events.size(), 2u);
}

TEST(CarmenReader, VelocitiesThatAreAllZeroWhileTheRobotDrivesSayNothing) {
  std::string moving, standing, stated;
  for (int i = 0; i < 20; ++i) {
    moving += odom(0.1 * i, 100 + i);
    standing += odom(0, 100 + i);
    stated += odom(0.1 * i, 100 + i, i == 5 ? 0.3 : 0.0);
  }
  EXPECT_FALSE(read_carmen(moving).all<Odometry>()[0].speed.has_value());
  EXPECT_EQ(read_carmen(standing).all<Odometry>()[0].speed, 0.0);
  EXPECT_EQ(read_carmen(stated).all<Odometry>()[0].speed, 0.0);
  EXPECT_EQ(read_carmen(stated).all<Odometry>()[5].speed, 0.3);
}

TEST(CarmenReader, FixesAreMetresFromTheFirst) {
  const std::string text =
      "NMEARMC 1 A 0 4800.0000 N 00751.0000 E 0 0 0 E 0 0.5 h 0\n"
      "NMEAGGA 1 0 4800.0000 N 00751.0000 E 1 8 1 0 250 0 0 0 1 h 1\n"
      "NMEAGGA 1 0 4800.1000 N 00751.1000 E 1 8 1 0 250 0 0 0 2 h 2\n";
  const Read read = read_carmen(text);
  const auto fixes = read.all<GpsFix>();
  ASSERT_EQ(fixes.size(), 2u);
  EXPECT_NEAR(fixes[0].east, 0, 1e-9);
  EXPECT_NEAR(fixes[1].north, 185.3, 0.1);
  EXPECT_NEAR(fixes[1].east, 124.3, 0.1);
  EXPECT_EQ(read.noticed("NMEARMC"), 1);
}

TEST(CarmenReader, DamageIsCountedWithItsFirstLine) {
  const Read read = read_carmen("# CARMEN Logfile\n" + flaser(0, 100) + "ODOM 1 2\n" +
                                "what is this\n" + "ODOM 3 x\n" + flaser(0, 101) + "and this\n");
  EXPECT_EQ(read.events.size(), 2u);
  EXPECT_EQ(read.noticed("unreadable number"), 2);
  EXPECT_EQ(read.first_line("unreadable number"), 3);
  EXPECT_EQ(read.noticed("does not know"), 2);
  EXPECT_EQ(read.first_line("does not know"), 4);
}

TEST(CarmenReader, ATruncatedLogGivesItsWholeRecords) {
  const std::string whole = odom(0, 100) + flaser(0, 100.5) + odom(0.5, 101) + flaser(0.5, 101.5);
  const auto reference = read_carmen(whole).events;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto events = read_carmen(whole.substr(0, size)).events;
    ASSERT_LE(events.size(), reference.size());
    for (std::size_t i = 0; i < events.size(); ++i) {
      EXPECT_EQ(time_of(events[i]), time_of(reference[i])) << size;
    }
  }
}

TEST(CarmenReader, PackedLogsAreTheSameLogs) {
  std::string text;
  for (int i = 0; i < 400; ++i) text += odom(0.05 * i, 100 + i) + flaser(0.05 * i, 100.5 + i);
  const auto plain = read_carmen(text).events;
  for (const std::string& packed : {testing::gzip(text), testing::bzip2(text)}) {
    const auto events = read_carmen(packed).events;
    ASSERT_EQ(events.size(), plain.size());
    for (std::size_t i = 0; i < events.size(); ++i)
      EXPECT_EQ(time_of(events[i]), time_of(plain[i]));
  }
}

TEST(CarmenReader, ATruncatedPackedLogIsReadAndSaid) {
  std::string text;
  for (int i = 0; i < 3000; ++i) text += odom(0.001 * (i * i % 977), 100 + i);
  const std::string packed = testing::gzip(text);
  const Read read = read_carmen(packed.substr(0, packed.size() / 2));
  EXPECT_GT(read.events.size(), 500u);
  EXPECT_EQ(read.noticed("ends early"), 1);
}

}  // namespace
}  // namespace majak::io
