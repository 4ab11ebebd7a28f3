// SPDX-License-Identifier: Apache-2.0
#include "majak/map/elevation.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <tuple>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::map {
namespace {

constexpr double kCell = 0.1;

/// Adds a point at (x, y, z), its cube to match; in no order.
void put(SolidCloud& cloud, double x, double y, double z, int count = 4) {
  SolidPoint p;
  p.mean = {x, y, z};
  p.count = count;
  p.variance_z = 1e-4;
  const auto cell = [](double v) { return static_cast<std::int32_t>(std::floor(v / kCell)); };
  p.cell = {cell(x), cell(y), cell(z + kCell / 2)};
  cloud.points.push_back(p);
}

void sort(SolidCloud& cloud) {
  std::stable_sort(cloud.points.begin(), cloud.points.end(),
                   [](const SolidPoint& a, const SolidPoint& b) {
                     return std::tie(a.cell[2], a.cell[1], a.cell[0]) <
                            std::tie(b.cell[2], b.cell[1], b.cell[0]);
                   });
}

/// Ground of 3 x 3 m whose height is f(x, y), seen with noise.
SolidCloud ground(const std::function<double(double, double)>& f, double sigma = 0) {
  SolidCloud cloud;
  RandomStream random(5);
  for (int i = 0; i < 30; ++i)
    for (int k = 0; k < 30; ++k) {
      const double x = (i + 0.5) * kCell, y = (k + 0.5) * kCell;
      put(cloud, x, y, f(x, y) + sigma * random.normal());
    }
  sort(cloud);
  return cloud;
}

TEST(Elevation, ARampHasItsSlopeAndItsDirection) {
  for (const double degrees : {0.0, 3.0, 10.0, 30.0})
    for (const double way : {0.0, 0.7, 2.5}) {
      const double g = std::tan(radians(degrees));
      const Elevation map = build_elevation(
          ground([&](double x, double y) { return g * (x * std::cos(way) + y * std::sin(way)); }),
          {.max_step = 0.2});
      for (int i = 5; i < 25; ++i) {
        const ElevationCell& cell = map.at(i, 12);
        ASSERT_TRUE(cell.slope_known());
        EXPECT_NEAR(cell.slope(), radians(degrees), 1e-9);
        EXPECT_LT((cell.gradient - g * Vec2(std::cos(way), std::sin(way))).norm(), 1e-9);
        EXPECT_EQ(cell.ground, degrees > 15 ? Ground::steep : Ground::passable);
      }
    }
}

TEST(Elevation, SlopesErrAsMuchAsTheySay) {
  const double sigma = 0.01;
  double chi2 = 0;
  int n = 0;
  const Elevation map =
      build_elevation(ground([](double x, double) { return 0.1 * x; }, sigma), {.sigma = sigma});
  for (const ElevationCell& cell : map.cells) {
    const Vec2 off = cell.gradient - Vec2(0.1, 0);
    // Heights err by sigma; the fit counts a cell's own variance on top, sigma^2 / 4 of 4 returns.
    chi2 += off.dot(cell.covariance.inverse() * off) * 1.25, ++n;
  }
  EXPECT_NEAR(chi2 / n, 2, 0.5);  // neighbours share heights
}

TEST(Elevation, StepsThatAreTooHighAreSeenOnBothSides) {
  for (const double height : {0.05, 0.2}) {
    const Elevation map =
        build_elevation(ground([&](double x, double) { return x < 1.5 ? 0 : height; }));
    for (int iy = 0; iy < 30; ++iy) {
      EXPECT_EQ(map.at(14, iy).ground == Ground::step, height > 0.1);
      EXPECT_EQ(map.at(15, iy).ground == Ground::step, height > 0.1);
      EXPECT_EQ(map.at(5, iy).ground, Ground::passable);
      EXPECT_NEAR(map.at(20, iy).height, height, 1e-12);
    }
  }
}

TEST(Elevation, WhatStandsOrHangsIntoTheWayIsAnObstacle) {
  SolidCloud cloud = ground([](double, double) { return 0; });
  for (int k = 1; k < 8; ++k) put(cloud, 0.55, 0.55, k * kCell);  // a post
  put(cloud, 1.55, 1.55, 0.7);                                    // a table's top
  put(cloud, 2.55, 2.55, 2.4);                                    // a ceiling
  sort(cloud);
  const Elevation map = build_elevation(cloud);
  EXPECT_EQ(map.at(5, 5).ground, Ground::obstacle);
  EXPECT_NEAR(map.at(5, 5).top, 0.7, 1e-12);
  EXPECT_EQ(map.at(15, 15).ground, Ground::obstacle);
  EXPECT_NEAR(map.at(15, 15).top, 0.7, 1e-12);
  EXPECT_EQ(map.at(25, 25).ground, Ground::passable);
  EXPECT_EQ(map.at(25, 25).top, 0);
  EXPECT_EQ(map.at(4, 5).ground, Ground::passable);  // beside a post
}

TEST(Elevation, HeightIsTheMeanOfAllReturnsOfTheGround) {
  SolidCloud cloud;
  put(cloud, 0.05, 0.05, 0.04, 3);
  put(cloud, 0.05, 0.05, 0.06, 1);
  const ElevationCell cell = build_elevation(cloud).at(0, 0);
  EXPECT_EQ(cell.count, 4);
  EXPECT_NEAR(cell.height, 0.045, 1e-12);
  EXPECT_NEAR(cell.variance, (1e-4 + 0.75e-4) / 4, 1e-9);
  EXPECT_FALSE(cell.slope_known());
}

TEST(Elevation, OutsideAndUnseenIsUnknown) {
  SolidCloud cloud = ground([](double, double) { return 0; });
  std::erase_if(cloud.points, [](const SolidPoint& p) { return p.cell[0] == 7 && p.cell[1] == 7; });
  const Elevation map = build_elevation(cloud);
  EXPECT_EQ(map.at(7, 7).ground, Ground::unknown);
  EXPECT_EQ(map.at(-1, 0).ground, Ground::unknown);
  EXPECT_EQ(map.at(Vec2(1e6, 0)).ground, Ground::unknown);
  EXPECT_TRUE(build_elevation({}).cells.empty());
}

TEST(Elevation, AsASolidHasAQuadACell) {
  SolidCloud cloud = ground([](double x, double) { return 0.1 * x; });
  put(cloud, 1.55, 1.55, 0.9);
  sort(cloud);
  const Solid solid = elevation_solid(build_elevation(cloud));
  EXPECT_TRUE(well_formed(solid));
  ASSERT_EQ(solid.parts.size(), 2u);
  EXPECT_EQ(solid.parts[0].quads.size(), 899u);
  EXPECT_EQ(solid.parts[1].name, "obstacle");
  EXPECT_NEAR(solid.parts[1].vertices[0].z(), 0.9, 1e-6);
}

TEST(Elevation, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(build_elevation({}, {.max_step = 0}), Error);
  EXPECT_THROW(build_elevation({}, {.max_slope = 2}), Error);
  SolidCloud far;
  put(far, 0, 0, 0), put(far, 5000, 0, 0);
  EXPECT_THROW(build_elevation(far), Error);
}

}  // namespace
}  // namespace majak::map
