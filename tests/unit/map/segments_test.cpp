// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segments.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "tests/support/ascii_room.hpp"

namespace majak::map {
namespace {

using fixture::AsciiRoom;

const AsciiRoom& room() {
  static const AsciiRoom room({
      "##########",
      "#........#",
      "#...a....#",
      "#........#",
      "##########",
  });
  return room;
}

/// In the map's frame.
std::vector<Segment> seen(const AsciiRoom& place, const Pose2& pose, const fixture::Laser& laser,
                          const SegmentOptions& options = {}) {
  std::vector<Segment> found = extract_segments(place.scan(pose, laser), options);
  for (Segment& s : found) s = moved(pose, s);
  return found;
}

double wall_distance(const Vec2& p) {  // of the room above, whose floor is (0.5 ... 4.5, 0.5 ... 2)
  return std::min(
      {std::abs(p.x() - 0.5), std::abs(p.x() - 4.5), std::abs(p.y() - 0.5), std::abs(p.y() - 2.0)});
}

TEST(ExtractSegments, OfANoiselessRoomAreItsWalls) {
  const auto found = seen(room(), room().pose('a', 1.9), fixture::all_around(720));
  // The scan begins in a wall, so that this one is in two parts.
  ASSERT_EQ(found.size(), 5U);
  double length = 0;
  for (const Segment& s : found) {
    EXPECT_LT(wall_distance(s.a), 1e-6);
    EXPECT_LT(wall_distance(s.b), 1e-6);
    EXPECT_GT(s.normal().dot(room().place('a') - s.middle()), 0) << "seen from its left";
    length += s.length();
  }
  EXPECT_NEAR(length, 2 * (4.0 + 1.5), 0.03) << "all but what lies between the first and last beam";
}

TEST(ExtractSegments, CornersAreWhereTheyAre) {
  for (const double theta : {0.3, 1.9, 3.3, 4.4}) {
    const auto found = seen(room(), room().pose('a', theta), fixture::all_around());
    int corners = 0;
    for (std::size_t i = 1; i < found.size(); ++i) {
      EXPECT_LT((found[i - 1].b - found[i].a).norm(), 1e-6);
      for (const double x : {0.5, 4.5})
        for (const double y : {0.5, 2.0}) corners += (found[i].a - Vec2(x, y)).norm() < 1e-6;
    }
    EXPECT_GE(corners, 3) << "the first beam may take one";
  }
}

TEST(ExtractSegments, NoneSpansADoor) {
  const AsciiRoom two({
      "##########",
      "#........#",
      "#........#",
      "####..####",
      "#...a....#",
      "##########",
  });
  for (const double theta : {0.0, 1.0, 2.5}) {
    for (const Segment& s : seen(two, two.pose('a', theta), fixture::all_around(720)))
      EXPECT_GT(distance_to(s, Vec2(2.5, 1.0)), 0.45);
  }
}

TEST(ExtractSegments, DoNotHangOnThePose) {
  const fixture::Laser laser = fixture::all_around();
  Scan scan = room().scan(room().pose('a', 0.7), laser);
  const auto plain = extract_segments(scan);
  const Pose2 T{1.5, -2, 2.1};
  scan.T_robot_laser = T;
  const auto turned = extract_segments(scan);
  ASSERT_EQ(plain.size(), turned.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_LT((T * plain[i].a - turned[i].a).norm(), 1e-12);
    EXPECT_LT((T * plain[i].b - turned[i].b).norm(), 1e-12);
    EXPECT_EQ(plain[i].covariance, turned[i].covariance);
    const Eigen::Rotation2Dd turn(T.theta);
    const Eigen::Matrix2d expected =
        turn.toRotationMatrix() * covariance_of_b(plain[i]) * turn.toRotationMatrix().transpose();
    EXPECT_LT((expected - covariance_of_b(turned[i])).norm(), 1e-12);
  }
}

TEST(ExtractSegments, AScanTheOtherWayRoundIsTheSame) {
  Scan scan = room().scan(room().pose('a', 0.7), fixture::all_around());
  const auto left = extract_segments(scan);
  scan.start_angle = scan.angle(scan.ranges.size() - 1);
  scan.angle_step = -scan.angle_step;
  std::reverse(scan.ranges.begin(), scan.ranges.end());
  const auto right = extract_segments(scan);
  ASSERT_EQ(left.size(), right.size());
  for (std::size_t i = 0; i < left.size(); ++i) {
    EXPECT_LT((left[i].a - right[i].a).norm(), 1e-6);
    EXPECT_LT((left[i].b - right[i].b).norm(), 1e-6);
  }
}

Scan wall_scan(int beams = 61) {  // the wall x = 2, 3.5 m wide, from the origin
  Scan scan;
  scan.start_angle = radians(-30);
  scan.angle_step = radians(60) / (beams - 1);
  scan.max_range = 30;
  for (int i = 0; i < beams; ++i)
    scan.ranges.push_back(
        static_cast<float>(2 / std::cos(scan.angle(static_cast<std::size_t>(i)))));
  return scan;
}

TEST(ExtractSegments, ABeamWithoutReturnBreaksAnUnknownOneDoesNot) {
  Scan scan = wall_scan();
  ASSERT_EQ(extract_segments(scan).size(), 1U);
  scan.ranges[30] = kInvalidRange;
  EXPECT_EQ(extract_segments(scan).size(), 1U);
  EXPECT_EQ(extract_segments(scan)[0].points, 60U);
  scan.ranges[30] = kNoReturn;
  EXPECT_EQ(extract_segments(scan).size(), 2U);
}

TEST(ExtractSegments, ShortOnesAndThinOnesAreLeftOut) {
  SegmentOptions options;
  options.min_length = 2.4;  // it is 2.309 m
  EXPECT_TRUE(extract_segments(wall_scan(), options).empty());
  options.min_length = 2.2;
  EXPECT_EQ(extract_segments(wall_scan(), options).size(), 1U);
  options.min_points = 62;
  EXPECT_TRUE(extract_segments(wall_scan(), options).empty());
  EXPECT_TRUE(extract_segments(Scan{}).empty());
}

// NEES of (rho, phi) over 2000 noisy scans of a slanted wall: mean 2, standard error 0.045.
TEST(ExtractSegments, KnowTheErrorsOfTheirLine) {
  constexpr int kTimes = 2000;
  const SegmentOptions options;
  const double phi = 2.6, rho = -3;  // hit at up to 0.54 + 0.5 rad
  double nees = 0;
  Vec2 mean = Vec2::Zero();
  for (int k = 0; k < kTimes; ++k) {
    RandomStream random(7, static_cast<std::uint64_t>(k));
    Scan scan = wall_scan(121);
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double angle = scan.angle(i) + options.bearing_sigma * random.normal();
      scan.ranges[i] =
          static_cast<float>(rho / std::cos(angle - phi) + options.range_sigma * random.normal());
    }
    const auto found = extract_segments(scan, options);
    ASSERT_EQ(found.size(), 1U);
    const Line line = line_of(found[0]);
    const Vec2 error(line.rho - rho, angle_diff(line.phi, phi));
    nees += error.dot(line.covariance.ldlt().solve(error)) / kTimes;
    mean += error / kTimes;
    ASSERT_LT(std::sqrt(line.covariance(1, 1)), 0.002);
  }
  EXPECT_NEAR(nees, 2, 3 * 0.045);
  EXPECT_LT(mean.norm(), 3e-4);
}

// The seen end lies up to one spacing of the beams before the true one.
TEST(ExtractSegments, KnowHowFarTheirEndsFallShort) {
  double sum2 = 0, stated2 = 0;
  constexpr int kTimes = 400;
  for (int k = 0; k < kTimes; ++k) {
    Scan scan = wall_scan();
    scan.start_angle += scan.angle_step * (k + 0.5) / kTimes;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double r = 2 / std::cos(scan.angle(i));
      const bool on = std::abs(r * std::sin(scan.angle(i))) < 1.0;
      scan.ranges[i] = on ? static_cast<float>(r) : kNoReturn;
    }
    const auto found = extract_segments(scan);
    ASSERT_EQ(found.size(), 1U);
    sum2 += std::pow(1.0 - found[0].b.y(), 2) / kTimes;
    stated2 += std::pow(found[0].sigma_b, 2) / kTimes;
    const Eigen::Matrix2d c = covariance_of_b(found[0]);
    EXPECT_NEAR(c(1, 1), std::pow(found[0].sigma_b, 2), 1e-6);  // along y
    EXPECT_GT(c(0, 0), found[0].covariance(0, 0));              // the turn adds to it
  }
  EXPECT_NEAR(std::sqrt(stated2), std::sqrt(sum2), 0.15 * std::sqrt(sum2));
}

TEST(SegmentGeometry, TheLineHasTheEndsAndItsCovarianceTheirs) {
  Segment s{{1, 2}, {3, 5}, Eigen::Matrix2d::Zero(), 0.01, 0.02, 10, 1};
  s.covariance << 1e-4, 2e-5, 2e-5, 3e-5;
  const Line line = line_of(s);
  const Vec2 n(std::cos(line.phi), std::sin(line.phi));
  EXPECT_NEAR(n.dot(s.a), line.rho, 1e-12);
  EXPECT_NEAR(n.dot(s.b), line.rho, 1e-12);
  EXPECT_LT((n - s.normal()).norm(), 1e-12);
  // Numbers for the lever: turn and shift the segment about its middle, look at (rho, phi).
  const double h = 1e-6;
  Segment turned = s;
  const Vec2 half = (s.b - s.a) / 2 + h * Segment::left_of((s.b - s.a) / 2);
  turned.a = s.middle() - half, turned.b = s.middle() + half;
  const double lever = (line_of(turned).rho - line.rho) / h;
  EXPECT_NEAR(line.covariance(0, 1), s.covariance(0, 1) + lever * s.covariance(1, 1), 1e-9);
  EXPECT_NEAR(
      line.covariance(0, 0),
      s.covariance(0, 0) + 2 * lever * s.covariance(0, 1) + lever * lever * s.covariance(1, 1),
      1e-9);
}

TEST(SegmentGeometry, Distance) {
  const Segment s{{0, 0}, {2, 0}, Eigen::Matrix2d::Zero(), 0, 0, 2, 1};
  EXPECT_DOUBLE_EQ(distance_to(s, {1, -3}), 3);
  EXPECT_DOUBLE_EQ(distance_to(s, {5, 4}), 5);
  EXPECT_DOUBLE_EQ(distance_to(s, {-3, 4}), 5);
}

}  // namespace
}  // namespace majak::map
