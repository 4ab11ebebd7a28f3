// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::io::ros {
namespace {

std::string bytes_of(std::string_view hex) {
  std::string bytes;
  int digits = 0, value = 0;
  for (const char c : hex) {
    if (c == ' ' || c == '\n') continue;
    value = value * 16 + (c <= '9' ? c - '0' : c - 'a' + 10);
    if (++digits % 2 == 0) {
      bytes.push_back(static_cast<char>(value));
      value = 0;
    }
  }
  return bytes;
}

LaserScan some_scan(std::size_t beams, std::string frame) {
  RandomStream random(beams);
  LaserScan m;
  m.header = {7, 1'500'000'000 * kSecond + 123'456'789, std::move(frame)};
  m.angle_min = -1.5F, m.angle_max = 1.5F, m.angle_increment = 0.25F;
  m.time_increment = 1e-5F, m.scan_time = 0.1F, m.range_min = 0.1F, m.range_max = 30;
  for (std::size_t i = 0; i < beams; ++i) {
    m.ranges.push_back(static_cast<float>(random.uniform(0, 30)));
    m.intensities.push_back(static_cast<float>(i));
  }
  if (beams > 2) m.ranges[1] = std::numeric_limits<float>::infinity();
  return m;
}

Odometry some_odometry(std::string child) {
  Odometry m;
  m.header = {1, 12 * kSecond + 5, "odom"};
  m.child_frame = std::move(child);
  m.pose = {{1, 2, 3}, {0, 0, 0.6, 0.8}};
  for (std::size_t i = 0; i < 36; ++i) m.pose_covariance[i] = static_cast<double>(i);
  m.linear = {0.5, 0, 0}, m.angular = {0, 0, -0.25};
  m.twist_covariance[35] = 9;
  return m;
}

TransformList some_transforms() {
  TransformList m;
  const char* const names[] = {"laser", "a", "lidar_link"};
  m.transforms.resize(std::size(names));
  for (std::size_t i = 0; i < std::size(names); ++i) {
    StampedTransform& t = m.transforms[i];
    t.header.sequence = 2, t.header.stamp = 3 * kSecond, t.header.frame = "base_link";
    t.child_frame = names[i];
    t.transform = {{0.1, 0.2, 0.3}, {1, 0, 0, 0}};
  }
  return m;
}

TransformList one_transform(Time stamp, const char* child, double x) {
  TransformList m;
  m.transforms.resize(1);
  m.transforms[0].header.stamp = stamp;
  m.transforms[0].header.frame = "turtle1";
  m.transforms[0].child_frame = child;
  m.transforms[0].transform.translation[0] = x;
  return m;
}

NavSatFix some_fix() {
  NavSatFix m;
  m.header = {4, -5 * kSecond + 250, "gps"};
  m.status = -1, m.service = 0x0102, m.latitude = 47.5, m.longitude = -8.25, m.altitude = 432.1;
  m.covariance[8] = 4, m.covariance_type = 2;
  return m;
}

/// The same CDR with the other byte order: every aligned number turned round. The layout is given
/// as the sizes of the numbers; 0 is a string.
std::string turned_round(const std::string& cdr, const std::vector<std::size_t>& sizes) {
  std::string out = cdr;
  out[1] = 0;
  std::size_t at = 4;
  const auto turn = [&](std::size_t size) {
    while ((at - 4) % size != 0) ++at;
    for (std::size_t i = 0; i < size; ++i) out[at + i] = cdr[at + size - 1 - i];
    at += size;
  };
  for (const std::size_t size : sizes) {
    if (size > 0) {
      turn(size);
      continue;
    }
    while ((at - 4) % 4 != 0) ++at;
    std::uint32_t length = 0;
    std::memcpy(&length, cdr.data() + at, 4);
    turn(4);
    at += length;
  }
  return out;
}

template <class M>
void expect_same_bytes_again(const M& message, Encoding encoding) {
  const std::string bytes = encode(message, encoding);
  M again;
  decode(bytes, encoding, again);
  EXPECT_EQ(encode(again, encoding), bytes);
  // Every number of the other encoding is there as well, but for the sequence number.
  M other;
  decode(encode(again, Encoding::cdr), Encoding::cdr, other);
  EXPECT_EQ(encode(other), encode(message));
  // Cut anywhere, it is an error and nothing else.
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THROW(decode(std::string_view(bytes).substr(0, size), encoding, again), Error) << size;
  EXPECT_NO_THROW(decode(bytes + "xyz", encoding, again));
}

TEST(RosMessages, WhatIsWrittenIsRead) {
  for (const Encoding encoding : {Encoding::ros1, Encoding::cdr}) {
    // Frames of all lengths move what follows over every alignment.
    for (const char* frame : {"", "a", "ab", "abc", "abcd", "abcde", "abcdef", "abcdefg"}) {
      expect_same_bytes_again(some_scan(5, frame), encoding);
      expect_same_bytes_again(some_scan(0, frame), encoding);
      expect_same_bytes_again(some_odometry(frame), encoding);
    }
    expect_same_bytes_again(some_transforms(), encoding);
  }
  expect_same_bytes_again(some_fix(), Encoding::cdr);
}

TEST(RosMessages, KeepsEveryField) {
  for (const Encoding encoding : {Encoding::ros1, Encoding::cdr}) {
    LaserScan scan;
    decode(encode(some_scan(3, "laser"), encoding), encoding, scan);
    EXPECT_EQ(scan.header.stamp, 1'500'000'000 * kSecond + 123'456'789);
    EXPECT_EQ(scan.header.sequence, encoding == Encoding::ros1 ? 7U : 0U);
    EXPECT_EQ(scan.header.frame, "laser");
    EXPECT_EQ(scan.angle_min, -1.5F);
    EXPECT_EQ(scan.angle_max, 1.5F);
    EXPECT_EQ(scan.angle_increment, 0.25F);
    EXPECT_EQ(scan.time_increment, 1e-5F);
    EXPECT_EQ(scan.scan_time, 0.1F);
    EXPECT_EQ(scan.range_min, 0.1F);
    EXPECT_EQ(scan.range_max, 30);
    EXPECT_EQ(scan.ranges, some_scan(3, "").ranges);
    EXPECT_EQ(scan.intensities, (std::vector<float>{0, 1, 2}));

    Odometry odometry;
    decode(encode(some_odometry("base"), encoding), encoding, odometry);
    EXPECT_EQ(odometry.child_frame, "base");
    EXPECT_EQ(odometry.pose.translation, (std::array<double, 3>{1, 2, 3}));
    EXPECT_EQ(odometry.pose.rotation, (std::array<double, 4>{0, 0, 0.6, 0.8}));
    EXPECT_EQ(odometry.pose_covariance[35], 35);
    EXPECT_EQ(odometry.linear[0], 0.5);
    EXPECT_EQ(odometry.angular[2], -0.25);
    EXPECT_EQ(odometry.twist_covariance[35], 9);
  }
  NavSatFix fix;
  decode(encode(some_fix()), Encoding::cdr, fix);
  EXPECT_EQ(fix.header.stamp, -5 * kSecond + 250);
  EXPECT_EQ(fix.status, -1);
  EXPECT_EQ(fix.service, 0x0102);
  EXPECT_EQ(fix.latitude, 47.5);
  EXPECT_EQ(fix.longitude, -8.25);
  EXPECT_EQ(fix.altitude, 432.1);
  EXPECT_EQ(fix.covariance[8], 4);
  EXPECT_EQ(fix.covariance_type, 2);
}

TEST(RosMessages, SpeedAndSteering) {
  AckermannDrive drive;
  drive.header = {2, 7 * kSecond + 9, "base"};
  drive.steering = -0.25F, drive.steering_rate = 1, drive.speed = 3.5F, drive.jerk = 2;
  // Sequence, stamp, frame with its length; five numbers of four bytes.
  EXPECT_EQ(encode(drive, Encoding::ros1).size(), 4 + 8 + 4 + 4 + 20U);
  for (const Encoding encoding : {Encoding::ros1, Encoding::cdr}) {
    AckermannDrive again;
    decode(encode(drive, encoding), encoding, again);
    EXPECT_EQ(again.header.stamp, 7 * kSecond + 9);
    EXPECT_EQ(again.steering, -0.25F);
    EXPECT_EQ(again.speed, 3.5F);
    EXPECT_EQ(encode(again, encoding), encode(drive, encoding));
  }
}

TEST(RosMessages, HasTheBytesOfCdr) {
  // One transform turtle1 -> turtle1_ahead at 0: count, stamp, two strings with their NULs, six
  // bytes up to the next eight, seven doubles.
  const TransformList list = one_transform(2 * kSecond + 3, "turtle1_ahead", 3);
  const std::string bytes = encode(list);
  EXPECT_EQ(bytes.size(), 4 + 104U);
  EXPECT_EQ(bytes.substr(0, 52), bytes_of("00010000 01000000 02000000 03000000"
                                          "08000000 747572746c653100"
                                          "0e000000 747572746c65315f616865616400 000000000000"));
  EXPECT_EQ(bytes.substr(52, 8), bytes_of("0000000000000840"));
  EXPECT_EQ(bytes.substr(100, 8), bytes_of("000000000000f03f"));
}

TEST(RosMessages, HasTheBytesOfRos1) {
  LaserScan scan;
  scan.header = {1, 2 * kSecond + 3, "l"};
  scan.angle_min = 1;
  scan.ranges = {2};
  EXPECT_EQ(encode(scan, Encoding::ros1),
            bytes_of("01000000 02000000 03000000 01000000 6c 0000803f"
                     "00000000 00000000 00000000 00000000 00000000 00000000"
                     "01000000 00000040 00000000"));
  // A transform of the recording that is known to take 92 bytes.
  const TransformList list = one_transform(0, "turtle2", 0);
  EXPECT_EQ(encode(list, Encoding::ros1).size(), 4 + 12 + 4 + 7 + 4 + 7 + 56U);
  NavSatFix fix;
  EXPECT_EQ(encode(fix, Encoding::ros1).size(), 16 + 3 + 24 + 72 + 1U);
}

TEST(RosMessages, ReadsBothByteOrders) {
  const NavSatFix fix = some_fix();
  std::vector<std::size_t> sizes = {4, 4, 0, 1, 2, 8, 8, 8};
  sizes.insert(sizes.end(), 9, 8);
  sizes.push_back(1);
  NavSatFix again;
  decode(turned_round(encode(fix), sizes), Encoding::cdr, again);
  EXPECT_EQ(encode(again), encode(fix));

  const LaserScan scan = some_scan(4, "laser");
  sizes = {4, 4, 0, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4};
  LaserScan scan_again;
  decode(turned_round(encode(scan), sizes), Encoding::cdr, scan_again);
  EXPECT_EQ(encode(scan_again), encode(scan));
}

TEST(RosMessages, FramesLoseTheirLeadingSlash) {
  TransformList list = some_transforms();
  list.transforms[0].header.frame = "/base_link";
  list.transforms[0].child_frame = "/laser";
  TransformList again;
  decode(encode(list, Encoding::ros1), Encoding::ros1, again);
  EXPECT_EQ(again.transforms[0].header.frame, "base_link");
  EXPECT_EQ(again.transforms[0].child_frame, "laser");
}

TEST(RosMessages, LyingCountsAllocateNothing) {
  LaserScan scan = some_scan(0, "");
  std::string bytes = encode(scan, Encoding::ros1);
  bytes.replace(bytes.size() - 8, 4, "\xff\xff\xff\xff");
  EXPECT_THROW(decode(bytes, Encoding::ros1, scan), Error);
  TransformList list;
  EXPECT_THROW(decode(bytes_of("ffffffff"), Encoding::ros1, list), Error);
  Odometry odometry;
  EXPECT_THROW(decode(std::string(12, '\0') + "\xff\xff\xff\xff", Encoding::ros1, odometry), Error);
}

TEST(RosMessages, OtherKindsOfCdrAreRefused) {
  LaserScan scan;
  std::string bytes = encode(scan);
  for (const char kind : {'\2', '\3', '\6', '\7'}) {
    bytes[1] = kind;
    EXPECT_THROW(decode(bytes, Encoding::cdr, scan), Error);
  }
  bytes[1] = 1;
  EXPECT_NO_THROW(decode(bytes, Encoding::cdr, scan));
  bytes[0] = 1;
  EXPECT_THROW(decode(bytes, Encoding::cdr, scan), Error);
}

TEST(RosMessages, StampsThatDoNotFitAreErrors) {
  NavSatFix fix;
  fix.header.stamp = -kSecond;
  EXPECT_NO_THROW(encode(fix, Encoding::cdr));
  EXPECT_THROW(encode(fix, Encoding::ros1), Error);
  fix.header.stamp = Time{1} << 61;  // year 2043
  EXPECT_THROW(encode(fix, Encoding::cdr), Error);
  EXPECT_NO_THROW(encode(fix, Encoding::ros1));
}

}  // namespace
}  // namespace majak::io::ros
