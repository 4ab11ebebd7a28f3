// SPDX-License-Identifier: Apache-2.0
#include "majak/map/edits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/map/returns.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "tests/support/ascii_room.hpp"

namespace majak::map {
namespace {

using Points = std::vector<Vec2>;

const fixture::AsciiRoom& hall() {
  static const fixture::AsciiRoom room({
      "################",
      "#..............#",
      "#.a....#....b..#",
      "#..............#",
      "#..............#",
      "#.d.........c..#",
      "################",
  });
  return room;
}

/// Looked at from the four corners; every second scan is a key scan.
Site hall_site() {
  Site site;
  int seed = 1;
  for (const char place : {'a', 'b', 'c', 'd'})
    for (int turn = 0; turn < 4; ++turn) {
      PosedScan posed;
      posed.estimate.T_map_robot = hall().pose(place, wrap_angle(0.3 + turn * kPi / 2));
      posed.estimate.covariance = Vec3(4, 1, 9).asDiagonal();
      posed.estimate.weak_direction = {1, 0};
      posed.T_map_robot_front_end = posed.estimate.T_map_robot * Pose2{0.1, 0, 0};
      auto laser = fixture::all_around(720);
      laser.T_robot_laser = {0.1, 0.05, 0.2};
      laser.seed = seed++;
      posed.scan = hall().scan(posed.estimate.T_map_robot, laser);
      posed.scan.time = static_cast<Time>(site.scans.size()) * kSecond;
      posed.key = turn % 2 == 0;
      site.scans.push_back(std::move(posed));
    }
  return site;
}

Edit a_turn(double radians) {
  Edit edit;
  edit.kind = EditKind::turn;
  edit.radians = radians;
  return edit;
}

Points box(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

void expect_near(const Points& a, const Points& b, double tolerance = 1e-12) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT((a[i] - b[i]).norm(), tolerance) << i;
}

bool occupied(const OccupancyGrid& grid, const Vec2& p) {
  return grid.log_odds(static_cast<int>(std::floor(p.x() / grid.resolution())),
                       static_cast<int>(std::floor(p.y() / grid.resolution()))) > 0;
}
bool known(const OccupancyGrid& grid, const Vec2& p) {
  return grid.known(static_cast<int>(std::floor(p.x() / grid.resolution())),
                    static_cast<int>(std::floor(p.y() / grid.resolution())));
}

/// The pillar in the hall, whose traces are to go.
const Points kPillar = box(3.2, 1.7, 4.3, 2.9);
const Vec2 kOnPillar(3.52, 2.25);

// ---- Points that move along -----------------------------------------------------------------

TEST(AnchoredPoints, LieWhereTheyWereSet) {
  Site site = hall_site();
  for (const double turned : {0.0, 0.7, -2.9}) {
    add_edit(site, a_turn(turned));
    const Edit edit = anchored(with_edits(site), EditKind::erase, kPillar);
    for (const AnchoredPoint& p : edit.points) EXPECT_TRUE(site.scans[p.scan].key);
    expect_near(points_in_map(with_edits(site), edit), kPillar);
    undo_edit(site);
  }
}

TEST(AnchoredPoints, HangOnTheNearestKeyScan) {
  const Site site = hall_site();
  const Vec2 near_c = hall().place('c') + Vec2(0.2, 0.4);
  const Edit edit = anchored(site, EditKind::wall, Points{near_c, hall().place('a')});
  EXPECT_EQ(edit.points[0].scan, 8U);
  EXPECT_EQ(edit.points[1].scan, 0U);
}

TEST(AnchoredPoints, GoAlongWithTheirScansEachOnItsOwn) {
  Site site = hall_site();
  const Points line = {hall().place('a') + Vec2(0, 0.3), hall().place('b') + Vec2(0.1, 0.2)};
  const Edit edit = anchored(site, EditKind::wall, line);
  const Pose2 bend{0.4, -0.2, 0.1};
  site.scans[4].estimate.T_map_robot = bend * site.scans[4].estimate.T_map_robot;
  expect_near(points_in_map(site, edit), {line[0], bend * line[1]});
  for (PosedScan& posed : site.scans)
    posed.estimate.T_map_robot = bend * posed.estimate.T_map_robot;
  expect_near(points_in_map(site, edit), {bend * line[0], bend * (bend * line[1])});
}

TEST(AnchoredPoints, StayInAPartOfTheSite) {
  Site site = hall_site();
  add_edit(site, anchored(site, EditKind::forbidden, kPillar));
  add_edit(site, a_turn(0.4));
  for (const Site& whole : {site, with_edits(site)}) {
    const Site part = selected(whole, {.from = 6.5});
    ASSERT_EQ(part.edits.size(), 2U);
    expect_near(points_in_map(part, part.edits[0]), points_in_map(whole, whole.edits[0]));
  }
}

TEST(AnchoredPoints, AreRefusedWhereTheyAreNone) {
  const Site site = hall_site();
  EXPECT_THROW(anchored(site, EditKind::erase, Points{{0, 0}, {1, 0}}), Error);
  EXPECT_THROW(anchored(site, EditKind::wall, Points{{0, 0}}), Error);
  EXPECT_THROW(anchored(site, EditKind::wall, Points{{0, 0}, {NAN, 0}}), Error);
  EXPECT_THROW(anchored(site, EditKind::wall, Points{{0, 0}, {1e5, 0}}), Error);
  EXPECT_THROW(anchored(Site{}, EditKind::wall, Points{{0, 0}, {1, 0}}), Error);
}

// ---- The list of edits ----------------------------------------------------------------------

TEST(Edits, CountUpAndAreTakenBackFromTheEnd) {
  Site site = hall_site();
  for (const double r : {0.1, 0.2, 0.4}) add_edit(site, a_turn(r));
  EXPECT_EQ(site.edits[0].id, 1);
  EXPECT_EQ(site.edits[2].id, 3);
  EXPECT_NEAR(turn_of(site), 0.7, 1e-15);
  EXPECT_EQ(undo_edit(site)->radians, 0.4);
  EXPECT_NEAR(turn_of(site), 0.3, 1e-15);
  undo_edit(site), undo_edit(site);
  EXPECT_FALSE(undo_edit(site));
  EXPECT_THROW(add_edit(site, a_turn(NAN)), Error);
}

TEST(Edits, SwitchClosuresThatThereAre) {
  Site site = hall_site();
  site.constraints.resize(2);
  site.constraints[0].kind = ConstraintKind::closure, site.constraints[0].to = 5;
  site.constraints[1].kind = ConstraintKind::match, site.constraints[1].to = 6;
  EXPECT_THROW(switch_closure(site, 0, 6, false), Error);
  EXPECT_THROW(switch_closure(site, 0, 5, true), Error);
  switch_closure(site, 0, 5, false);
  add_edit(site, a_turn(1));
  EXPECT_THROW(switch_closure(site, 0, 5, false), Error);
  switch_closure(site, 0, 5, true);
  ASSERT_EQ(site.edits.size(), 1U);
  EXPECT_EQ(site.edits[0].kind, EditKind::turn);
}

TEST(Edits, AppliedTwiceAreAppliedOnce) {
  Site site = hall_site();
  add_edit(site, anchored(site, EditKind::erase, kPillar));
  add_edit(site, a_turn(0.5));
  const Site once = with_edits(site), twice = with_edits(once);
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    EXPECT_EQ(once.scans[i].estimate.T_map_robot, twice.scans[i].estimate.T_map_robot);
    EXPECT_EQ(once.scans[i].scan.ranges, twice.scans[i].scan.ranges);
  }
}

// ---- Erasing --------------------------------------------------------------------------------

TEST(Erased, AreTheReturnsInsideAndNoOthers) {
  Site site = hall_site();
  add_edit(site, anchored(site, EditKind::erase, kPillar));
  const Site shown = with_edits(site);
  int inside_polygon = 0;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const Scan& scan = site.scans[i].scan;
    const Pose2 T = site.scans[i].estimate.T_map_robot * scan.T_robot_laser;
    for (std::size_t b = 0; b < scan.ranges.size(); ++b) {
      const float r = scan.ranges[b];
      const Vec2 p = T * Vec2(r * std::cos(scan.angle(b)), r * std::sin(scan.angle(b)));
      const bool in = p.x() > 3.2 && p.x() < 4.3 && p.y() > 1.7 && p.y() < 2.9;
      inside_polygon += in;
      ASSERT_EQ(shown.scans[i].scan.ranges[b], in ? -r : r);
    }
  }
  EXPECT_GT(inside_polygon, 100);
}

TEST(Erased, LeaveNothingButTheWayThereWasFree) {
  Site site = hall_site();
  const OccupancyGrid before = build_occupancy_grid(site);
  add_edit(site, anchored(site, EditKind::erase, kPillar));
  const OccupancyGrid grid = build_occupancy_grid(with_edits(site));
  EXPECT_TRUE(occupied(before, kOnPillar));
  int free_before = 0, free_after = 0;
  grid.for_each([&](int ix, int iy, float log_odds) {
    const Vec2 p((ix + 0.5) * 0.05, (iy + 0.5) * 0.05);
    EXPECT_FALSE(inside(kPillar, p) && log_odds > 0) << p.transpose();
  });
  before.for_each([&](int ix, int iy, float log_odds) {
    if (log_odds < 0) ++free_before, free_after += grid.log_odds(ix, iy) < 0;
  });
  EXPECT_EQ(free_after, free_before);  // what was free stays so
}

TEST(Erased, MakeNoWalls) {
  Site site = hall_site();
  const std::size_t before = build_segments(site, {.min_scans = 1}).walls().size();
  add_edit(site, anchored(site, EditKind::erase, kPillar));
  const auto walls = build_segments(with_edits(site), {.min_scans = 1}).walls();
  EXPECT_LT(walls.size(), before);
  for (const Segment& wall : walls) EXPECT_FALSE(inside(kPillar, wall.middle()));
}

TEST(Cropped, NothingOutsideIsKnown) {
  Site site = hall_site();
  const Points left = box(-1, -1, 4, 10), low = box(-1, -1, 20, 2);
  add_edit(site, anchored(site, EditKind::crop, left));
  const OccupancyGrid half = build_occupancy_grid(with_edits(site));
  add_edit(site, anchored(site, EditKind::crop, low));
  const OccupancyGrid quarter = build_occupancy_grid(with_edits(site));
  const OccupancyGrid whole = build_occupancy_grid(hall_site());
  whole.for_each([&](int ix, int iy, float log_odds) {
    const Vec2 p((ix + 0.5) * 0.05, (iy + 0.5) * 0.05);
    EXPECT_EQ(half.known(ix, iy), p.x() < 4) << p.transpose();
    EXPECT_EQ(quarter.known(ix, iy), p.x() < 4 && p.y() < 2) << p.transpose();
    EXPECT_TRUE(p.x() > 4 || half.log_odds(ix, iy) == log_odds) << p.transpose();
  });
  EXPECT_GT(half.known_area(), 5);
  EXPECT_GT(quarter.known_area(), 2);
}

// ---- Drawing --------------------------------------------------------------------------------

TEST(DrawnWalls, AreInTheGridAndAmongTheSegments) {
  Site site = hall_site();
  const Points glass = {{5.02, 0.6}, {5.02, 2.9}, {7, 2.9}};
  EXPECT_FALSE(occupied(build_occupancy_grid(site), {5.02, 1.5}));
  const auto before = build_segments(site).walls();
  add_edit(site, anchored(site, EditKind::wall, glass));
  const Site shown = with_edits(site);
  const OccupancyGrid grid = build_occupancy_grid(shown);
  for (double y = 0.61; y < 2.9; y += 0.01) EXPECT_TRUE(occupied(grid, {5.02, y})) << y;
  for (double x = 5.02; x < 7; x += 0.01) EXPECT_TRUE(occupied(grid, {x, 2.9})) << x;
  EXPECT_FALSE(occupied(grid, {5.08, 1.5}));  // a cell thick
  EXPECT_FALSE(occupied(grid, {4.96, 1.5}));
  const auto walls = build_segments(shown).walls();
  ASSERT_EQ(walls.size(), before.size() + 2);
  EXPECT_LT((walls[before.size()].a - glass[0]).norm(), 1e-9);
  EXPECT_LT((walls.back().b - glass[2]).norm(), 1e-9);
  SegmentMapOptions raw;
  raw.refinement.enabled = false;
  EXPECT_EQ(build_segments(shown, raw).walls().size(), build_segments(site, raw).walls().size());
}

TEST(Forbidden, ZonesAreNotFreeAndNothingElseChanges) {
  Site site = hall_site();
  const KnownMap free = known_map(build_occupancy_grid(site));
  const Points zone = {{1.02, 0.7}, {2.6, 1.1}, {1.4, 1.9}};
  add_edit(site, anchored(site, EditKind::forbidden, zone));
  EXPECT_EQ(known_map(build_occupancy_grid(site)).cells, free.cells);
  KnownMap known = free;
  forbid(known, site);
  for (int iy = 0; iy < known.height; ++iy)
    for (int ix = 0; ix < known.width; ++ix) {
      // Slow twin: samples of the cell.
      bool touches = false, near = false;
      for (int u = -4; u <= 4; ++u)
        for (int v = -4; v <= 4; ++v) {
          touches |= inside(zone, known.centre(ix, iy) + Vec2(u, v) * 0.0062);
          near |= inside(zone, known.centre(ix, iy) + Vec2(u, v) * 0.0066);
        }
      EXPECT_TRUE(!touches || known.at(ix, iy) == CellState::unknown);
      EXPECT_TRUE(near || known.at(ix, iy) == free.at(ix, iy)) << known.centre(ix, iy).transpose();
    }
  EXPECT_LT(known.area(CellState::free), free.area(CellState::free) - 0.5);
}

/// Slow twin: each return by inside(), which looks at all sides.
TEST(Erased, ByALassoOfManyCornersAreTheSame) {
  Site site = hall_site();
  RandomStream random(6);
  Points lasso;
  for (int i = 0; i < 700; ++i) {
    const double angle = 2 * kPi * i / 700, r = random.uniform(0.7, 2.5);
    lasso.emplace_back(3.7 + r * std::cos(angle), 2.2 + r * std::sin(angle));
  }
  const Edit edit = anchored(site, EditKind::erase, lasso);
  add_edit(site, edit);
  const Site shown = with_edits(site);
  const Points corners = points_in_map(site, edit);
  int erased = 0;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const Scan& scan = site.scans[i].scan;
    const Pose2 T = site.scans[i].estimate.T_map_robot * scan.T_robot_laser;
    for (std::size_t b = 0; b < scan.ranges.size(); ++b) {
      const float r = scan.ranges[b];
      const bool in =
          inside(corners, T * Vec2(r * Vec2(std::cos(scan.angle(b)), std::sin(scan.angle(b)))));
      erased += in;
      ASSERT_EQ(shown.scans[i].scan.ranges[b], in ? -r : r) << i << " " << b;
    }
  }
  EXPECT_GT(erased, 1000);
}

TEST(Inside, IsTheSumOfAngles) {
  RandomStream random(4);
  const Points star = {{0, 3}, {1, 1}, {3, 0}, {1, -1}, {0, -3}, {-1, -1}, {-3, 0}, {-1, 1}};
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p(random.uniform(-3.5, 3.5), random.uniform(-3.5, 3.5));
    double sum = 0;
    for (std::size_t k = 0; k < star.size(); ++k) {
      const Vec2 a = star[k] - p, b = star[(k + 1) % star.size()] - p;
      sum += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
    EXPECT_EQ(inside(star, p), std::abs(sum) > kPi) << p.transpose();
  }
}

// ---- Turning --------------------------------------------------------------------------------

TEST(Turned, SitesAreTheSameInAnotherFrame) {
  const Site site = hall_site();
  Site turned = site;
  add_edit(turned, a_turn(0.6));
  add_edit(turned, a_turn(0.2));
  const Site shown = with_edits(turned);
  const Pose2 T{0, 0, 0.8};
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const PosedScan &a = site.scans[i], &b = shown.scans[i];
    const Pose2 off = between(T * a.estimate.T_map_robot, b.estimate.T_map_robot);
    EXPECT_LT(off.vector().norm(), 1e-12);
    EXPECT_LT(between(T * a.T_map_robot_front_end, b.T_map_robot_front_end).vector().norm(), 1e-12);
    // The ellipse turns: its larger axis has been x.
    EXPECT_NEAR(least_known(b.estimate.covariance).sigma, 2, 1e-12);
    EXPECT_NEAR(std::abs(least_known(b.estimate.covariance).direction.dot(T * Vec2(1, 0))), 1,
                1e-12);
    EXPECT_NEAR(b.estimate.covariance(2, 2), 9, 1e-12);
    EXPECT_LT((b.estimate.weak_direction - T * Vec2(1, 0)).norm(), 1e-12);
    EXPECT_EQ(a.scan.ranges, b.scan.ranges);
  }
  undo_edit(turned), undo_edit(turned);
  EXPECT_EQ(with_edits(turned).scans[3].estimate.T_map_robot, site.scans[3].estimate.T_map_robot);
}

/// At its true poses, seen with ordinary noise.
Site at_truth(const std::string& world_name) {
  const sim::World world(sim::built_in(world_name));
  const sim::Path path = sim::plan_tour(world, {.short_tour = true});
  Site site;
  Pose2 pose;
  for (const Event& event : sim::simulate(world, path, {})) {
    if (const auto* truth = std::get_if<Truth>(&event)) pose = truth->T_world_robot;
    if (const auto* scan = std::get_if<Scan>(&event)) {
      PosedScan posed;
      posed.scan = *scan;
      posed.estimate.T_map_robot = pose;
      site.scans.push_back(std::move(posed));
    }
  }
  return site;
}

TEST(MainDirection, IsFoundToAFifthOfADegree) {
  for (const char* world : {"building", "ring"}) {
    Site site = at_truth(world);
    for (const double degree : {0.0, 17.3, 44.0, -30.0, 89.0}) {
      site.edits = {a_turn(radians(degree))};
      const auto direction = main_direction(with_edits(site));
      ASSERT_TRUE(direction) << world;
      double off = degrees(*direction) - degree;
      off -= 90 * std::round(off / 90);
      EXPECT_LT(std::abs(off), 0.06) << world << " turned by " << degree;  // 0.04
      EXPECT_LE(std::abs(*direction), kPi / 4);
    }
  }
}

TEST(MainDirection, ComesWithTheTurnAndThenIsNone) {
  Site site = at_truth("ring");
  add_edit(site, a_turn(0.1));
  EXPECT_NEAR(*main_direction(with_edits(site)), *main_direction(site) + 0.1, 1e-9);
  add_edit(site, a_turn(-*main_direction(with_edits(site))));
  EXPECT_NEAR(*main_direction(with_edits(site)), 0, 1e-9);
  EXPECT_FALSE(main_direction(Site{}));
}

}  // namespace
}  // namespace majak::map
