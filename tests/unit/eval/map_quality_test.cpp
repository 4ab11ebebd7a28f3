// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/map_quality.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "majak/core/random.hpp"
#include "majak/eval/point_index.hpp"

namespace majak::eval {
namespace {

/// Range from a point inside the room |x| < 4, |y| < 3 to its wall.
double range_in_room(const Pose2& p, double direction) {
  const double c = std::cos(direction), s = std::sin(direction);
  double range = 1e9;
  if (c > 1e-9) range = std::min(range, (4 - p.x) / c);
  if (c < -1e-9) range = std::min(range, (-4 - p.x) / c);
  if (s > 1e-9) range = std::min(range, (3 - p.y) / s);
  if (s < -1e-9) range = std::min(range, (-3 - p.y) / s);
  return range;
}

/// Two visits of one room, 100 s apart, 30 scans each; `shift` moves the poses of the second one.
Site two_visits(const Pose2& shift, double noise) {
  Site site;
  RandomStream random(1);
  for (int i = 0; i < 60; ++i) {
    const Pose2 truth{random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(-kPi, kPi)};
    PosedScan s;
    s.scan.time = (i < 30 ? i : 100 + i) * kSecond;
    s.scan.start_angle = -kPi / 2;
    s.scan.angle_step = kPi / 180;
    s.scan.max_range = 80;
    for (int b = 0; b < 181; ++b) {
      const double r =
          range_in_room(truth, truth.theta + s.scan.angle(static_cast<std::size_t>(b)));
      s.scan.ranges.push_back(static_cast<float>(r + noise * random.normal()));
    }
    s.scan.ranges[7] = kNoReturn;
    s.scan.ranges[9] = kInvalidRange;
    s.estimate.time = s.scan.time;
    s.estimate.T_map_robot = i < 30 ? truth : shift * truth;
    site.scans.push_back(s);
  }
  return site;
}

TEST(MapQuality, OfExactPosesShowsTheNoiseOfTheSensor) {
  const MapQuality q = measure_map_quality(two_visits({}, 0.01));
  EXPECT_EQ(q.points, 60u * 179u);
  EXPECT_NEAR(q.wall_thickness, 0.01, 0.003);
  EXPECT_EQ(q.doubled_share, 0);
  EXPECT_NEAR(q.revisit.median, 0.007, 0.003);  // median of |normal|: 0.67 sigma
  EXPECT_LT(q.revisit_beyond, 0.001);
  EXPECT_NEAR(q.revisited_share, 0.5, 0.1);  // the second half
}

TEST(MapQuality, FallsWithTheErrorOfThePoses) {
  MapQuality last = measure_map_quality(two_visits({}, 0.01));
  for (const double error : {0.02, 0.04}) {
    const MapQuality q = measure_map_quality(two_visits({error, error, 0}, 0.01));
    EXPECT_GT(q.wall_thickness, last.wall_thickness);
    EXPECT_GT(q.entropy, last.entropy);
    EXPECT_NEAR(q.revisit.median, error, 0.005);
    last = q;
  }
}

TEST(MapQuality, FindsDoubledWalls) {
  const MapQuality q = measure_map_quality(two_visits({0.2, 0.2, 0}, 0.01));
  EXPECT_GT(q.doubled_share, 0.7);
  EXPECT_LT(q.wall_thickness, 0.02);  // each of the two is thin
  EXPECT_GT(q.revisit_beyond, 0.8);
}

TEST(MapQuality, DoesNotTakeTwoSidesOfAWallForDoubled) {
  // The second visit sees the walls from outside, 15 cm behind: mirror the room to the other side.
  Site site = two_visits({}, 0.005);
  for (std::size_t i = 30; i < 60; ++i) {
    PosedScan& s = site.scans[i];
    for (std::size_t b = 0; b < s.scan.ranges.size(); ++b) {
      // A laser far away to the right that looks left onto the wall x = 4 from outside.
      const double y = 0.02 * (static_cast<double>(b) - 90);
      s.scan.ranges[b] = static_cast<float>(std::hypot(5.85, y));
    }
    s.scan.start_angle = -std::atan2(1.8, 5.85);
    s.scan.angle_step = 2 * std::atan2(1.8, 5.85) / 180;
    s.estimate.T_map_robot = {10, 0, kPi};
  }
  EXPECT_LT(measure_map_quality(site).doubled_share, 0.01);
}

TEST(MapQuality, DoesNotChangeWhenTheMapIsTurned) {
  const Site site = two_visits({0.03, 0, 0}, 0.01);
  Site moved = site;
  for (auto& s : moved.scans) s.estimate.T_map_robot = Pose2{30, -12, 0.7} * s.estimate.T_map_robot;
  const MapQuality a = measure_map_quality(site), b = measure_map_quality(moved);
  EXPECT_NEAR(a.wall_thickness, b.wall_thickness, 5e-4);
  EXPECT_NEAR(a.entropy, b.entropy, 0.02);
  EXPECT_NEAR(a.revisit.median, b.revisit.median, 1e-3);
}

TEST(MapQuality, UsesKeyScansOnlyAndSkipsTheLost) {
  Site site = two_visits({}, 0.01);
  for (std::size_t i = 0; i < 10; ++i) site.scans[i].key = true;
  site.scans[3].estimate.health = Health::lost;
  EXPECT_EQ(measure_map_quality(site).points, 9u * 179u);
  EXPECT_EQ(measure_map_quality({}).points, 0u);
}

TEST(PointIndex, AgreesWithBruteForce) {
  RandomStream random(2);
  std::vector<MapPoint> points;
  for (int i = 0; i < 2000; ++i) {
    points.push_back({static_cast<float>(random.uniform(-3, 3)),
                      static_cast<float>(random.uniform(-3, 3)), 0, 0, i});
  }
  const PointIndex index(points, 0.15);
  for (int round = 0; round < 100; ++round) {
    const Vec2 at(random.uniform(-3.5, 3.5), random.uniform(-3.5, 3.5));
    const double radius = random.uniform(0.01, 1.0);
    std::vector<int> fast, slow;
    index.for_each_near(at, radius, [&](const MapPoint& p) { fast.push_back(p.scan); });
    for (const auto& p : points) {
      if (Vec2(p.x - at.x(), p.y - at.y()).squaredNorm() <= radius * radius) slow.push_back(p.scan);
    }
    std::sort(fast.begin(), fast.end());
    EXPECT_EQ(fast, slow);
  }
}

}  // namespace
}  // namespace majak::eval
