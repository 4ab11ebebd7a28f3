// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_refinement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "majak/core/random.hpp"
#include "majak/map/segment_ends.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/map/surface_bits.hpp"

namespace majak::map {
namespace {

/// Scans of one wall from (0, 3) to (length, 3), driven by 2 m before it; beams beside it go on to
/// a wall at y = 6.
Site before_a_wall(double length, double noise, std::uint64_t seed = 1) {
  Site site;
  RandomStream random(seed, 0);
  for (double x = -1; x < length + 1; x += 0.2) {
    PosedScan posed;
    posed.scan.start_angle = 0.2;
    posed.scan.angle_step = 0.01;
    posed.scan.max_range = 30;
    posed.estimate.T_map_robot = {x, 1, 0};
    for (double angle = 0.2; angle < kPi - 0.2; angle += 0.01) {
      const double at = x + 2 / std::tan(angle);
      const bool met = at >= 0 && at <= length;
      posed.scan.ranges.push_back(
          static_cast<float>((met ? 2 : 5) / std::sin(angle) + noise * random.normal()));
    }
    site.scans.push_back(posed);
  }
  return site;
}

Segment roughly(const Vec2& a, const Vec2& b) {
  Segment s;
  s.a = a, s.b = b;
  s.covariance << 1e-4, 0, 0, 1e-4;
  s.sigma_a = s.sigma_b = 0.05;
  s.scans = 10;
  return s;
}

/// Seen from below: from right to left.
const Segment& wall_of(const std::vector<Segment>& walls) {
  const Segment* best = &walls.at(0);
  for (const Segment& s : walls)
    if (std::abs(s.middle().y() - 3) < std::abs(best->middle().y() - 3)) best = &s;
  return *best;
}

TEST(Refined, FindsTheLineAndTheEndsAgain) {
  const Site site = before_a_wall(4, 0.01);
  const auto walls = refined(site, {roughly({3.9, 3.02}, {0.12, 2.99})}, SegmentMapOptions{});
  const Segment& wall = wall_of(walls);
  EXPECT_NEAR(wall.a.y(), 3, 0.002);
  EXPECT_NEAR(wall.b.y(), 3, 0.002);
  EXPECT_NEAR(wall.a.x(), 4, 0.01);
  EXPECT_NEAR(wall.b.x(), 0, 0.01);
  EXPECT_LT(std::sqrt(wall.covariance(0, 0)), 0.002);
}

TEST(Refined, FindsWallsThatNobodyToldOf) {
  const auto walls = refined(before_a_wall(4, 0.01), {}, SegmentMapOptions{});
  const Segment& wall = wall_of(walls);
  EXPECT_NEAR(wall.length(), 4, 0.05);
  EXPECT_NEAR(wall.middle().y(), 3, 0.002);
}

TEST(Refined, StatesTheErrorsOfThePoses) {
  Site site = before_a_wall(4, 0.01);
  const Segment known = wall_of(refined(site, {}, SegmentMapOptions{}));
  for (PosedScan& posed : site.scans) posed.estimate.covariance.diagonal() << 4e-4, 9e-4, 0;
  const Segment unsure = wall_of(refined(site, {}, SegmentMapOptions{}));
  EXPECT_NEAR(unsure.covariance(0, 0) - known.covariance(0, 0), 9e-4, 1e-8);
  EXPECT_NEAR(std::pow(unsure.sigma_a, 2) - std::pow(known.sigma_a, 2), 4e-4, 1e-8);
}

TEST(Refined, EmptySitesAndLostScans) {
  EXPECT_TRUE(refined(Site{}, {}, SegmentMapOptions{}).empty());
  Site site = before_a_wall(2, 0);
  for (PosedScan& posed : site.scans) posed.estimate.health = Health::lost;
  EXPECT_TRUE(refined(site, {}, SegmentMapOptions{}).empty());
}

TEST(SharpenEnds, AnEndLiesBetweenTheLastBeamThatMeetsAndTheFirstThatPasses) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const double length = 2 + 0.0137 * static_cast<double>(seed);
    const Site site = before_a_wall(length, 0.01, seed);
    std::vector<Segment> walls = {roughly({length - 0.07, 3}, {0.05, 3})};
    sharpen_ends(site, walls, {});
    EXPECT_LT(std::abs(walls[0].a.x() - length), 2.5 * walls[0].sigma_a);
    EXPECT_LT(std::abs(walls[0].b.x()), 2.5 * walls[0].sigma_b);
    EXPECT_LT(walls[0].sigma_a, 0.01);
  }
}

TEST(SharpenEnds, WithoutABeamThatPassesNothingMoves) {
  const Site site = before_a_wall(8, 0.01);
  std::vector<Segment> walls = {roughly({5, 3}, {3, 3})};
  sharpen_ends(site, walls, {});
  EXPECT_EQ(walls[0].a, Vec2(5, 3));
  EXPECT_EQ(walls[0].b, Vec2(3, 3));
}

TEST(SurfaceBits, HoldTheMomentsOfAllReturns) {
  const Site site = before_a_wall(3, 0.01);
  const SurfaceBits bits(site, build_occupancy_grid(site));
  double n = 0, on_wall = 0, sum = 0, square = 0;
  for (const SurfaceBit& bit : bits.all()) {
    n += bit.returns;
    if (std::abs(bit.mean.y() - 3) > 0.1) continue;
    on_wall += bit.returns, sum += bit.returns * bit.mean.y();
    square += bit.returns * (bit.scatter(1, 1) + std::pow(bit.mean.y() - 3, 2));
  }
  std::size_t returns = 0;
  for (const PosedScan& posed : site.scans) returns += posed.scan.ranges.size();
  EXPECT_LE(n, static_cast<double>(returns));
  EXPECT_GT(n, 0.95 * static_cast<double>(returns)) << "what is beside occupied cells";
  EXPECT_NEAR(sum / on_wall, 3, 0.001);
  EXPECT_NEAR(std::sqrt(square / on_wall), 0.01 * 0.85, 0.0015) << "slanted beams err less across";
}

TEST(SurfaceBits, NearFindsAllThatAreNear) {
  const Site site = before_a_wall(3, 0.01);
  const SurfaceBits bits(site, build_occupancy_grid(site));
  const Vec2 a(0.3, 2.9), b(2.1, 3.2);
  std::vector<int> visits(bits.all().size(), 0);
  bits.near(a, b, 0.1, [&](std::size_t i) { ++visits[i]; });
  Segment way;
  way.a = a, way.b = b;
  for (std::size_t i = 0; i < visits.size(); ++i) {
    EXPECT_LE(visits[i], 1);
    if (distance_to(way, bits.all()[i].mean) <= 0.1) EXPECT_EQ(visits[i], 1);
  }
}

}  // namespace
}  // namespace majak::map
