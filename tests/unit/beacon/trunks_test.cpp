// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/trunks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "../../support/ascii_room.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/park.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::beacon {
namespace {

/// Discs and walls as lines of light see them, half a degree apart, without any error.
Scan scan_of(const sim::Scene& things, int beams = 361, const Pose2& T_world_laser = {}) {
  sim::Scene scene = things;
  scene.segments.push_back({{500, 500}, {501, 500}, 0.5});  // a world is not empty
  const sim::World world(scene);
  Scan scan;
  scan.start_angle = -kPi / 2;
  scan.angle_step = kPi / (beams - 1);
  scan.max_range = 80;
  for (int i = 0; i < beams; ++i)
    scan.ranges.push_back(static_cast<float>(
        world
            .cast(T_world_laser.translation(),
                  T_world_laser.theta + scan.angle(static_cast<std::size_t>(i)), 79)
            .range));
  return scan;
}

sim::Scene discs(std::initializer_list<sim::Disc> all) {
  sim::Scene scene;
  scene.discs = all;
  return scene;
}

sim::Disc trunk(double range, double bearing, double diameter) {
  return {range * Vec2(std::cos(bearing), std::sin(bearing)), diameter / 2, 0.4};
}

constexpr TrunkOptions kLine = {.max_diameter = 2, .spot = 0};  // beams that are lines

// ---- Where and how thick ----------------------------------------------------------------------

TEST(Trunks, ADiscIsFoundWhereItStandsAndAsThickAsItIs) {
  RandomStream random(1);
  double squared = 0;
  int n = 0, missed = 0;
  for (int i = 0; i < 400; ++i) {
    const double range = random.uniform(2, 40), bearing = random.uniform(-1.5, 1.5);
    const double diameter = std::min(0.9, random.uniform(0.15, 0.9) + range * 0.01);
    const auto found = find_trunks(scan_of(discs({trunk(range, bearing, diameter)})), kLine);
    if (diameter / range < 2 * radians(0.5)) continue;  // one beam may meet it
    missed += found.empty();  // a beam that grazes a thick one is deeper in than the gap
    if (found.empty()) continue;
    ASSERT_EQ(found.size(), 1u) << range << " " << bearing << " " << diameter;
    const LandmarkSighting& s = found.front();
    const double step = radians(0.5);
    EXPECT_NEAR(s.diameter, diameter, 1.02 * range * step);
    EXPECT_NEAR(s.bearing, bearing, 0.51 * step);
    EXPECT_NEAR(s.range, range, 0.8 * range * step);
    EXPECT_LT((s.p_laser() - s.range * Vec2(std::cos(s.bearing), std::sin(s.bearing))).norm(),
              1e-15);
    EXPECT_NEAR(-kPi / 2 + static_cast<double>(s.beam) * step, bearing, 1.01 * step);
    squared += std::pow((s.diameter - diameter) / s.diameter_sigma, 2);
    ++n;
  }
  EXPECT_GT(n, 200);
  EXPECT_LT(missed, n / 20);
  EXPECT_LT(squared / n, 1.2);  // within what is stated
}

// How wide something looks may be off by a step; where its bark is, is not: whoever knows the
// diameter better knows the range better.
TEST(Trunks, TheBarkIsSeenWhateverTheDiameterLooksLike) {
  RandomStream random(2);
  std::array<double, 4> off{}, as_it_looks{};
  constexpr int kEach = 200;
  for (std::size_t k = 0; k < off.size(); ++k)
    for (int i = 0; i < kEach; ++i) {
      const double range = 10.0 * static_cast<double>(k) + random.uniform(4, 10);
      const double bearing = random.uniform(-1.5, 1.5);
      const double diameter = std::max(random.uniform(0.3, 0.9), 2.1 * range * radians(0.5));
      const auto found = find_trunks(scan_of(discs({trunk(range, bearing, diameter)})), kLine);
      if (found.empty()) continue;
      const LandmarkSighting& s = found.front();
      const double better = s.range + s.depth * (diameter - s.diameter);
      off[k] += std::pow(better - range, 2) / kEach;
      as_it_looks[k] += std::pow(s.range - range, 2) / kEach;
    }
  for (const double square : off) EXPECT_LT(std::sqrt(square), 0.04);
  EXPECT_GT(std::sqrt(as_it_looks[3]), 2 * std::sqrt(off[3]));
}

// The finer the beams, the nearer to the truth: the geometry is that of a circle, not of a plane.
TEST(Trunks, FineBeamsTellTheCircle) {
  for (const double range : {1.5, 3.0, 10.0})
    for (const double diameter : {0.1, 0.4, 0.9}) {
      const auto found = find_trunks(scan_of(discs({trunk(range, 0.3, diameter)}), 36001), kLine);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_NEAR(found[0].diameter, diameter, 2 * range * radians(0.005));
      EXPECT_NEAR(found[0].range, range, 2 * range * radians(0.005));
      EXPECT_NEAR(found[0].bearing, 0.3, radians(0.005));
    }
}

TEST(Trunks, TheyAreNamedFromTheFirstBeamToTheLast) {
  const auto found = find_trunks(
      scan_of(discs({trunk(10, 1, 0.4), trunk(5, -1, 0.3), trunk(8, 0.2, 0.5)})), kLine);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NEAR(found[0].range, 5, 0.1);
  EXPECT_NEAR(found[1].range, 8, 0.1);
  EXPECT_NEAR(found[2].range, 10, 0.1);
}

TEST(Trunks, AScanTheOtherWayRoundShowsTheSame) {
  const Scan scan = scan_of(discs({trunk(6, 0.5, 0.4), trunk(9, -0.7, 0.5)}));
  Scan back = scan;
  back.start_angle = scan.angle(scan.ranges.size() - 1), back.angle_step = -scan.angle_step;
  std::reverse(back.ranges.begin(), back.ranges.end());
  auto ahead = find_trunks(scan), reversed = find_trunks(back);
  ASSERT_EQ(ahead.size(), 2u);
  ASSERT_EQ(reversed.size(), 2u);
  std::reverse(reversed.begin(), reversed.end());
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(ahead[i].range, reversed[i].range, 1e-6);
    EXPECT_NEAR(ahead[i].bearing, reversed[i].bearing, 1e-12);
    EXPECT_NEAR(ahead[i].diameter, reversed[i].diameter, 1e-6);
  }
}

// ---- What is none -----------------------------------------------------------------------------

TEST(Trunks, PolesOfAnAsciiRoomAndNotItsWalls) {
  const fixture::AsciiRoom room({
      "####################",
      "#..................#",
      "#....o.......o.....#",
      "#..................#",
      "#..................#",
      "#.........a........#",
      "####################",
  });
  const Scan scan = room.scan(room.pose('a', kPi / 2), {.beams = 721});
  const auto nearer = find_trunks(scan, {.clearance = 0.3, .lone = 0.3, .spot = 0});
  ASSERT_EQ(nearer.size(), 2u);
  EXPECT_NEAR(nearer[0].p_laser().x(), 1.5, 0.02);
  EXPECT_NEAR(nearer[0].p_laser().y(), -1.5, 0.02);
  EXPECT_NEAR(nearer[1].p_laser().y(), 2.5, 0.02);
  for (const auto& s : nearer) EXPECT_NEAR(s.diameter, 0.1, 0.02);
  EXPECT_TRUE(find_trunks(scan, {.clearance = 1.5, .spot = 0}).empty());  // too near the wall
}

TEST(Trunks, TheEndOfAWallIsNone) {
  for (const double x : {3.0, 8.0, 15.0}) {
    sim::Scene scene;
    scene.segments.push_back({{x, 0.5}, {x, 8}, 0.6});  // across
    EXPECT_TRUE(find_trunks(scan_of(scene)).empty());
    scene.segments = {{{x, -1}, {x + 6, -1.1}, 0.6}};  // nearly end on
    EXPECT_TRUE(find_trunks(scan_of(scene)).empty());
    scene.segments = {{{x, 0.5}, {x, 8}, 0.6}, {{x, 0.5}, {x + 5, 0.5}, 0.6}};  // a corner
    EXPECT_TRUE(find_trunks(scan_of(scene)).empty());
  }
}

// Half of it hidden by a nearer one: where its middle is cannot be told. The nearer one can.
TEST(Trunks, OneHalfHiddenBehindAnotherIsNone) {
  for (const double shift : {0.02, 0.03, -0.02, -0.03}) {
    const auto found =
        find_trunks(scan_of(discs({trunk(5, 0, 0.3), trunk(12, shift, 0.6)})), kLine);
    ASSERT_EQ(found.size(), 1u) << shift;
    EXPECT_NEAR(found[0].range, 5, 0.05);
    EXPECT_NEAR(found[0].bearing, 0, radians(0.3));
  }
  // Side by side, with a beam between them, both are there.
  EXPECT_EQ(find_trunks(scan_of(discs({trunk(5, 0, 0.3), trunk(12, 0.075, 0.6)})), kLine).size(),
            2u);
}

TEST(Trunks, ABushIsNone) {
  for (const double size : {1.3, 2.0, 4.0})
    for (const double range : {4.0, 9.0, 20.0})
      EXPECT_TRUE(find_trunks(scan_of(discs({trunk(range, 0.4, size)}))).empty());
}

// Thin, but deep: a hedge that is looked along.
TEST(Trunks, WhatIsDeeperThanItIsWideIsNone) {
  Scan scan = scan_of({});
  for (std::size_t i = 0; i < 6; ++i) scan.ranges[100 + i] = 8 + 0.12F * static_cast<float>(i);
  EXPECT_TRUE(find_trunks(scan).empty());
  for (std::size_t i = 0; i < 6; ++i) scan.ranges[100 + i] = 8;
  EXPECT_EQ(find_trunks(scan).size(), 1u);
}

TEST(Trunks, NothingToSeeIsNone) {
  EXPECT_TRUE(find_trunks(Scan{}).empty());
  for (const std::size_t n : {1u, 2u, 3u, 361u})
    for (const float r : {kNoReturn, kInvalidRange, 5.0F}) {
      Scan scan;
      scan.angle_step = 0.01;
      scan.ranges.assign(n, r);
      EXPECT_TRUE(find_trunks(scan).empty()) << n << " " << r;
    }
}

TEST(Trunks, OneBeamIsNoneTwoAre) {
  Scan scan = scan_of({});
  scan.ranges[100] = 10;
  EXPECT_TRUE(find_trunks(scan).empty());
  scan.ranges[101] = 10.02F;
  EXPECT_EQ(find_trunks(scan).size(), 1u);
  EXPECT_TRUE(find_trunks(scan, {.least_beams = 3}).empty());
}

TEST(Trunks, AtTheRimOfTheFieldOfViewIsNone) {
  Scan scan = scan_of({});
  const std::size_t n = scan.ranges.size();
  for (std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{2}, n - 1, n - 2, n - 3})
    scan.ranges[i] = 9;
  EXPECT_TRUE(find_trunks(scan).empty());
  scan.ranges[0] = scan.ranges[n - 1] = kNoReturn;
  EXPECT_EQ(find_trunks(scan).size(), 2u);
}

TEST(Trunks, BesideABeamOfWhichNothingIsKnownIsNone) {
  const Scan scan = scan_of(discs({trunk(10, 0, 0.6)}));
  ASSERT_EQ(find_trunks(scan).size(), 1u);
  std::size_t first = 0;
  while (!std::isfinite(scan.ranges[first])) ++first;
  std::size_t last = first;
  while (std::isfinite(scan.ranges[last + 1])) ++last;
  for (const std::size_t beside : {first - 1, last + 1}) {
    Scan dazzled = scan;
    dazzled.ranges[beside] = kInvalidRange;
    EXPECT_TRUE(find_trunks(dazzled).empty());
  }
}

// Whichever beam is lost, there is never more than one trunk and never one far from where it is.
TEST(Trunks, ALostBeamDoesNotSplitOne) {
  const Scan scan = scan_of(discs({trunk(6, 0, 0.8)}));
  const auto whole = find_trunks(scan);
  ASSERT_EQ(whole.size(), 1u);
  int kept = 0, beams = 0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!std::isfinite(scan.ranges[i])) continue;
    for (const float lost : {kNoReturn, kInvalidRange}) {
      Scan other = scan;
      other.ranges[i] = lost;
      const auto found = find_trunks(other);
      ++beams, kept += found.size() == 1;
      EXPECT_LE(found.size(), 1u);
      if (!found.empty())
        EXPECT_LT((found[0].p_laser() - whole[0].p_laser()).norm(), 0.08);  // 1.5 steps
    }
  }
  EXPECT_GE(kept, beams - 6);  // those at its rims
}

TEST(Trunks, LimitsAreKept) {
  const Scan scan = scan_of(discs({trunk(20, 0, 0.6)}));
  ASSERT_EQ(find_trunks(scan).size(), 1u);
  EXPECT_TRUE(find_trunks(scan, {.max_range = 19}).empty());
  EXPECT_TRUE(find_trunks(scan, {.min_range = 21}).empty());
  EXPECT_TRUE(find_trunks(scan, {.max_diameter = 0.3}).empty());
}

// ---- Against the simulated laser --------------------------------------------------------------

/// What a car in the park sees of trunks, against the truth, over a piece of the tour.
struct Seen {
  LandmarkSighting sighting;
  Vec2 off;  // along the line of sight and across it, m
  double diameter_off;
};
struct Drive {
  std::vector<Seen> seen;
  int strangers = 0;  // where no trunk is
  int twice = 0;      // the same trunk in one scan
  int scans = 0;
};

Drive drive_through_the_park(int beams) {
  const sim::World world(sim::park());
  const sim::Path path = sim::plan_tour(world, {.short_tour = true});
  sim::SimulationOptions o;
  sim::make_car(o);
  o.beams = beams;
  o.robot.speed = 5;
  sim::Simulator simulator(world, path, o);
  Drive drive;
  const auto& all = world.scene().discs;
  while (auto event = simulator.next()) {
    const auto* scan = std::get_if<Scan>(&*event);
    if (!scan) continue;
    const Duration begin = drive.scans * simulator.scan_period();
    ++drive.scans;
    std::vector<std::size_t> met;
    for (const LandmarkSighting& s : find_trunks(*scan)) {
      // Neighbouring beams may be of two turns of the mirror: in between.
      const auto fired = [&](std::size_t i) {
        return sensor::beam_time(simulator.variant(), static_cast<int>(i));
      };
      const Pose2 T_world_laser =
          simulator.run().truth(begin + (fired(s.beam) + fired(s.beam + 1)) / 2) *
          simulator.mounting();
      const auto apart = [&](const sim::Disc& d) {
        return (T_world_laser.inverse() * d.centre - s.p_laser()).norm();
      };
      const auto nearest = std::min_element(
          all.begin(), all.end(),
          [&](const sim::Disc& a, const sim::Disc& b) { return apart(a) < apart(b); });
      if (apart(*nearest) > 1) {
        ++drive.strangers;
        continue;
      }
      const auto number = static_cast<std::size_t>(nearest - all.begin());
      drive.twice += std::count(met.begin(), met.end(), number) > 0;
      met.push_back(number);
      const Vec2 q = T_world_laser.inverse() * nearest->centre;
      drive.seen.push_back({s,
                            {s.range - q.norm(), wrap_angle(s.bearing - std::atan2(q.y(), q.x()))},
                            s.diameter - 2 * nearest->radius});
    }
  }
  return drive;
}

struct Chi {
  double range = 0, bearing = 0, diameter = 0;                 // mean of squared error by variance
  double range_bias = 0, bearing_bias = 0, diameter_bias = 0;  // m, rad, m
  int n = 0;
};
Chi chi(const std::vector<Seen>& seen, double nearest, double farthest) {
  Chi c;
  for (const Seen& s : seen) {
    if (s.sighting.range < nearest || s.sighting.range >= farthest) continue;
    ++c.n;
    c.range += std::pow(s.off.x() / s.sighting.range_sigma, 2);
    c.bearing += std::pow(s.off.y() / s.sighting.bearing_sigma, 2);
    c.diameter += std::pow(s.diameter_off / s.sighting.diameter_sigma, 2);
    c.range_bias += s.off.x(), c.bearing_bias += s.off.y(), c.diameter_bias += s.diameter_off;
  }
  for (double* v :
       {&c.range, &c.bearing, &c.diameter, &c.range_bias, &c.bearing_bias, &c.diameter_bias})
    *v /= std::max(1, c.n);
  return c;
}

// Mean of squared errors by stated variances. Stated is more than simulated close by: bark is no
// circle. Far off a thin trunk is seen only if it looks thick, so the diameter is off by then.
TEST(Trunks, ErrorsInTheSimulatedParkAreAsStated) {
  const Drive drive = drive_through_the_park(361);
  EXPECT_GT(drive.scans, 100);
  EXPECT_GT(drive.seen.size(), 5u * static_cast<std::size_t>(drive.scans));
  EXPECT_LT(drive.strangers, static_cast<int>(drive.seen.size()) / 100);  // two that look as one
  EXPECT_EQ(drive.twice, 0);
  for (const auto& [nearest, farthest] :
       {std::pair{0.0, 10.0}, {10.0, 20.0}, {20.0, 30.0}, {30.0, 45.0}}) {
    const Chi c = chi(drive.seen, nearest, farthest);
    SCOPED_TRACE(nearest);
    EXPECT_GT(c.n, 50);
    EXPECT_TRUE(c.range > 0.2 && c.range < 1.4) << c.range;
    EXPECT_TRUE(c.bearing > 0.2 && c.bearing < 1.4) << c.bearing;
    EXPECT_TRUE(c.diameter > 0.2 && c.diameter < 1.4) << c.diameter;
    EXPECT_LT(std::abs(c.range_bias), 0.06);
    EXPECT_LT(std::abs(c.bearing_bias), 0.001);
    EXPECT_LT(std::abs(c.diameter_bias), 0.1);
  }
}

// One degree apart: what two beams meet 30 m off is thicker than most trunks are.
TEST(Trunks, ErrorsOfACoarseScan) {
  const Drive drive = drive_through_the_park(181);
  EXPECT_LE(drive.strangers, 1);
  EXPECT_EQ(drive.twice, 0);
  for (const auto& [nearest, farthest] : {std::pair{0.0, 10.0}, {10.0, 20.0}, {20.0, 30.0}}) {
    const Chi c = chi(drive.seen, nearest, farthest);
    SCOPED_TRACE(nearest);
    EXPECT_GT(c.n, 40);
    EXPECT_TRUE(c.range > 0.2 && c.range < 1.4) << c.range;
    EXPECT_TRUE(c.bearing > 0.2 && c.bearing < 1.4) << c.bearing;
    EXPECT_TRUE(c.diameter > 0.2 && c.diameter < 1.4) << c.diameter;
  }
}

}  // namespace
}  // namespace majak::beacon
