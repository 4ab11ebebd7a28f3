// SPDX-License-Identifier: Apache-2.0
#include "majak/map/laser_mounting.hpp"

#include <gtest/gtest.h>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

/// Where a beam points to on the robot.
Vec3 beam(const LaserMounting& mounting, double degrees, double tilt = 0) {
  const double a = radians(degrees);
  return mounting.T_robot_laser(tilt).rotation * Vec3(std::cos(a), std::sin(a), 0);
}
double apart(const Vec3& a, const Vec3& b) { return (a - b).norm(); }

const Vec3 kAhead = Vec3::UnitX(), kLeft = Vec3::UnitY(), kUp = Vec3::UnitZ();

TEST(LaserMounting, UpSweepsFromTheRightOverTheCeilingToTheLeft) {
  const LaserMounting up = looking("up");
  EXPECT_LT(apart(beam(up, 0), kUp), 1e-12);
  EXPECT_LT(apart(beam(up, -90), -kLeft), 1e-12);
  EXPECT_LT(apart(beam(up, 90), kLeft), 1e-12);
  EXPECT_LT(apart(beam(LaserMounting{}, 30), beam(up, 30)), 1e-12);  // the default
}

TEST(LaserMounting, SidewaysSweepsFromTheFloorToTheCeilingOrBack) {
  for (const double side : {1.0, -1.0}) {
    const LaserMounting m = looking(side > 0 ? "left" : "right");
    EXPECT_LT(apart(beam(m, 0), side * kLeft), 1e-12);
    EXPECT_LT(apart(beam(m, -90), -kUp), 1e-12);
    EXPECT_LT(apart(beam(m, 90), kUp), 1e-12);
  }
}

TEST(LaserMounting, DownMeetsTheGroundAhead) {
  const Vec3 middle = beam(looking("down"), 0);
  EXPECT_NEAR(middle.x(), std::cos(radians(20)), 1e-12);
  EXPECT_NEAR(middle.z(), -std::sin(radians(20)), 1e-12);
  EXPECT_LT(apart(beam(looking("down"), 90), kLeft), 1e-12);
  EXPECT_LT(apart(beam(looking("level"), 0), kAhead), 1e-12);
}

TEST(LaserMounting, TiltLowersALevelLaser) {
  EXPECT_LT(apart(beam(looking("level"), 0, radians(20)), beam(looking("down"), 0)), 1e-12);
}

TEST(LaserMounting, KeepsItsPlaceAndNumber) {
  LaserMounting at;
  at.laser = 3, at.x = 1, at.y = 2, at.z = 3;
  const LaserMounting left = looking("left", at);
  EXPECT_EQ(left.laser, 3);
  EXPECT_EQ(left.T_robot_laser().translation, Vec3(1, 2, 3));
  EXPECT_THROW(looking("back"), Error);
}

TEST(Pose3, ProductAndInverseAreThoseOfTheGroup) {
  const Pose3 a{rotation_of(0.3, -0.4, 1.1), {1, 2, 3}}, b{rotation_of(-1, 0.2, 2), {-4, 0, 1}};
  const Vec3 p{0.5, -0.25, 8};
  EXPECT_LT(apart((a * b) * p, a * (b * p)), 1e-12);
  EXPECT_LT(apart(a.inverse() * (a * p), p), 1e-12);
  const Pose2 c{1, -2, 0.7}, d{0.3, 0.4, -2};
  EXPECT_LT(apart((in_space(c) * in_space(d)) * p, in_space(c * d) * p), 1e-12);
  EXPECT_LT(apart(rotation_of(0, 0, kPi / 2) * kAhead, kLeft), 1e-12);
}

TEST(TiltTrack, IsLinearBetweenSamplesAndHeldOutside) {
  const TiltTrack track({{3 * kSecond, 0.3}, {kSecond, 0.1}, {kSecond, 7.0}, {2 * kSecond, -0.1}});
  EXPECT_EQ(track.at(0), 0.1);
  EXPECT_EQ(track.at(kSecond), 0.1);
  EXPECT_NEAR(track.at(kSecond + kSecond / 4), 0.05, 1e-12);
  EXPECT_EQ(track.at(2 * kSecond), -0.1);
  EXPECT_NEAR(track.at(2 * kSecond + kSecond / 2), 0.1, 1e-12);
  EXPECT_EQ(track.at(9 * kSecond), 0.3);
  EXPECT_TRUE(TiltTrack{}.empty());
  EXPECT_EQ(TiltTrack{}.at(5), 0);
}

}  // namespace
}  // namespace majak::map
