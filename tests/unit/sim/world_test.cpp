// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/world.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/buildings.hpp"

namespace majak::sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Slow twin: every segment by a 2 x 2 system, every disc by its quadratic.
double cast_slowly(const Scene& scene, const Vec2& o, double angle, double max_range) {
  const Vec2 d(std::cos(angle), std::sin(angle));
  double best = max_range;
  for (const Segment& s : scene.segments) {
    Eigen::Matrix2d m;
    m << d, s.a - s.b;
    if (m.determinant() == 0) continue;
    const Vec2 t = m.inverse() * (s.a - o);
    if (t.x() >= 0 && t.y() >= 0 && t.y() <= 1) best = std::min(best, t.x());
  }
  for (const Disc& disc : scene.discs) {
    const double b = d.dot(o - disc.centre),
                 c = (o - disc.centre).squaredNorm() - disc.radius * disc.radius;
    if (b * b < c || c < 0) continue;
    const double t = -b - std::sqrt(b * b - c);
    if (t >= 0) best = std::min(best, t);
  }
  return best < max_range ? best : kInfinity;
}

void expect_same(double a, double b) {
  if (std::isinf(a) || std::isinf(b)) {
    EXPECT_EQ(a, b);
  } else {
    EXPECT_NEAR(a, b, 1e-9 * (1 + b));
  }
}

Scene random_scene(std::uint64_t seed) {
  RandomStream r(seed);
  Scene scene;
  scene.name = "random";
  for (int i = 0; i < 60; ++i) {
    const Vec2 a(r.uniform(-10, 10), r.uniform(-8, 8));
    scene.segments.push_back({a, a + Vec2(r.uniform(-4, 4), r.uniform(-4, 4))});
  }
  for (int i = 0; i < 15; ++i) {
    scene.discs.push_back({{r.uniform(-10, 10), r.uniform(-8, 8)}, r.uniform(0.05, 0.8)});
  }
  return scene;
}

TEST(World, CastEqualsBruteForce) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Scene scene = random_scene(seed);
    const World world(scene);
    RandomStream r(100 + seed);
    for (int i = 0; i < 2000; ++i) {
      const Vec2 o(r.uniform(-14, 14), r.uniform(-12, 12));  // outside, too
      const double angle = r.uniform(-4, 4), max_range = i % 3 == 0 ? 3.0 : 80.0;
      expect_same(world.cast(o, angle, max_range).range, cast_slowly(scene, o, angle, max_range));
    }
  }
}

TEST(World, CastEqualsBruteForceAlongTheAxesAndTheGridLines) {
  Scene scene = building();
  const World world(scene);
  for (double x = -0.5; x < 41; x += 0.25) {
    for (double y = -0.25; y < 26; y += 0.5) {
      for (int k = 0; k < 8; ++k) {
        const double angle = k * kPi / 4;
        // Off the walls' own lines: a ray inside a wall's line meets it or not by rounding.
        const Vec2 o(x + 0.0123, y + 0.0177);
        expect_same(world.cast(o, angle, 80).range, cast_slowly(scene, o, angle, 80));
      }
    }
  }
}

Scene square(double half) {
  Scene scene;
  scene.name = "square";
  const Vec2 p[4] = {{-half, -half}, {half, -half}, {half, half}, {-half, half}};
  for (int i = 0; i < 4; ++i) scene.segments.push_back({p[i], p[(i + 1) % 4], 0.3});
  return scene;
}

TEST(World, RangeAndIncidenceInASquare) {
  const World world(square(2));
  for (double angle = -kPi; angle < kPi; angle += 0.037) {
    const Hit hit = world.cast({0, 0}, angle, 80);
    const double c = std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
    EXPECT_NEAR(hit.range, 2 / c, 1e-12);
    EXPECT_NEAR(hit.incidence, std::acos(c), 1e-7);
    EXPECT_EQ(hit.reflectivity, 0.3);
  }
}

TEST(World, DiscsAreRound) {
  Scene scene = square(5);
  scene.discs.push_back({{3, 0}, 1, 0.9});
  const World world(scene);
  const Hit centre = world.cast({0, 0}, 0, 80);
  EXPECT_NEAR(centre.range, 2, 1e-12);
  EXPECT_NEAR(centre.incidence, 0, 1e-7);
  EXPECT_EQ(centre.reflectivity, 0.9);
  const Hit tangent = world.cast({0, 0}, std::asin(1.0 / 3) - 1e-6, 80);
  EXPECT_NEAR(tangent.range, std::sqrt(8.0), 0.01);
  EXPECT_NEAR(tangent.incidence, kPi / 2, 0.01);
  EXPECT_NE(tangent.object, world.cast({0, 0}, std::asin(1.0 / 3) + 1e-6, 80).object);
}

TEST(World, NothingInReachIsInfinite) {
  const World world(square(5));
  const Hit hit = world.cast({0, 0}, 0.1, 4.9);
  EXPECT_EQ(hit.range, kInfinity);
  EXPECT_EQ(hit.object, -1);
  EXPECT_EQ(world.cast({20, 0}, 0.1, 80).range, kInfinity);   // looks away
  EXPECT_NEAR(world.cast({20, 0}, kPi, 80).range, 15, 1e-9);  // looks from outside
}

TEST(World, MovingDiscsHideWhatIsBehindUnlessOneStandsInside) {
  const World world(square(5));
  const Disc person{{2, 0}, 0.25};
  EXPECT_NEAR(world.cast({0, 0}, 0, 80, {&person, 1}).range, 1.75, 1e-12);
  EXPECT_NEAR(world.cast({0, 0}, kPi, 80, {&person, 1}).range, 5, 1e-12);
  EXPECT_NEAR(world.cast({2.1, 0}, 0, 80, {&person, 1}).range, 2.9, 1e-12);
}

TEST(World, Clearance) {
  Scene scene = square(5);
  scene.discs.push_back({{2, 0}, 0.5});
  const World world(scene);
  EXPECT_NEAR(world.clearance({0, 0}), 1.5, 1e-12);
  EXPECT_NEAR(world.clearance({-4, 1}), 1, 1e-12);
  EXPECT_EQ(world.clearance({2.1, 0}), 0);
  EXPECT_NEAR(distance_to({{0, 0}, {1, 0}}, {2, 1}), std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(distance_to({{1, 1}, {1, 1}}, {1, 3}), 2, 1e-12);  // a segment of no length
}

TEST(World, EmptyOrBoundlessIsAnError) {
  EXPECT_THROW(World(Scene{}), Error);
  Scene scene = square(5);
  scene.discs.push_back({{kInfinity, 0}, 1});
  EXPECT_THROW(World{scene}, Error);
}

TEST(BuiltIn, NamesLeadToWorlds) {
  for (const std::string& name : built_in_names()) EXPECT_EQ(built_in(name).name, name);
  EXPECT_THROW(built_in("castle"), Error);
}

TEST(BuiltIn, BuildingIsClosed) {
  // From everywhere on the tour, every ray ends within the outer walls.
  const World world(building());
  for (const Vec2& place : world.scene().tour) {
    for (double angle = -kPi; angle < kPi; angle += 0.01) {
      const Hit hit = world.cast(place, angle, 80);
      ASSERT_LT(hit.range, 48);
      const Vec2 p = place + hit.range * Vec2(std::cos(angle), std::sin(angle));
      ASSERT_TRUE(p.x() > 0 && p.x() < 40 && p.y() > 0 && p.y() < 25) << p.transpose();
    }
  }
}

TEST(BuiltIn, LargeRingIsACorridorThatIsNowhereNarrow) {
  const World world(large_ring());
  for (double x = 1.1; x < 58.9; x += 0.1) {
    for (const double y : {1.1, 38.9}) {
      ASSERT_GE(world.clearance({x, y}), 0.75) << x;
      ASSERT_LE(world.clearance({x, y}), 1.1 + 1e-9) << x;
    }
  }
  for (double angle = -kPi; angle < kPi; angle += 0.01)
    ASSERT_LT(world.cast({1.1, 1.1}, angle, 80).range, 60);  // nothing is open
}

TEST(BuiltIn, BareRingShowsNothingButParallelWallsOnItsBareSides) {
  const World world(bare_ring());
  const auto seen = [&](const Vec2& from, double along) {  // what is not one of the two walls
    int things = 0;
    for (double angle = along - kPi / 2; angle < along + kPi / 2; angle += 0.01) {
      const Hit hit = world.cast(from, angle, 8);
      const double across = hit.range * std::sin(angle - along);
      things += hit.object >= 0 && std::abs(std::abs(across) - 1.1) > 1e-6;
    }
    return things;
  };
  for (double x = 5; x < 50; x += 0.7) EXPECT_EQ(seen({x, 1.1}, 0), 0) << x;
  for (double y = 5; y < 30; y += 0.7) EXPECT_EQ(seen({58.9, y}, kPi / 2), 0) << y;
  EXPECT_GT(seen({54, 1.1}, 0), 20);  // the corner, from where the tour begins
  for (double x = 5; x < 55; x += 0.7) EXPECT_GT(seen({x, 38.9}, kPi), 5) << x;  // doors
}

TEST(BuiltIn, BareRingsComeInAllSizes) {
  for (const double length : {20.0, 37.0, 120.0}) {
    const World world(bare_ring(length, length));
    for (double x = 1.1; x < length - 1.1; x += 0.1)
      for (const double y : {1.1, length - 1.1}) ASSERT_GE(world.clearance({x, y}), 0.9) << x;
    for (double angle = -kPi; angle < kPi; angle += 0.01)
      ASSERT_LT(world.cast({1.1, 1.1}, angle, 200).range, length);  // nothing is open
  }
}

TEST(BuiltIn, NestedRingsShareACorner) {
  const World world(nested_rings());
  for (double t = 1.1; t < 19; t += 0.1) {
    ASSERT_GE(world.clearance({t, 1.1}), 0.9) << t;   // both rings
    ASSERT_GE(world.clearance({t, 13.1}), 0.9) << t;  // the small one
    ASSERT_GE(world.clearance({t, 38.9}), 0.9) << t;  // the large one
  }
  EXPECT_LT(world.cast({19.1, 13.1}, 0, 80).range, 1.2);  // the small ring turns here
}

TEST(BuiltIn, CorridorShowsTwoParallelWallsToAShortSightedLaser) {
  const World world(corridor());
  for (double x = 10; x <= 50; x += 0.7) {
    for (double angle = -kPi; angle < kPi; angle += 0.01) {
      const Hit hit = world.cast({x, 0.1}, angle, 8);
      if (hit.object < 0) continue;
      EXPECT_NEAR(std::abs(0.1 + hit.range * std::sin(angle)), 1.2, 1e-9);
    }
  }
}

}  // namespace
}  // namespace majak::sim
