// SPDX-License-Identifier: Apache-2.0
#include "majak/io/mcap_log_writer.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "majak/core/angle.hpp"
#include "majak/io/source.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;

// Tests of one program run beside each other.
fs::path scratch(const std::string& name) {
  return fs::temp_directory_path() / (std::to_string(::getpid()) + name);
}

Scan scan_at(int i) {
  Scan scan;
  scan.time = 1'000'000'000 * kSecond + i * kSecond / 10;
  scan.start_angle = radians(-90.0);
  scan.angle_step = radians(1.0);
  scan.max_range = 80;
  scan.T_robot_laser = {0.12, -0.03, 0.2};
  for (int k = 0; k < 181; ++k) scan.ranges.push_back(1.0F + 0.01F * static_cast<float>(k + i));
  scan.ranges[7] = kNoReturn;
  scan.ranges[9] = kInvalidRange;
  return scan;
}

std::vector<Event> round_trip(const std::vector<Event>& events) {
  const fs::path file = scratch("majak_log_writer.mcap");
  McapLogWriter writer(file.string());
  for (const Event& e : events) writer.write(e);
  writer.close();
  std::vector<Event> read;
  const auto source = open_log(file);
  while (auto e = source->next()) read.push_back(std::move(*e));
  fs::remove(file);
  return read;
}

template <class T>
std::vector<T> only(const std::vector<Event>& events) {
  std::vector<T> out;
  for (const Event& e : events)
    if (const auto* t = std::get_if<T>(&e)) out.push_back(*t);
  return out;
}

TEST(McapLogWriter, ScansComeBackAsTheyWere) {
  std::vector<Event> events;
  for (int i = 0; i < 20; ++i) events.push_back(scan_at(i));
  const auto scans = only<Scan>(round_trip(events));
  ASSERT_EQ(scans.size(), 20U);
  for (int i = 0; i < 20; ++i) {
    const Scan &a = scan_at(i), &b = scans[static_cast<std::size_t>(i)];
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.start_angle, b.start_angle);
    EXPECT_EQ(a.angle_step, b.angle_step);
    EXPECT_NEAR(b.T_robot_laser.x, 0.12, 1e-9);
    EXPECT_NEAR(b.T_robot_laser.y, -0.03, 1e-9);
    EXPECT_NEAR(b.T_robot_laser.theta, 0.2, 1e-9);
    ASSERT_EQ(a.ranges.size(), b.ranges.size());
    for (std::size_t k = 0; k < a.ranges.size(); ++k)
      EXPECT_TRUE(a.ranges[k] == b.ranges[k] ||
                  (std::isnan(a.ranges[k]) && std::isnan(b.ranges[k])))
          << k;
  }
}

TEST(McapLogWriter, AnOdometrysOwnRecordsBeatThoseOfTheScans) {
  for (const bool own : {true, false}) {
    std::vector<Event> events;
    for (int i = 0; i < 20; ++i) {
      Scan scan = scan_at(i);
      scan.T_odom_robot = Pose2{0.1 * i, 0.5, 0.3};
      events.push_back(scan);
      if (own) events.push_back(Odometry{scan.time + 1000, {7, 0.1 * i, 0}, 0.5, 0.1});
    }
    const auto odometry = only<Odometry>(round_trip(events));
    ASSERT_EQ(odometry.size(), 20U);
    EXPECT_NEAR(odometry[10].T_odom_robot.x, own ? 7 : 1, 1e-9);
    EXPECT_NEAR(odometry[10].T_odom_robot.theta, own ? 0 : 0.3, 1e-9);
  }
}

TEST(McapLogWriter, SpeedAndSteeringAndTheTruthComeBack) {
  std::vector<Event> events;
  for (int i = 0; i < 20; ++i) {
    const Scan scan = scan_at(i);
    events.push_back(WheelMotion{scan.time, 0.5 - 0.1 * i, 0.25 - 0.03125 * i});
    events.push_back(scan);
    events.push_back(Truth{scan.time, {1.0 * i, -2, 0.1 * i}});
  }
  const auto read = round_trip(events);
  EXPECT_TRUE(only<Odometry>(read).empty());
  const auto wheels = only<WheelMotion>(read);
  const auto truth = only<Truth>(read);
  ASSERT_TRUE(wheels.size() == 20 && truth.size() == 20);
  for (int i = 0; i < 20; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_EQ(wheels[k].time, scan_at(i).time);
    EXPECT_NEAR(wheels[k].speed, 0.5 - 0.1 * i, 1e-6);  // single precision
    EXPECT_EQ(wheels[k].steering, 0.25 - 0.03125 * i);
    EXPECT_EQ(truth[k].time, scan_at(i).time);
    EXPECT_NEAR(log(between(truth[k].T_world_robot, {1.0 * i, -2, 0.1 * i})).norm(), 0, 1e-12);
  }
}

// Beside odometry a drive message is what the car is told.
TEST(McapLogWriter, DriveMessagesBesideOdometryAreNoMeasurement) {
  std::vector<Event> events;
  for (int i = 0; i < 20; ++i) {
    const Scan scan = scan_at(i);
    events.push_back(Odometry{scan.time, {0.1 * i, 0, 0}, 1.0, 0.0});
    events.push_back(WheelMotion{scan.time, 1, 0.2});
    events.push_back(scan);
  }
  const auto read = round_trip(events);
  EXPECT_EQ(only<Odometry>(read).size(), 20U);
  EXPECT_TRUE(only<WheelMotion>(read).empty());
}

// In the frame in which they were, not in that of the first one.
TEST(McapLogWriter, FixesComeBackWhereTheyWere) {
  std::vector<Event> events;
  for (int i = 0; i < 20; ++i) {
    const Scan scan = scan_at(i);
    events.push_back(GpsFix{scan.time, 70.5 * i - 300, 30 - 91.25 * i, i < 10 ? 0.0 : 0.25 * i});
    events.push_back(scan);
  }
  const auto fixes = only<GpsFix>(round_trip(events));
  ASSERT_EQ(fixes.size(), 20U);
  for (int i = 0; i < 20; ++i) {
    const GpsFix& fix = fixes[static_cast<std::size_t>(i)];
    EXPECT_EQ(fix.time, scan_at(i).time);
    EXPECT_NEAR(fix.east, 70.5 * i - 300, 1e-7);
    EXPECT_NEAR(fix.north, 30 - 91.25 * i, 1e-7);
    EXPECT_NEAR(fix.sigma, i < 10 ? 0.0 : 0.25 * i, 1e-12);
  }
}

TEST(McapLogWriter, WhatHasNoMessageIsCounted) {
  const fs::path file = scratch("majak_log_writer_count.mcap");
  McapLogWriter writer(file.string());
  writer.write(scan_at(0));
  writer.write(BeaconSighting{});
  writer.write(BeaconSighting{});
  writer.close();
  ASSERT_EQ(writer.report().entries().size(), 1U);
  EXPECT_EQ(writer.report().entries().begin()->second.count, 2);
  fs::remove(file);
}

}  // namespace
}  // namespace majak::io
