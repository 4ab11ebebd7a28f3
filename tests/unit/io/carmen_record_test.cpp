// SPDX-License-Identifier: Apache-2.0
#include "majak/io/carmen_record.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace majak::io {
namespace {

using Kind = CarmenRecord::Kind;

CarmenRecord parse(const std::string& line, bool cut_off = false) {
  CarmenRecord record;
  parse_carmen_line(line, cut_off, record);
  return record;
}

TEST(CarmenLine, Odom) {
  const auto r = parse("ODOM 1.5 -2.25 0.5 0.3 -0.1 0.0 976052857.337284 nohost 0.103553");
  ASSERT_EQ(r.kind, Kind::event);
  const auto& o = std::get<Odometry>(r.event);
  EXPECT_EQ(o.time, 976052857337284000);
  EXPECT_EQ(o.T_odom_robot, (Pose2{1.5, -2.25, 0.5}));
  EXPECT_EQ(o.speed, 0.3);
  EXPECT_EQ(o.turn_rate, -0.1);
  EXPECT_EQ(r.logger_time, 103553000);
}

TEST(CarmenLine, OdomWrapsItsAngle) {
  const auto r = parse("ODOM 0 0 4.71238898038469 0 0 0 1 h 1");
  EXPECT_NEAR(std::get<Odometry>(r.event).T_odom_robot.theta, -kPi / 2, 1e-12);
}

TEST(CarmenLine, Flaser) {
  const auto r = parse("FLASER 3 1.00 2.50 81.83 1 2 0.5 0.9 2 0.5 12.25 host 0.25");
  ASSERT_EQ(r.kind, Kind::event);
  const auto& s = std::get<Scan>(r.event);
  EXPECT_EQ(s.laser, 0);
  EXPECT_EQ(s.ranges, (std::vector<float>{1.0f, 2.5f, 81.83f}));
  EXPECT_EQ(s.time, 12250000000);
  EXPECT_EQ(*s.T_odom_robot, (Pose2{0.9, 2, 0.5}));
  EXPECT_EQ(*r.T_odom_laser, (Pose2{1, 2, 0.5}));
  EXPECT_EQ(r.laser, CarmenLaser::located);
  EXPECT_FALSE(r.geometry_stated);
}

TEST(CarmenLine, RlaserIsTheSecondLaser) {
  const auto r = parse("RLASER 2 1 2 0 0 3.14 0 0 0 1 h 1");
  EXPECT_EQ(std::get<Scan>(r.event).laser, 1);
}

TEST(CarmenLine, RawLaser) {
  const auto r = parse(
      "RAWLASER3 0 -1.570796 3.141593 0.017453 81.9 0.01 1 3 1.0 2.0 3.0 3 7 8 9 5.5 host 0.5");
  ASSERT_EQ(r.kind, Kind::event);
  const auto& s = std::get<Scan>(r.event);
  EXPECT_EQ(s.laser, 2);
  EXPECT_EQ(s.intensities, (std::vector<float>{7, 8, 9}));
  EXPECT_EQ(s.max_range, 81.9f);
  EXPECT_FALSE(s.T_odom_robot.has_value());
  EXPECT_EQ(r.laser, CarmenLaser::raw);
  EXPECT_TRUE(r.geometry_stated);
}

std::string robot_laser(const std::string& config, int beams) {
  std::string line = "ROBOTLASER1 " + config + " " + std::to_string(beams);
  for (int i = 0; i < beams; ++i) line += " 2.0";
  return line + " 0 1.2 2.0 0.1 1.0 2.0 0.1 0.5 0.6 0.7 0.8 0.9 99.5 host 1.5";
}

TEST(CarmenLine, RobotLaser) {
  const auto r = parse(robot_laser("0 -1.570796 3.141593 0.008727 81.92 0.01 0", 361));
  ASSERT_EQ(r.kind, Kind::event) << r.problem;
  const auto& s = std::get<Scan>(r.event);
  EXPECT_EQ(s.ranges.size(), 361u);
  EXPECT_EQ(s.time, 99500000000);
  EXPECT_EQ(*s.T_odom_robot, (Pose2{1, 2, 0.1}));
  EXPECT_EQ(*r.T_odom_laser, (Pose2{1.2, 2, 0.1}));
  EXPECT_DOUBLE_EQ(s.angle_step, radians(0.5)) << "six decimals are unrounded";
  EXPECT_DOUBLE_EQ(s.start_angle, -kPi / 2);
}

TEST(CarmenLine, AStepThatContradictsTheFieldOfViewGivesWay) {
  const auto wrong = parse(robot_laser("0 -1.570796 3.141593 0.017453 80 0.01 0", 361));
  EXPECT_NEAR(std::get<Scan>(wrong.event).angle_step, radians(0.5), 1e-9);
  const auto missing = parse(robot_laser("0 -1.570796 3.141593 0 80 0.01 0", 181));
  EXPECT_NEAR(std::get<Scan>(missing.event).angle_step, radians(1.0), 1e-9);
  const auto nothing = parse(robot_laser("0 -1.570796 0 0 80 0.01 0", 181));
  EXPECT_NEAR(std::get<Scan>(nothing.event).angle_step, radians(1.0), 1e-9);
}

TEST(CarmenLine, A180BeamLaserOfAHalfCircleKeepsItsStep) {
  const auto r = parse(robot_laser("0 -1.570796 3.141593 0.017453 80 0.01 0", 180));
  EXPECT_DOUBLE_EQ(std::get<Scan>(r.event).angle_step, radians(1.0));
}

TEST(CarmenLine, AHokuyoStepIsUnrounded) {
  const auto r = parse(robot_laser("2 -2.094395 4.188790 0.006136 5.6 0.01 0", 683));
  EXPECT_DOUBLE_EQ(std::get<Scan>(r.event).angle_step, 2 * kPi / 1024);
}

TEST(CarmenLine, OldRawLaser) {
  const auto r = parse("LASER4 2 1 2 7.5 host 0.5");
  ASSERT_EQ(r.kind, Kind::event);
  EXPECT_EQ(std::get<Scan>(r.event).laser, 3);
  EXPECT_EQ(std::get<Scan>(r.event).time, 7500000000);
}

TEST(CarmenLine, Truepos) {
  const auto r = parse("TRUEPOS 1 2 0.5 3 4 0.6 8.5 host 0.5");
  ASSERT_EQ(r.kind, Kind::event);
  EXPECT_EQ(std::get<Truth>(r.event).T_world_robot, (Pose2{1, 2, 0.5}));
  EXPECT_EQ(std::get<Truth>(r.event).time, 8500000000);
}

TEST(CarmenLine, NmeaGga) {
  const auto r =
      parse("NMEAGGA 1 120000.0 4800.6000 N 00751.0000 W 1 8 1.2 0 250.5 0 0 0 9.5 host 0.5");
  ASSERT_EQ(r.kind, Kind::event) << r.problem;
  EXPECT_NEAR(r.latitude, 48.01, 1e-9);
  EXPECT_NEAR(r.longitude, -7.85, 1e-9);
  EXPECT_EQ(r.altitude, 250.5);
  EXPECT_EQ(r.fix, CarmenFix::gga);
  EXPECT_EQ(time_of(r.event), 9500000000);
}

TEST(CarmenLine, NmeaRmc) {
  const auto r = parse("NMEARMC 1 A 120000.0 4800.6000 S 00751.0000 E 0 0 0 E 10104 9.5 host 0.5");
  ASSERT_EQ(r.kind, Kind::event) << r.problem;
  EXPECT_NEAR(r.latitude, -48.01, 1e-9);
  EXPECT_EQ(r.fix, CarmenFix::rmc);
}

TEST(CarmenLine, FixesWithoutAFixAreLeftOut) {
  EXPECT_EQ(parse("NMEAGGA 1 0 0 N 0 E 0 0 0 0 0 0 0 0 9.5 host 0.5").kind, Kind::damaged);
  EXPECT_EQ(parse("NMEARMC 1 V 0 0 N 0 E 0 0 0 E 0 9.5 host 0.5").kind, Kind::damaged);
}

TEST(CarmenLine, Param) {
  const std::string line =
      "PARAM robot_frontlaser_offset -0.04 1071078718.462495 merci 1071078718.462494";
  const auto r = parse(line);
  EXPECT_EQ(r.kind, Kind::param);
  EXPECT_EQ(r.name, "robot_frontlaser_offset");
  EXPECT_EQ(r.value, "-0.04");
}

TEST(CarmenLine, WhatIsOfNoUseIsPassedInSilence) {
  for (const char* line : {"", "   ", "# CARMEN Logfile", "SYNC x 1 h 1", "IMU 1 2 3", "SONAR 1 2",
                           "COMMENT hello", "BUMPER 0", "GLOBALPOS 1 2 3 4 5 6 1 h 1"}) {
    EXPECT_EQ(parse(line).kind, Kind::nothing) << line;
  }
}

TEST(CarmenLine, UnknownNamesAreUnknown) {
  for (const char* line :
       {"HELLO 1 2 3", "ROBOTLASER3 0", "RAWLASER6 0", "LASER", "flaser 1", "ODOMX 1"}) {
    EXPECT_EQ(parse(line).kind, Kind::unknown) << line;
  }
}

TEST(CarmenLine, DamageIsNamed) {
  for (const char* line :
       {"ODOM 1 2", "ODOM 1 2 x 0 0 0 1 h 1", "ODOM 1 2 nan 0 0 0 1 h 1", "ODOM 1 2 3 0 0 0",
        "ODOM 1 2 3 0 0 0 nohost", "FLASER", "FLASER x 1 2", "FLASER 0 0 0 0 0 0 0 1 h 1",
        "FLASER -3 1 2 3", "FLASER 99999999999 1 2 3", "FLASER 3 1 2", "FLASER 3 1 2 3",
        "FLASER 2 1 2 0 0 0 0 0 inf 1 h 1", "FLASER 1 1.0 2.0 3.0 4.0 0 0 0 0 0 0 1 h 1",
        "RAWLASER1 0 0", "RAWLASER1 0 0 0 0 0 0 0 2 1 1 9 1 h 1", "TRUEPOS 1 2 3 4 5", "LASER3 2 1",
        // Further away than any place on Earth; beams that begin beyond a full turn.
        "ODOM 3e7 2 3 0 0 0 1 h 1", "FLASER 1 2.0 0 0 0 0 -1e15 0 1 h 1",
        "RAWLASER1 0 1e300 3.14 0.01 80 0 0 1 2.0 0 1 h 1",
        "RAWLASER1 0 -6.3 3.14 0.01 80 0 0 1 2.0 0 1 h 1"}) {
    const auto r = parse(line);
    EXPECT_EQ(r.kind, Kind::damaged) << line;
    ASSERT_NE(r.problem, nullptr) << line;
  }
}

TEST(CarmenLine, BadRangesAreMarkedAndCounted) {
  const auto r = parse("FLASER 7 1.0 nan inf -2.0 0 12x34 0.00 0 0 0 0 0 0 1 h 1");
  ASSERT_EQ(r.kind, Kind::event);
  const auto& ranges = std::get<Scan>(r.event).ranges;
  EXPECT_EQ(ranges[0], 1.0f);
  for (std::size_t i = 1; i < 7; ++i) EXPECT_TRUE(std::isnan(ranges[i])) << i;
  EXPECT_EQ(r.bad_ranges, 4) << "a plain zero is the sensor's own word for no measurement";
}

TEST(CarmenLine, MoreBeamsThanAnyLaserHasAreDamage) {
  const std::string config = "0 -1.570796 3.141593 0.0001 80 0.01 0";
  EXPECT_EQ(parse(robot_laser(config, 32768)).kind, Kind::event);
  const auto r = parse(robot_laser(config, 32769));
  ASSERT_EQ(r.kind, Kind::damaged);
  EXPECT_NE(std::string(r.problem).find("32768 beams"), std::string::npos) << r.problem;
}

TEST(CarmenLine, TheTrailerMayBeShortOrLong) {
  for (const char* trailer :
       {"1.5", "1.5 host", "1.5 host 0.5", "1.5 host 0.5 junk", "1.5 host junk"}) {
    const auto r = parse(std::string("ODOM 1 2 3 0 0 0 ") + trailer);
    EXPECT_EQ(r.kind, Kind::event) << trailer;
    EXPECT_EQ(time_of(r.event), 1500000000) << trailer;
  }
  EXPECT_EQ(parse("ODOM 1 2 3 0 0 0 1.5 h 1 2 3").kind, Kind::damaged);
  EXPECT_EQ(parse("ODOM 1 2 3 0 0 0 1.5 h x 1").kind, Kind::damaged);
}

TEST(CarmenLine, WhereTheFileEndsAStampMayHaveLostDigits) {
  EXPECT_EQ(parse("ODOM 1 2 3 0 0 0 1.5", true).kind, Kind::damaged);
  EXPECT_EQ(parse("ODOM 1 2 3 0 0 0 1.5 ho", true).kind, Kind::damaged);
  EXPECT_EQ(parse("ODOM 1 2 3 0 0 0 1.5 host 0", true).kind, Kind::event);
}

TEST(CarmenLine, ACountThatIsWrongByAFewIsNoticed) {
  for (const int count : {1, 2, 3, 5, 6, 7, 8}) {
    const auto line =
        "FLASER " + std::to_string(count) + " 1.1 1.2 1.3 1.4 0 0 0 0.5 0.6 0.7 99.5 nohost 0.1";
    EXPECT_EQ(parse(line).kind, Kind::damaged) << count;
  }
  EXPECT_EQ(parse("FLASER 4 1.1 1.2 1.3 1.4 0 0 0 0.5 0.6 0.7 99.5 nohost 0.1").kind, Kind::event);
}

TEST(Geometry, ByNumberOfBeams) {
  struct Case {
    std::size_t beams;
    double start, step, last;  // degrees
  };
  for (const Case c : {Case{180, -90, 1, 89},
                       {181, -90, 1, 90},
                       {360, -90, 0.5, 89.5},
                       {361, -90, 0.5, 90},
                       {401, -50, 0.25, 50},
                       {400, -50, 0.25, 49.75},
                       {101, -50, 1, 50},
                       {201, -50, 0.5, 50},
                       {541, -135, 0.5, 135},
                       {1081, -135, 0.25, 135},
                       {91, -90, 2, 90},
                       {1, -90, 0, -90}}) {
    const auto g = geometry_by_count(c.beams);
    EXPECT_NEAR(degrees(g.start_angle), c.start, 1e-9) << c.beams;
    EXPECT_NEAR(degrees(g.angle_step), c.step, 1e-9) << c.beams;
    EXPECT_NEAR(degrees(g.start_angle + g.angle_step * static_cast<double>(c.beams - 1)), c.last,
                1e-9)
        << c.beams;
  }
}

TEST(Geometry, ByStepAgreesWithTheKnownCounts) {
  for (const std::size_t beams : {180u, 181u, 360u, 361u, 400u, 401u, 101u, 201u, 1081u}) {
    const auto known = geometry_by_count(beams), built = geometry_by_step(beams, known.angle_step);
    EXPECT_NEAR(known.start_angle, built.start_angle, 1e-12) << beams;
  }
}

TEST(LooksLikeCarmen, KnowsALogByAnyLine) {
  for (const std::string& text : std::vector<std::string>{
           "FLASER 180 1.0", "junk\nmore junk\nODOM 1 2 3\n", "# CARMEN Logfile\n",
           "PARAM robot_length 1\n", "RAWLASER2 0 1", "# x\n\nROBOTLASER1 0", "NMEAGGA 1"}) {
    EXPECT_TRUE(looks_like_carmen(text)) << text;
  }
  for (const std::string& text :
       std::vector<std::string>{"", "hello", "ODOM\n", "ODOMETER 5", "A FLASER 1", "#ROSBAG V2.0\n",
                                "PARAM", "FLASER x"}) {
    EXPECT_FALSE(looks_like_carmen(text)) << text;
  }
}

}  // namespace
}  // namespace majak::io
