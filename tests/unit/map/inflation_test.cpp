// SPDX-License-Identifier: Apache-2.0
#include "majak/map/inflation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "tests/support/ascii_map.hpp"

namespace majak::map {
namespace {

constexpr auto kCentre = InflationMeaning::centre, kTouch = InflationMeaning::touch;
constexpr InflationMeaning kBoth[] = {kCentre, kTouch};

CellMask random_mask(std::uint64_t seed, double share, int longest = 40) {
  RandomStream random(seed);
  CellMask mask{
      1 + static_cast<int>(random.below(longest)), 1 + static_cast<int>(random.below(longest)), {}};
  for (int i = 0; i < mask.width * mask.height; ++i) mask.cells.push_back(random.uniform() < share);
  return mask;
}

/// The slow twin: each cell asks each obstacle whether a robot in its middle meets that, `off`
/// (cells) away.
CellMask slow(const CellMask& obstacles, const std::function<bool(const Vec2& off)>& meets) {
  CellMask blocked = obstacles;
  for (int y = 0; y < obstacles.height; ++y)
    for (int x = 0; x < obstacles.width; ++x)
      for (int v = 0; v < obstacles.height; ++v)
        for (int u = 0; u < obstacles.width; ++u)
          if (obstacles.at(u, v) && meets(Vec2(u - x, v - y)))
            blocked.cells[blocked.index(x, y)] = 1;
  return blocked;
}

bool disc_meets(const Vec2& off, double radius_cells, InflationMeaning meaning) {
  if (meaning == kCentre) return off.norm() < radius_cells;
  // The square's point nearest to the robot.
  const Vec2 nearest(std::clamp(0.0, off.x() - 0.5, off.x() + 0.5),
                     std::clamp(0.0, off.y() - 0.5, off.y() + 0.5));
  return nearest.norm() < radius_cells;
}

/// Winding by angles: another way than the library's.
bool winds_around(const std::vector<Vec2>& corners, const Vec2& p) {
  double turned = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i] - p, b = corners[(i + 1) % corners.size()] - p;
    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return std::abs(turned) > kPi;
}

/// The polygon cut off beyond p . normal = limit.
std::vector<Vec2> cut(const std::vector<Vec2>& corners, const Vec2& normal, double limit) {
  std::vector<Vec2> kept;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double da = a.dot(normal) - limit, db = b.dot(normal) - limit;
    if (da <= 0) kept.push_back(a);
    if ((da < 0) != (db < 0) && da != db) kept.push_back(a + da / (da - db) * (b - a));
  }
  return kept;
}

/// Area of the polygon within the square of an obstacle's cell.
double area_within(std::vector<Vec2> corners, const Vec2& middle) {
  for (const Vec2& normal : {Vec2(1, 0), Vec2(0, 1), Vec2(-1, 0), Vec2(0, -1)})
    corners = cut(corners, normal, middle.dot(normal) + 0.5);
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

bool polygon_meets(const Vec2& off, const Polygon& polygon, double resolution,
                   InflationMeaning meaning) {
  std::vector<Vec2> corners;
  for (const Vec2& c : polygon.corners)
    corners.push_back(Pose2{0, 0, *polygon.heading} * c / resolution);
  return meaning == kCentre ? winds_around(corners, off) : area_within(corners, off) > 1e-12;
}

/// A star about a point that need not be the robot's.
Polygon random_polygon(RandomStream& random) {
  Polygon polygon{{}, random.uniform(-kPi, kPi)};
  const Vec2 middle(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
  const int n = 3 + static_cast<int>(random.below(6));
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * kPi * k / n, r = random.uniform(0.02, 0.6);
    polygon.corners.push_back(middle + r * Vec2(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

/// '#' obstacle, 'o' blocked by it, '.' neither.
std::vector<std::string> inflated(const std::vector<std::string>& lines, const Footprint& robot,
                                  const InflationOptions& options) {
  const KnownMap map = fixture::ascii_map(lines);
  const CellMask blocked = inflate(map, robot, options);
  std::vector<std::string> seen;
  for (int y = map.height - 1; y >= 0; --y) {
    seen.emplace_back();
    for (int x = 0; x < map.width; ++x)
      seen.back() += map.at(x, y) == CellState::occupied ? '#' : blocked.at(x, y) ? 'o' : '.';
  }
  return seen;
}

using Lines = std::vector<std::string>;

TEST(Inflation, OfADiscEqualsTheSlowTwin) {
  for (const double share : {0.0, 0.003, 0.03, 0.4})
    for (const double radius : {0.0, 0.02, 0.07, 0.23, 0.31, 1.17, 50.0})
      for (std::uint64_t seed = 0; seed < 3; ++seed)
        for (const auto meaning : kBoth) {
          const CellMask mask = random_mask(seed, share);
          ASSERT_EQ(
              inflate(mask, 0.1, Disc{radius}, meaning),
              slow(mask, [&](const Vec2& off) { return disc_meets(off, radius / 0.1, meaning); }))
              << share << ' ' << radius << ' ' << seed;
        }
}

TEST(Inflation, OfAPolygonEqualsTheSlowTwin) {
  RandomStream random(5);
  for (int k = 0; k < 60; ++k) {
    const CellMask mask = random_mask(static_cast<std::uint64_t>(k), k % 2 == 0 ? 0.01 : 0.2, 25);
    const Polygon polygon = random_polygon(random);
    for (const auto meaning : kBoth)
      ASSERT_EQ(
          inflate(mask, 0.1, polygon, meaning),
          slow(mask, [&](const Vec2& off) { return polygon_meets(off, polygon, 0.1, meaning); }))
          << k;
  }
}

// By the distance transform: what is nearer than the radius.
TEST(Inflation, BetweenMiddlesIsTheDistanceTransformCutOff) {
  const CellMask mask = random_mask(2, 0.01, 150);
  const auto squares = squared_distances(mask);
  const CellMask blocked = inflate(mask, 0.05, Disc{0.33}, kCentre);
  for (std::size_t i = 0; i < squares.size(); ++i)
    ASSERT_EQ(blocked.cells[i] == 1, std::sqrt(squares[i]) * 0.05 < 0.33);
}

TEST(Inflation, MiddlesOnlyReachAsFarAsTheRadius) {
  const Lines lines{".......", ".......", ".......", "...#...", ".......", ".......", "......."};
  // Two cells off is not nearer than two cells.
  EXPECT_EQ(inflated(lines, Disc{2}, {kCentre}),
            (Lines{".......", ".......", "..ooo..", "..o#o..", "..ooo..", ".......", "......."}));
  EXPECT_EQ(inflated(lines, Disc{2.01}, {kCentre}),
            (Lines{".......", "...o...", "..ooo..", ".oo#oo.", "..ooo..", "...o...", "......."}));
}

TEST(Inflation, AnyTouchReachesHalfACellFarther) {
  const Lines lines{".......", ".......", ".......", "...#...", ".......", ".......", "......."};
  EXPECT_EQ(inflated(lines, Disc{2}, {kTouch}),
            (Lines{".......", "..ooo..", ".ooooo.", ".oo#oo.", ".ooooo.", "..ooo..", "......."}));
  // A radius of a cell and a half only just touches the square two cells off.
  EXPECT_EQ(inflated(lines, Disc{1.5}, {kTouch}),
            (Lines{".......", ".......", "..ooo..", "..o#o..", "..ooo..", ".......", "......."}));
}

// 0.3 m / 0.1 m is less than 3 in doubles, 0.7 / 0.1 less than 7, 0.6 / 0.2 less than 3.
TEST(Inflation, WholeCellsAreWholeCells) {
  for (int cells = 1; cells < 60; ++cells)
    for (const double resolution : {0.1, 0.05, 0.2, 0.025, 0.07}) {
      CellMask row{70, 1, std::vector<std::uint8_t>(70)};
      row.cells[0] = 1;
      const auto count = [&](double radius, InflationMeaning meaning) {
        const CellMask blocked = inflate(row, resolution, Disc{radius}, meaning);
        return std::count(blocked.cells.begin(), blocked.cells.end(), 1);
      };
      ASSERT_EQ(count(cells * resolution, kCentre), cells);
      ASSERT_EQ(count((cells + 0.5) * resolution, kTouch), cells + 1);
    }
}

TEST(Inflation, APolygonIsSeenFromTheRobotNotFromTheObstacle) {
  // A robot 3 long and 1 wide, its point in its last cell: blocked where it would stand on the
  // obstacle, which is behind the obstacle as it looks.
  const Polygon robot{{{2.5, 0.5}, {-0.5, 0.5}, {-0.5, -0.5}, {2.5, -0.5}}, 0.0};
  const Lines lines{".......", ".......", "...#...", ".......", "......."};
  EXPECT_EQ(inflated(lines, robot, {kTouch}),
            (Lines{".......", ".......", ".oo#...", ".......", "......."}));
  Polygon up = robot;
  up.heading = kPi / 2;
  EXPECT_EQ(inflated(lines, up, {kTouch}),
            (Lines{".......", ".......", "...#...", "...o...", "...o..."}));
}

TEST(Inflation, APolygonWithADentLetsAnObstacleInside) {
  // A horseshoe open to +x.
  const Polygon robot{{{2.4, 2.4},
                       {-2.4, 2.4},
                       {-2.4, -2.4},
                       {2.4, -2.4},
                       {2.4, -1.6},
                       {-1.6, -1.6},
                       {-1.6, 1.6},
                       {2.4, 1.6}},
                      0.0};
  const Lines lines{".......", ".......", ".......", "...#...", ".......", ".......", "......."};
  EXPECT_EQ(inflated(lines, robot, {kCentre}),
            (Lines{".......", ".ooooo.", ".....o.", "...#.o.", ".....o.", ".ooooo.", "......."}));
}

TEST(Inflation, UnknownIsNoObstacleUnlessAsked) {
  const Lines lines{"......", ".. ...", "......", "......"};
  EXPECT_EQ(inflated(lines, Disc{1.2}, {kCentre}), (Lines{"......", "......", "......", "......"}));
  // All around the map is unknown, too.
  EXPECT_EQ(inflated(lines, Disc{1.2}, {kCentre, true}),
            (Lines{"oooooo", "oooo.o", "o.o..o", "oooooo"}));
}

TEST(Inflation, WhatIsUnknownOutsideBlocksAsIfItWereInside) {
  RandomStream random(3);
  for (int k = 0; k < 20; ++k) {
    // The same map within a wide frame of unknown cells.
    constexpr int kFrame = 14;
    KnownMap map;
    map.resolution = 0.1, map.width = 12, map.height = 9;
    for (int i = 0; i < 12 * 9; ++i)
      map.cells.push_back(random.uniform() < 0.02 ? CellState::occupied : CellState::free);
    KnownMap wide;
    wide.resolution = 0.1, wide.width = 12 + 2 * kFrame, wide.height = 9 + 2 * kFrame;
    wide.cells.resize(wide.index(0, wide.height));
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 12; ++x) wide.cells[wide.index(x + kFrame, y + kFrame)] = map.at(x, y);
    const Footprint robot =
        k % 2 == 0 ? Footprint(Disc{random.uniform(0, 0.5)}) : Footprint(random_polygon(random));
    for (const auto meaning : kBoth) {
      const CellMask inside = inflate(map, robot, {meaning, true});
      const CellMask framed = inflate(wide, robot, {meaning, true});
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 12; ++x)
          ASSERT_EQ(inside.at(x, y), framed.at(x + kFrame, y + kFrame))
              << k << ' ' << x << ' ' << y;
    }
  }
}

TEST(Inflation, ARobotThatMayTurnIsTheDiscAroundIt) {
  const CellMask mask = random_mask(9, 0.03);
  const Polygon robot{{{0.3, 0.1}, {-0.1, 0.1}, {-0.1, -0.1}, {0.3, -0.1}}, {}};
  for (const auto meaning : kBoth) {
    const CellMask any = inflate(mask, 0.1, robot, meaning);
    EXPECT_EQ(any, inflate(mask, 0.1, Disc{std::hypot(0.3, 0.1)}, meaning));
    // No heading is blocked where none is said to be.
    for (int k = 0; k < 12; ++k) {
      Polygon fixed = robot;
      fixed.heading = 0.5 * k;
      const CellMask one = inflate(mask, 0.1, fixed, meaning);
      for (std::size_t i = 0; i < mask.cells.size(); ++i) ASSERT_LE(one.cells[i], any.cells[i]);
    }
  }
}

// Larger robots, and any touch against middles alone, block what smaller ones do, and more. A
// square's middle is at most 0.7072 cells from its nearest point.
TEST(Inflation, GrowsWithTheRadiusAndTheMeaning) {
  const CellMask mask = random_mask(4, 0.004, 120);
  const auto within = [](const CellMask& a, const CellMask& b) {
    return std::equal(a.cells.begin(), a.cells.end(), b.cells.begin(), std::less_equal<>());
  };
  CellMask before = mask;
  for (double radius = 0; radius < 12; radius += 0.37) {
    const CellMask middles = inflate(mask, 1, Disc{radius}, kCentre);
    const CellMask touch = inflate(mask, 1, Disc{radius}, kTouch);
    EXPECT_TRUE(within(before, middles));
    EXPECT_TRUE(within(middles, touch));
    EXPECT_TRUE(within(touch, inflate(mask, 1, Disc{radius + 0.7072}, kCentre)));
    before = middles;
  }
}

TEST(Inflation, OfTwoMapsTogetherIsThatOfEach) {
  RandomStream random(8);
  for (int k = 0; k < 10; ++k) {
    CellMask a{30, 20, {}}, b = a, both = a;
    for (int i = 0; i < 600; ++i) {
      a.cells.push_back(random.uniform() < 0.01);
      b.cells.push_back(random.uniform() < 0.02);
      both.cells.push_back(a.cells.back() | b.cells.back());
    }
    const Footprint robot = k % 2 == 0 ? Footprint(Disc{0.4}) : Footprint(random_polygon(random));
    const CellMask in_a = inflate(a, 0.1, robot, kTouch), in_b = inflate(b, 0.1, robot, kTouch);
    CellMask expected = in_a;
    for (int i = 0; i < 600; ++i) expected.cells[i] |= in_b.cells[i];
    EXPECT_EQ(inflate(both, 0.1, robot, kTouch), expected);
  }
}

TEST(Inflation, IsTheSameForAnyNumberOfThreads) {
  CellMask mask{600, 500, std::vector<std::uint8_t>(300'000)};
  RandomStream random(1);
  for (int k = 0; k < 900; ++k) mask.cells[random.below(mask.cells.size())] = 1;
  for (const Footprint& robot : {Footprint(Disc{0.5}), Footprint(random_polygon(random))})
    EXPECT_EQ(inflate(mask, 0.1, robot, kTouch), inflate(mask, 0.1, robot, kTouch, {3}));
}

TEST(Inflation, RefusesWhatMakesNoSense) {
  const CellMask mask{2, 1, {0, 1}};
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(inflate(mask, 0, Disc{1}, kTouch), Error);
  EXPECT_THROW(inflate(mask, 0.1, Disc{-1}, kTouch), Error);
  EXPECT_THROW(inflate(mask, 0.1, Disc{kNan}, kTouch), Error);
  EXPECT_THROW(inflate(mask, 0.1, Polygon{{{0, 0}, {1, 0}}}, kTouch), Error);
  EXPECT_THROW(inflate(mask, 0.1, Polygon{{{0, 0}, {1, 0}, {kNan, 1}}}, kTouch), Error);
  EXPECT_THROW(inflate(mask, 0.1, Polygon{{{0, 0}, {1, 0}, {0, 1}}, kNan}, kTouch), Error);
  EXPECT_THROW(inflate({2, 2, {0, 1}}, 0.1, Disc{1}, kTouch), Error);
  const KnownMap map = fixture::ascii_map({"..#"});
  EXPECT_THROW(inflate(map, Polygon{{{0, 0}, {9e9, 0}, {0, 1}}, 0.0}, {kTouch, true}), Error);
  EXPECT_TRUE(inflate(CellMask{}, 0.1, Disc{1}, kTouch).cells.empty());
}

}  // namespace
}  // namespace majak::map
