// SPDX-License-Identifier: Apache-2.0
#include "majak/io/player_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "log_fixtures.hpp"
#include "majak/core/error.hpp"

namespace majak::io {
namespace {

using testing::Read;

Read read(std::string text, const SourceOptions& options = {}) {
  PlayerLog log(open_bytes_in_memory(std::move(text)).bytes, "Player log", options);
  return testing::read_all(log);
}

const std::string kHead =
    "## Player version 2.1.0\n"
    "## File version 0.3.0\n"
    "## Format: \n"
    "\n"
    "1245349407.000 16777343 6665 sync 00 004 001 \n"
    "1245349407.000 16777343 6665 laser 00 004 001 +0.100 +0.020 +0.500 00.156 00.155\n"
    "1245349407.000 16777343 6665 position2d 00 004 001 +0.000 +0.000 +0.000 0.440 0.380\n";
const std::string kScan =
    "1245349407.100 16777343 6665 laser 00 001 001 0001 -1.5708 +1.5708 +0.78540000 8.1920 0005 "
    "1.250  0 8.100  0 8.191  1 0.000  0 3.000  2 \n";

TEST(PlayerLog, ReadsScansOdometryAndTheMounting) {
  const Read r = read(
      kHead + kScan +
      "1245349407.171 16777343 6665 position2d 00 001 001 +00.439 -00.027 -0.101 +00.500 +00.000 "
      "-00.250 0\n");
  ASSERT_EQ(r.events.size(), 2U);
  const Scan scan = r.all<Scan>().at(0);
  EXPECT_EQ(scan.time, 1'245'349'407'100'000'000);
  EXPECT_EQ(scan.start_angle, -1.5708);
  EXPECT_EQ(scan.angle_step, 0.7854);
  EXPECT_EQ(scan.T_robot_laser, (Pose2{0.1, 0.02, 0.5}));
  ASSERT_EQ(scan.ranges.size(), 5U);
  EXPECT_EQ(scan.ranges[0], 1.25F);
  EXPECT_EQ(scan.ranges[1], kNoReturn);
  EXPECT_EQ(scan.ranges[2], kNoReturn);
  EXPECT_TRUE(std::isnan(scan.ranges[3]));
  EXPECT_EQ(scan.ranges[4], 3.0F);
  EXPECT_EQ(scan.intensities, (std::vector<float>{0, 0, 1, 0, 2}));
  EXPECT_FALSE(scan.T_odom_robot);
  const Odometry odometry = r.all<Odometry>().at(0);
  EXPECT_EQ(odometry.T_odom_robot, (Pose2{0.439, -0.027, -0.101}));
  EXPECT_EQ(odometry.speed, 0.5);
  EXPECT_EQ(odometry.turn_rate, -0.25);
  EXPECT_TRUE(r.report.empty());
}

TEST(PlayerLog, ReadsScansWithThePoseBeside) {
  const Read r = read(
      "1.000 1 6665 laser 01 001 002 0001 +1.0 -2.0 +0.5 -0.5 0.5 1.0 80.0 0002 79.0 0 79.95 0\n");
  const Scan scan = r.all<Scan>().at(0);
  EXPECT_EQ(scan.laser, 1);
  EXPECT_EQ(*scan.T_odom_robot, (Pose2{1, -2, 0.5}));
  EXPECT_EQ(scan.ranges, (std::vector<float>{79, kNoReturn}));
  EXPECT_TRUE(scan.intensities.empty());
}

TEST(PlayerLog, ReadsScansWithAnAngleABeam) {
  const std::string head = "1.000 1 6665 laser 00 001 003 0001 5.0 0003 ";
  const Scan scan = read(head + "1.0 -0.1 0 2.0 0.0 0 5.0 0.1 0\n").all<Scan>().at(0);
  EXPECT_EQ(scan.start_angle, -0.1);
  EXPECT_EQ(scan.angle_step, 0.1);
  EXPECT_EQ(scan.ranges, (std::vector<float>{1, 2, kNoReturn}));
  for (const char* beams : {"1 -0.1 0 2 0.0 0 3 0.2 0\n", "1 0.1 0 2 0.0 0 3 -0.1 0\n"})
    EXPECT_EQ(read(head + beams).noticed("not evenly spaced"), 1);
}

TEST(PlayerLog, TheOptionsReplaceWhatTheLogSays) {
  const SourceOptions options{.topic = "", .angle_step = 0.5, .T_robot_laser = Pose2{1, 2, 3}};
  const Scan scan = read(kHead + kScan, options).all<Scan>().at(0);
  EXPECT_EQ(scan.angle_step, radians(0.5));
  EXPECT_EQ(scan.T_robot_laser, (Pose2{1, 2, 3}));
  EXPECT_THROW(read(kScan, {.topic = "/scan"}), Error);
  EXPECT_THROW(read(kScan, {.topic = "", .angle_step = -1}), Error);
}

TEST(PlayerLog, WhatIsDamagedIsCountedAndTheRestRead) {
  for (const char* line :
       {"1.0 1 6665 laser 00 001 001 1 -1 1 0.5 8 3 1 0 2 0\n", "nonsense\n",
        "1.0 1 6665 laser 00 001 001 1 -1 1 0 8 2 1 0 2 0\n",
        "1.0 1 6665 laser 00 001 001 1 -1 1 x 8 2 1 0 2 0\n",
        "1.0 1 6665 laser 00 001 001 1 -1 1 0.5 -8 2 1 0 2 0\n",
        "1.0 1 6665 laser 00 001 001 1 -1 1 0.5 8 99999999999 1 0\n",
        "1.0 1 6665 laser xx 001 001 1\n", "1.0 1 6665 laser\n", "x 1 6665 laser 00 001 001\n",
        "1.0 1 6665 position2d 00 001 001 1 nan 0 0 0 0 0\n",
        "1.0 1 6665 position2d 00 001 001 1 2 3 0 0\n", "1.0 1 6665 laser 00 004 001 1\n",
        "1.0 1 6665 laser 00 001 003 1 8 2 1 0 0 1 inf 0\n"}) {
    const Read r = read(line + kScan);
    EXPECT_EQ(r.noticed("unreadable"), 1) << line;
    EXPECT_EQ(r.first_line("unreadable"), 1) << line;
    EXPECT_EQ(r.events.size(), 1U) << line;
  }
  const Read r = read(kScan + "1.0 1 6665 sonar 00 001 001 1\n" + "1" + kScan.substr(10));
  EXPECT_EQ(r.noticed("other interfaces"), 1);
  EXPECT_EQ(r.noticed("backwards"), 1);
}

TEST(PlayerLog, CutOffAnywhereItGivesWhatWasWhole) {
  const std::string whole = kHead + kScan + kScan;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Read r = read(whole.substr(0, size));
    const std::size_t scans = size >= whole.size()                  ? 2U
                              : size >= kHead.size() + kScan.size() ? 1U
                                                                    : 0U;
    EXPECT_EQ(r.events.size(), scans) << size;
    EXPECT_EQ(r.noticed("unreadable"), 0) << size;
  }
}

TEST(PlayerLog, IsRecognisedByItsContent) {
  EXPECT_TRUE(looks_like_player(kHead));
  EXPECT_TRUE(looks_like_player("junk\n" + kScan));
  EXPECT_FALSE(looks_like_player("FLASER 2 1.00 2.00 0 0 0 0 0 0 1.5 host 0.5\n"));
  EXPECT_FALSE(looks_like_player("1.0 2.0 3.0 4.0\n1 2 3"));
  EXPECT_FALSE(looks_like_player(""));
  const auto path = std::filesystem::path(::testing::TempDir()) / "majak_player.log";
  std::ofstream(path) << testing::gzip(kHead + kScan);
  EXPECT_EQ(open_log(path)->format(), "Player log, gzip");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace majak::io
