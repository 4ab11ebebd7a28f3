// SPDX-License-Identifier: Apache-2.0
#include "majak/map/solid_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::map {
namespace {

/// A robot that stands still at a pose for two seconds.
Site standing(const Pose2& pose) {
  Site site;
  for (int i = 0; i < 3; ++i) {
    PosedScan& posed = site.scans.emplace_back();
    posed.scan.time = i * kSecond;
    posed.estimate.T_map_robot = pose;
  }
  return site;
}

/// A robot that drives along x at 1 m/s for ten seconds.
Site driving() {
  Site site;
  for (int i = 0; i <= 20; ++i) {
    PosedScan& posed = site.scans.emplace_back();
    posed.scan.time = i * kSecond / 2;
    posed.estimate.T_map_robot = {0.5 * i, 0, 0};
  }
  return site;
}

Scan scan_at(double seconds, std::vector<float> ranges) {
  Scan scan;
  scan.time = from_seconds(seconds);
  scan.laser = 1;
  scan.start_angle = radians(-static_cast<double>(ranges.size() / 2));
  scan.angle_step = radians(1);
  scan.max_range = 80;
  scan.ranges = std::move(ranges);
  return scan;
}

/// What an upright laser 0.5 m up sees of a ceiling at 2.5 m, 41 beams about the vertical.
Scan ceiling_at(double seconds) {
  Scan scan = scan_at(seconds, std::vector<float>(41));
  for (std::size_t i = 0; i < 41; ++i)
    scan.ranges[i] = static_cast<float>(2.0 / std::cos(scan.angle(i)));
  return scan;
}

TEST(SolidPoints, ABeamEndsWhereMountingAndPoseSay) {
  LaserMounting mounting;
  mounting.x = 0.2, mounting.z = 0.5;
  SolidPoints points(standing({3, 4, kPi / 2}), mounting);
  points.add(scan_at(0.5, {2.0f}));  // straight up
  const SolidCloud cloud = points.cloud();
  ASSERT_EQ(cloud.points.size(), 1u);
  EXPECT_LT((cloud.points[0].mean - Vec3(3, 4.2, 2.5)).norm(), 1e-6);
  EXPECT_LT((cloud.points[0].towards - Vec3(0, 0, -1)).norm(), 1e-6);
  EXPECT_EQ(points.beams(), 1u);
}

TEST(SolidPoints, BeamsAreFiredOneAfterTheOther) {
  SolidPointsOptions still;
  still.mirror_turn = 0;
  SolidPoints turning(driving(), {}), at_once(driving(), {}, still);
  Scan scan = scan_at(1, std::vector<float>(181, kNoReturn));
  scan.ranges[180] = 3;
  turning.add(scan), at_once.add(scan);
  const double moved = turning.cloud().points[0].mean.x() - at_once.cloud().points[0].mean.x();
  EXPECT_NEAR(moved, 0.5 / 75, 1e-6);  // half a turn of the mirror at 1 m/s
}

TEST(SolidPoints, TiltIsThatOfTheBeamsTime) {
  SolidPointsOptions still;
  still.mirror_turn = 0;
  LaserMounting level = looking("level");
  SolidPoints points(standing({}), level, still, TiltTrack({{0, 0.0}, {kSecond, 0.4}}));
  points.add(scan_at(0.5, {2.0f}));
  EXPECT_LT(
      (points.cloud().points[0].mean - Vec3(2 * std::cos(0.2), 0, 0.5 - 2 * std::sin(0.2))).norm(),
      1e-6);
}

TEST(SolidPoints, CubesHoldMeansOfAllTheirReturns) {
  SolidPoints points(standing({}), {});
  Scan scan = scan_at(0.5, {2.01f});
  scan.intensities = {10};
  points.add(scan);
  scan.ranges = {2.03f}, scan.intensities = {30};
  points.add(scan);
  const SolidCloud cloud = points.cloud();
  ASSERT_EQ(cloud.points.size(), 1u);
  EXPECT_NEAR(cloud.points[0].mean.z(), 2.52, 1e-6);
  EXPECT_NEAR(cloud.points[0].variance_z, 1e-4, 1e-7);
  EXPECT_EQ(cloud.points[0].count, 2);
  EXPECT_EQ(cloud.points[0].intensity, 20);
  EXPECT_TRUE(cloud.has_intensity);
}

TEST(SolidPoints, LeavesOutWhatItCannotPlace) {
  SolidPoints points(standing({}), {});
  Scan other = scan_at(0.5, {2});
  other.laser = 0;
  points.add(other);
  points.add(scan_at(0.5, {kNoReturn, kInvalidRange, 0.05f, 25.0f}));
  EXPECT_TRUE(points.report().empty());
  points.add(scan_at(9, {2}));  // the site ends at 2 s
  EXPECT_EQ(points.report().entries().size(), 1u);
  EXPECT_TRUE(points.cloud().points.empty());
  EXPECT_TRUE(points.cloud().triangles.empty());

  SolidPoints far(standing({1e9, 0, 0}), {});
  far.add(scan_at(0.5, {2}));
  EXPECT_EQ(far.report().entries().size(), 1u);
  EXPECT_TRUE(far.cloud().points.empty());
}

TEST(SolidPoints, FindsWhatIsThere) {
  SolidPoints points(driving(), {});
  for (int i = 0; i < 40; ++i) points.add(ceiling_at(0.2 * i));
  const SolidCloud cloud = points.cloud();
  std::map<std::array<std::int32_t, 3>, std::int64_t> slow;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    slow[cloud.points[i].cell] = static_cast<std::int64_t>(i);
  ASSERT_EQ(slow.size(), cloud.points.size());
  for (const SolidPoint& p : cloud.points)
    for (int d = -1; d <= 1; ++d) {
      const std::array<std::int32_t, 3> cell{p.cell[0], p.cell[1] + d, p.cell[2] - d};
      const auto found = slow.find(cell);
      EXPECT_EQ(cloud.find(cell), found == slow.end() ? -1 : found->second);
    }
  EXPECT_EQ(cloud.find({1 << 21, 0, 0}), -1);
}

TEST(SolidPoints, NormalsOfACeilingLookDown) {
  SolidPoints points(driving(), {});
  for (int i = 0; i < 90; ++i) points.add(ceiling_at(0.1 * i));
  int with = 0;
  const SolidCloud cloud = points.cloud();
  for (const SolidPoint& p : cloud.points) {
    if (p.normal.isZero()) continue;
    ++with;
    EXPECT_LT((p.normal - Vec3(0, 0, -1)).norm(), 1e-4);
  }
  EXPECT_GT(with, 0.9 * static_cast<double>(cloud.points.size()));
}

TEST(SolidPoints, TrianglesShareEdgesByTwoAndFaceTheLaser) {
  SolidPoints points(driving(), {});
  for (int i = 0; i < 90; ++i) points.add(ceiling_at(0.1 * i));
  const SolidCloud cloud = points.cloud();
  ASSERT_GT(cloud.triangles.size(), cloud.points.size());
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : cloud.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      ++edges[{std::min(a, b), std::max(a, b)}];
    }
    const Vec3& p = cloud.points[t[0]].mean;
    EXPECT_LT((cloud.points[t[1]].mean - p).cross(cloud.points[t[2]].mean - p).z(), 0);
  }
  for (const auto& [edge, n] : edges) EXPECT_LE(n, 2);
}

TEST(SolidPoints, ThingsFarApartAreNotJoined) {
  SolidPointsOptions options;
  options.max_edge = 0.5;
  SolidPoints points(driving(), {}, options);
  for (int i = 0; i < 40; ++i) {
    Scan scan = ceiling_at(0.1 * i);
    for (std::size_t k = 0; k < 20; ++k) scan.ranges[k] *= 0.5f;
    points.add(scan);
  }
  const SolidCloud cloud = points.cloud();
  ASSERT_GT(cloud.triangles.size(), 0u);
  for (const auto& t : cloud.triangles)
    for (int k = 0; k < 3; ++k)
      EXPECT_LT(std::abs(cloud.points[t[k]].mean.z() - cloud.points[t[(k + 1) % 3]].mean.z()), 0.5);
}

TEST(SolidPoints, MemoryFollowsThePlaceAndNotTheLog) {
  SolidPoints once(standing({}), {}), often(standing({}), {});
  once.add(ceiling_at(0.5)), once.add(ceiling_at(0.6));
  for (int i = 0; i < 100; ++i) often.add(ceiling_at(0.5 + 0.01 * i));
  EXPECT_EQ(once.cloud().points.size(), often.cloud().points.size());
  EXPECT_EQ(once.cloud().triangles.size(), often.cloud().triangles.size());
}

TEST(SolidPoints, OptionsOutOfRangeAreRefused) {
  SolidPointsOptions bad;
  bad.voxel = 0;
  EXPECT_THROW(SolidPoints(Site{}, {}, bad), Error);
  bad = {};
  bad.max_range = bad.min_range;
  EXPECT_THROW(SolidPoints(Site{}, {}, bad), Error);
}

}  // namespace
}  // namespace majak::map
