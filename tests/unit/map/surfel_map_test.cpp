// SPDX-License-Identifier: Apache-2.0
#include "majak/map/surfel_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/angle.hpp"
#include "majak/core/random.hpp"

namespace majak::map {
namespace {

float uniform(RandomStream& r, double low, double high) {
  return static_cast<float>(r.uniform(low, high));
}

double distance(const Surfel& s, double x, double y) { return std::hypot(s.x - x, s.y - y); }

double nearest_distance(const SurfelMap& map, double x, double y) {
  double best = 1e9;
  for (const Surfel& s : map.surfels()) best = std::min(best, distance(s, x, y));
  return best;
}

/// Points all over a square about the origin, none of them merged.
SurfelMap scattered(std::uint64_t seed, const SurfelMapOptions& options, int n = 150,
                    double half = 2.0) {
  SurfelMap map(options);
  RandomStream r(seed);
  for (int i = 0; i < n; ++i) map.add(uniform(r, -half, half), uniform(r, -half, half), 0, 1);
  return map;
}

TEST(SurfelMap, NearestIsTheNearestToTheCellsCentre) {
  for (const double cell : {0.05, 0.10, 0.23}) {
    const SurfelMapOptions options{.cell = cell, .reach = 0.30, .merge_radius = 0};
    const SurfelMap map = scattered(1, options);
    RandomStream r(2);
    int none = 0;
    for (int i = 0; i < 3000; ++i) {
      const double cx = (std::floor(r.uniform(-3, 3) / cell) + 0.5) * cell;
      const double cy = (std::floor(r.uniform(-3, 3) / cell) + 0.5) * cell;
      // Anywhere in the cell but on its very edge, where rounding decides.
      const std::uint32_t found = map.nearest(uniform(r, cx - 0.49 * cell, cx + 0.49 * cell),
                                              uniform(r, cy - 0.49 * cell, cy + 0.49 * cell));
      const double truly = nearest_distance(map, cx, cy);
      none += found == SurfelMap::kNone;
      if (found == SurfelMap::kNone) {
        EXPECT_GT(truly, options.reach - 1e-5);
      } else {
        EXPECT_NEAR(distance(map.surfel(found), cx, cy), truly, 1e-5);
      }
    }
    EXPECT_GT(none, 100);  // both answers were asked for
    EXPECT_LT(none, 2900);
  }
}

TEST(SurfelMap, NearestToAPointIsOffByTheCellAtMost) {
  const SurfelMapOptions options{.merge_radius = 0};
  const SurfelMap map = scattered(3, options);
  const double half_diagonal = std::sqrt(0.5) * options.cell;
  RandomStream r(4);
  for (int i = 0; i < 3000; ++i) {
    const float x = uniform(r, -2.5, 2.5), y = uniform(r, -2.5, 2.5);
    const std::uint32_t found = map.nearest(x, y);
    const double truly = nearest_distance(map, x, y);
    if (truly < options.reach - half_diagonal - 1e-5) {
      ASSERT_NE(found, SurfelMap::kNone);
    }
    if (truly > options.reach + half_diagonal + 1e-5) {
      ASSERT_EQ(found, SurfelMap::kNone);
    }
    if (found != SurfelMap::kNone) {
      ASSERT_LE(distance(map.surfel(found), x, y), truly + 2 * half_diagonal + 1e-5);
    }
  }
}

TEST(SurfelMap, ManyPointsAtOnceEqualOneByOne) {
  const SurfelMap map = scattered(5, {});
  RandomStream r(6);
  for (const std::size_t n : {0, 1, 7, 8, 9, 1000}) {
    std::vector<float> x(n), y(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = uniform(r, -9, 9), y[i] = uniform(r, -9, 9);
    std::vector<std::uint32_t> all(n, 7);
    map.nearest(x.data(), y.data(), n, all.data());
    for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(all[i], map.nearest(x[i], y[i])) << i;
  }
}

TEST(SurfelMap, MergedPointsMakeTheirMean) {
  SurfelMap map;
  RandomStream r(7);
  double sum_x = 0, sum_y = 0;
  constexpr int kPoints = 40;
  for (int i = 0; i < kPoints; ++i) {
    const float x = uniform(r, 0.51, 0.54), y = uniform(r, -0.34, -0.31);
    map.add(x, y, 0.6F, 0.8F);
    sum_x += x, sum_y += y;
  }
  ASSERT_EQ(map.surfels().size(), 1U);
  EXPECT_NEAR(map.surfel(0).x, sum_x / kPoints, 1e-6);
  EXPECT_NEAR(map.surfel(0).y, sum_y / kPoints, 1e-6);
  EXPECT_NEAR(map.surfel(0).nx, 0.6, 1e-6);
  EXPECT_NEAR(map.surfel(0).ny, 0.8, 1e-6);
}

TEST(SurfelMap, NormalsAreAveragedAndStayUnit) {
  SurfelMap map;
  const auto add = [&map](double degrees) {
    map.add(0.02F, 0.02F, static_cast<float>(std::cos(radians(degrees))),
            static_cast<float>(std::sin(radians(degrees))));
  };
  for (const double degrees : {80.0, 100.0, 85.0, 95.0}) add(degrees);
  ASSERT_EQ(map.surfels().size(), 1U);
  const Surfel& s = map.surfel(0);
  EXPECT_NEAR(std::hypot(s.nx, s.ny), 1, 1e-6);
  EXPECT_NEAR(degrees(std::atan2(s.ny, s.nx)), 90, 0.5);
}

TEST(SurfelMap, OldSurfelsForgetSlowly) {
  const SurfelMapOptions options{.max_count = 4};
  SurfelMap map(options);
  for (int i = 0; i < 100; ++i) map.add(0.51F, 0.02F, 1, 0);
  for (int i = 0; i < 100; ++i) map.add(0.53F, 0.02F, 1, 0);
  ASSERT_EQ(map.surfels().size(), 1U);
  EXPECT_NEAR(map.surfel(0).x, 0.53, 1e-4);  // with an endless memory 0.52
}

TEST(SurfelMap, BothSidesOfAThinWallStayApart) {
  SurfelMap map;
  for (int pass = 0; pass < 20; ++pass)
    for (int i = 0; i < 50; ++i) {
      const auto x = static_cast<float>(0.02 * i);
      map.add(x, 0.06F, 0, 1);   // seen from above
      map.add(x, 0.04F, 0, -1);  // seen from below
    }
  for (const Surfel& s : map.surfels()) {
    EXPECT_NEAR(std::abs(s.ny), 1, 1e-6);
    EXPECT_NEAR(s.y, s.ny > 0 ? 0.06 : 0.04, 1e-6);
  }
}

/// Surfels after so many passes over one place each of which sees it from all `directions`.
SurfelMap contradicted(int directions, int passes, float spread) {
  SurfelMap map;
  RandomStream r(11);
  for (int pass = 0; pass < passes; ++pass)
    for (int k = 0; k < directions; ++k) {
      const double angle = 2 * kPi * k / directions + 0.05 * r.normal();
      map.add(0.025F + uniform(r, -spread, spread), 0.025F + uniform(r, -spread, spread),
              static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    }
  return map;
}

TEST(SurfelMap, ContradictingNormalsInOneSpotMakeFourSidesAtMost) {
  for (const int directions : {3, 4, 5, 8, 17}) {
    const SurfelMap map = contradicted(directions, 200, 0);
    EXPECT_GE(map.surfels().size(), 3U) << directions;
    EXPECT_LE(map.surfels().size(), 4U) << directions;
    for (const Surfel& s : map.surfels()) {
      EXPECT_NEAR(std::hypot(s.nx, s.ny), 1, 1e-5) << directions;
      EXPECT_LT(distance(s, 0.025, 0.025), 1e-6) << directions;
    }
  }
}

TEST(SurfelMap, ContradictingNormalsInOnePlaceStayFew) {
  // An edge, a bush, a chair: the later passes add nothing.
  for (const int directions : {3, 4, 5, 8, 17}) {
    const SurfelMap map = contradicted(directions, 200, 0.01F);
    EXPECT_EQ(map.surfels().size(), contradicted(directions, 20, 0.01F).surfels().size());
    EXPECT_LE(map.surfels().size(), 12U) << directions;
    for (const Surfel& s : map.surfels())
      EXPECT_NEAR(std::hypot(s.nx, s.ny), 1, 1e-5) << directions;
  }
}

TEST(SurfelMap, NormalsThatCancelOutLeaveAUnitNormal) {
  SurfelMap map;
  const float sides[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (const auto& n : sides) map.add(0.025F, 0.025F, n[0], n[1]);
  for (int pass = 0; pass < 200; ++pass)
    for (const float sign : {1.0F, -1.0F})
      for (const auto& n : sides) map.add(0.025F, 0.025F, sign * n[0], sign * n[1]);
  ASSERT_EQ(map.surfels().size(), 4U);
  for (const Surfel& s : map.surfels()) EXPECT_NEAR(std::hypot(s.nx, s.ny), 1, 1e-5);
  // The last side takes all that fits nowhere.
  SurfelMap few({.max_count = 1});
  for (const float angle : {0.0F, 1.2F, 2.4F, 3.6F})
    few.add(0.025F, 0.025F, std::cos(angle), std::sin(angle));
  for (int pass = 0; pass < 200; ++pass) few.add(0.025F, 0.025F, std::cos(4.85F), std::sin(4.85F));
  ASSERT_EQ(few.surfels().size(), 4U);
  for (const Surfel& s : few.surfels()) EXPECT_NEAR(std::hypot(s.nx, s.ny), 1, 1e-5);
}

TEST(SurfelMap, APointWithoutANormalJoinsAnySurface) {
  SurfelMap map;
  map.add(0.02F, 0.02F, 0, 1);
  map.add(0.03F, 0.03F, 0, 0);
  ASSERT_EQ(map.surfels().size(), 1U);
  EXPECT_EQ(map.surfel(0).ny, 1);
  SurfelMap other;
  other.add(0.02F, 0.02F, 0, 0);
  other.add(0.03F, 0.03F, 0, 1);
  ASSERT_EQ(other.surfels().size(), 1U);
  EXPECT_EQ(other.surfel(0).ny, 1);
}

TEST(SurfelMap, GrowsInAllDirections) {
  // Each order makes the map grow on other sides first.
  for (int order = 0; order < 8; ++order) {
    std::vector<Surfel> points;
    for (int k = 0; k < 60; ++k) {
      const double angle = (order % 2 == 0 ? 1 : -1) * (0.1 * k + order), radius = 0.7 * k;
      points.push_back({static_cast<float>(radius * std::cos(angle)),
                        static_cast<float>(radius * std::sin(angle)), 1, 0});
    }
    if (order >= 4) std::reverse(points.begin(), points.end());
    SurfelMap map({.merge_radius = 0});
    for (const Surfel& p : points) map.add(p.x, p.y, p.nx, p.ny);
    ASSERT_EQ(map.surfels().size(), points.size());
    for (const Surfel& p : points) {
      const std::uint32_t found = map.nearest(p.x, p.y);
      ASSERT_NE(found, SurfelMap::kNone) << p.x << " " << p.y;
      EXPECT_LT(distance(map.surfel(found), p.x, p.y), 0.08);
    }
    EXPECT_EQ(map.nearest(1000, 1000), SurfelMap::kNone);
    EXPECT_EQ(map.nearest(-1000, 3), SurfelMap::kNone);
  }
}

TEST(SurfelMap, APlaceFarOffCostsLittle) {
  // Wheels that jump by kilometres: memory follows what was seen, not the square about it.
  SurfelMap map;
  map.add(0, 0, 0, 1);
  map.add(12000, 9000, 0, 1);
  map.add(-20000, 15000, 0, 1);
  EXPECT_EQ(map.nearest(0, 0), 0U);
  EXPECT_EQ(map.nearest(12000, 9000), 1U);
  EXPECT_EQ(map.nearest(-20000, 15000), 2U);
  EXPECT_EQ(map.nearest(6000, 4500), SurfelMap::kNone);
  EXPECT_LT(map.bytes(), 20'000'000U);
}

TEST(SurfelMap, AnEmptyMapKnowsNothing) {
  const SurfelMap map;
  EXPECT_EQ(map.nearest(0, 0), SurfelMap::kNone);
  EXPECT_EQ(map.nearest(-7, 1e4F), SurfelMap::kNone);
  EXPECT_TRUE(map.surfels().empty());
}

TEST(SurfelMap, ClearedIsAsGoodAsNew) {
  SurfelMap used = scattered(8, {});
  used.clear();
  EXPECT_TRUE(used.surfels().empty());
  RandomStream r(9);
  for (int i = 0; i < 500; ++i)
    ASSERT_EQ(used.nearest(uniform(r, -3, 3), uniform(r, -3, 3)), SurfelMap::kNone);
  // Filled again it answers like a map that was never used.
  SurfelMap fresh;
  for (int i = 0; i < 200; ++i) {
    const float x = uniform(r, -1, 3), y = uniform(r, -3, 1);
    used.add(x, y, 1, 0);
    fresh.add(x, y, 1, 0);
  }
  ASSERT_EQ(used.surfels().size(), fresh.surfels().size());
  for (int i = 0; i < 2000; ++i) {
    const float x = uniform(r, -4, 4), y = uniform(r, -4, 4);
    ASSERT_EQ(used.nearest(x, y), fresh.nearest(x, y));
  }
}

TEST(SurfelMap, AWallSeenAHundredTimesIsOneRow) {
  SurfelMap map;
  RandomStream r(10);
  for (int pass = 0; pass < 100; ++pass)
    for (int i = 0; i < 200; ++i)
      map.add(uniform(r, -5, 5), static_cast<float>(1.0 + 0.01 * r.normal()), 0, -1);
  EXPECT_LT(map.surfels().size(), 450U);  // 10 m at 5 cm are 200
  double off = 0;
  for (const Surfel& s : map.surfels()) off += std::abs(s.y - 1.0);
  EXPECT_LT(off / static_cast<double>(map.surfels().size()), 0.006);  // a single return: 0.008
  EXPECT_LT(map.bytes(), 1'000'000U);
  EXPECT_GT(map.bytes(), map.surfels().size() * sizeof(Surfel));
}

}  // namespace
}  // namespace majak::map
