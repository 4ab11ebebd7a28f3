// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_map.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/tour.hpp"

namespace majak::map {
namespace {

Segment piece(const Vec2& a, const Vec2& b, double sigma = 0.01) {
  Segment s;
  s.a = a, s.b = b;
  s.covariance << sigma * sigma, 0, 0, 12 * sigma * sigma / (b - a).squaredNorm();
  s.sigma_a = s.sigma_b = 0.01;
  s.points = 10;
  return s;
}

// --- Worlds ------------------------------------------------------------------------------------

struct Look {
  int beams = 361;
  double field_of_view = kPi;
  double max_range = 30;
  double noise = 0;  ///< m
};

Scan look(const sim::World& world, const Pose2& T_map_robot, const Look& laser, int number) {
  Scan scan;
  scan.start_angle = -laser.field_of_view / 2;
  scan.angle_step = laser.field_of_view / (laser.beams - 1);
  scan.max_range = static_cast<float>(laser.max_range);
  RandomStream noise(3, static_cast<std::uint64_t>(number));
  for (int i = 0; i < laser.beams; ++i) {
    const double angle = T_map_robot.theta + scan.angle(static_cast<std::size_t>(i));
    const double range = world.cast(T_map_robot.translation(), angle, laser.max_range).range;
    scan.ranges.push_back(std::isfinite(range)
                              ? static_cast<float>(range + laser.noise * noise.normal())
                              : kNoReturn);
  }
  return scan;
}

Site drive(const sim::World& world, const std::vector<Pose2>& poses, const Look& laser) {
  Site site;
  for (const Pose2& pose : poses) {
    PosedScan posed;
    posed.scan = look(world, pose, laser, static_cast<int>(site.scans.size()));
    posed.estimate.T_map_robot = pose;
    site.scans.push_back(posed);
  }
  return site;
}

void outline(sim::Scene& scene, const std::vector<Vec2>& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i)
    scene.segments.push_back({corners[i], corners[(i + 1) % corners.size()], 0.6});
}

/// A bent room of 8 x 6 m; a box and a triangle stand in it.
sim::Scene polygons(bool box = true) {
  sim::Scene scene;
  outline(scene, {{0, 0}, {8, 0}, {8, 6}, {4.5, 6}, {4, 4}, {0, 4}});
  outline(scene, {{5.8, 3.2}, {6.8, 2.9}, {6.3, 4.2}});
  if (box) outline(scene, {{2, 1.6}, {3, 1.6}, {3, 2.4}, {2, 2.4}});
  return scene;
}

/// Round the box and the triangle, looking about.
std::vector<Pose2> round_trip() {
  const std::vector<Vec2> corners = {{1, 0.8}, {7.3, 0.8}, {7.3, 5.2}, {5.2, 5.2},
                                     {5, 3.2}, {1, 3.2},   {1, 0.8}};
  std::vector<Pose2> poses;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vec2 way = corners[i] - corners[i - 1];
    const int steps = static_cast<int>(std::ceil(way.norm() / 0.25));
    for (int k = 0; k < steps; ++k) {
      const Vec2 p = corners[i - 1] + way * k / steps;
      poses.push_back({p.x(), p.y(), wrap_angle(0.9 * static_cast<double>(poses.size()))});
    }
  }
  return poses;
}

/// The map's segments that are of this wall of a scene: near and along it, for a tenth of it.
std::vector<Segment> of_wall(const std::vector<Segment>& map, const sim::Segment& wall) {
  std::vector<Segment> found;
  const Vec2 t = (wall.b - wall.a).normalized();
  const double length = (wall.b - wall.a).norm();
  for (const Segment& s : map) {
    const double a = t.dot(s.a - wall.a), b = t.dot(s.b - wall.a);
    const double common = std::min(length, std::max(a, b)) - std::max(0.0, std::min(a, b));
    const double aside = std::abs(Segment::left_of(t).dot(s.middle() - wall.a));
    if (std::abs(t.dot(s.direction())) > std::cos(0.1) && aside < 0.04 && common > 0.1 * length)
      found.push_back(s);
  }
  return found;
}

double end_error(const Segment& s, const sim::Segment& wall) {
  return std::min(std::max((s.a - wall.a).norm(), (s.b - wall.b).norm()),
                  std::max((s.a - wall.b).norm(), (s.b - wall.a).norm()));
}

// --- Two segments ------------------------------------------------------------------------------

TEST(FusedSegments, AreTheLeastSquaresOfBoth) {
  const Segment a = piece({0, 0}, {2, 0}, 0.01), b = piece({3, 0.04}, {5, 0.04}, 0.02);
  const Segment both = fused(a, b);
  // The slow twin: normal equations of y = c + m x from each middle's offset and slope.
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Vec2 right = Vec2::Zero();
  for (const Segment& s : {a, b}) {
    const Vec2 at_middle(1, s.middle().x()), slope(0, 1);
    normal += at_middle * at_middle.transpose() / s.covariance(0, 0) +
              slope * slope.transpose() / s.covariance(1, 1);
    right += at_middle * s.middle().y() / s.covariance(0, 0);
  }
  const Vec2 line = normal.inverse() * right;
  EXPECT_NEAR(both.a.y(), line.x() + line.y() * both.a.x(), 3e-6);
  EXPECT_NEAR(both.b.y(), line.x() + line.y() * both.b.x(), 3e-6);
  EXPECT_NEAR(both.a.x(), 0, 1e-3);
  EXPECT_NEAR(both.b.x(), 5, 1e-3);
  const Vec2 at_middle(1, both.middle().x());
  EXPECT_NEAR(both.covariance(0, 0), at_middle.dot(normal.inverse() * at_middle), 1e-7);
  EXPECT_EQ(both.points, 20U);
  EXPECT_EQ(both.scans, 2U);
}

TEST(FusedSegments, DoNotHangOnTheirOrderOrTheFrame) {
  const Segment a = piece({0, 0}, {2, 0.1}, 0.01), b = piece({1.5, 0.04}, {4, 0.09}, 0.02);
  const Segment ab = fused(a, b), ba = fused(b, a);
  EXPECT_LT((ab.a - ba.a).norm(), 2e-4);  // first order in the turn between them
  EXPECT_LT((ab.b - ba.b).norm(), 2e-4);
  const Pose2 T{3, -1, 2};
  const Segment there = fused(moved(T, a), moved(T, b));
  EXPECT_LT((there.a - T * ab.a).norm(), 1e-12);
  EXPECT_LT((there.covariance - ab.covariance).norm(), 1e-12);
}

TEST(FusedSegments, AnExactOneStaysWhereItIs) {
  Segment exact = piece({0, 0}, {2, 0});
  exact.covariance.setZero();
  const Segment seen = piece({1, 0.03}, {3, 0.05});
  const Segment both = fused(exact, seen);
  EXPECT_NEAR(both.b.y(), 0, 1e-12);
  EXPECT_NEAR(both.b.x(), 3, 1e-12);
  EXPECT_NEAR(fused(seen, exact).b.y(), 0, 2e-4);
  EXPECT_NEAR(fused(exact, exact).b.y(), 0, 1e-12);
}

TEST(SameWall, ByThresholds) {
  const SegmentMapOptions o;
  const Segment wall = piece({0, 0}, {4, 0});
  EXPECT_TRUE(same_wall(wall, piece({1, 0.04}, {2, 0.04}), o));
  EXPECT_FALSE(same_wall(wall, piece({1, 0.06}, {2, 0.06}), o)) << "beside it";
  EXPECT_FALSE(same_wall(wall, piece({1, -0.1}, {2, 0.1}), o)) << "turned";
  EXPECT_TRUE(same_wall(wall, piece({4.2, 0}, {5, 0}), o));
  EXPECT_FALSE(same_wall(wall, piece({4.4, 0}, {5, 0}), o)) << "behind a gap";
  EXPECT_FALSE(same_wall(wall, piece({2, 0}, {1, 0}), o)) << "its other side";
  for (const Segment& s : {piece({1, 0.05}, {2, 0.08}), piece({3.9, 0}, {4.6, 0.1})})
    EXPECT_EQ(same_wall(wall, s, o), same_wall(s, wall, o));
}

TEST(SameWall, ByMahalanobisLooksAtTheCovariance) {
  SegmentMapOptions o;
  o.correspondence = Correspondence::mahalanobis;
  o.pose_sigma = 0;
  const Segment wall = piece({0, 0}, {4, 0}, 0.001);
  EXPECT_TRUE(same_wall(wall, piece({1, 0.029}, {2, 0.029}, 0.01), o));
  EXPECT_FALSE(same_wall(wall, piece({1, 0.032}, {2, 0.032}, 0.01), o));  // sqrt(9.21) = 3.03
  EXPECT_TRUE(same_wall(wall, piece({1, 0.15}, {2, 0.15}, 0.05), o));
  EXPECT_FALSE(same_wall(wall, piece({4.4, 0}, {5, 0}, 0.05), o));
}

// --- The steps ---------------------------------------------------------------------------------

TEST(SegmentMapSteps, PairsAreFoundAndTheBestIsKept) {
  const SegmentMap map({}, {piece({0, 0}, {2, 0}), piece({2.2, 0}, {5, 0}), piece({0, 9}, {2, 9})});
  const std::vector<Segment> seen = {piece({1.5, 0.01}, {4, 0.01}), piece({7, 0}, {8, 0})};
  const auto pairs = map.find_pairs(seen);
  EXPECT_EQ(pairs, (std::vector<SegmentPair>{{0, 0}, {1, 0}}));
  EXPECT_EQ(map.keep_good(pairs, seen), (std::vector<SegmentPair>{{1, 0}}));
}

TEST(SegmentMapSteps, APieceBetweenTwoMakesThemOne) {
  SegmentMap map({}, {piece({0, 0}, {2, 0}), piece({0, 9}, {2, 9}), piece({2.5, 0}, {5, 0})});
  const std::vector<Segment> seen = {piece({1.5, 0}, {3, 0}), piece({0, 4}, {2, 4})};
  map.update(seen, map.keep_good(map.find_pairs(seen), seen));
  ASSERT_EQ(map.segments().size(), 3U);
  EXPECT_NEAR(map.segments()[0].length(), 5, 1e-12);
  EXPECT_EQ(map.segments()[0].scans, 3U);
  EXPECT_NEAR(map.segments()[2].a.y(), 4, 1e-12);
}

TEST(SegmentMapSteps, TwoPiecesOfOneScanAreOneSight) {
  SegmentMap map({}, {piece({0, 0}, {5, 0})});
  const std::vector<Segment> seen = {piece({0, 0}, {2, 0}), piece({3, 0}, {5, 0})};
  map.update(seen, map.keep_good(map.find_pairs(seen), seen));
  EXPECT_EQ(map.segments()[0].scans, 2U);
}

TEST(SegmentMapSteps, WhatBeamsPassThroughIsRemovedInTime) {
  sim::Scene scene;
  outline(scene, {{-5, -5}, {5, -5}, {5, 5}, {-5, 5}});
  const sim::World world(scene);
  SegmentMapOptions o;
  o.removal_scans = 3;
  // In the air; on the wall; behind the wall; behind the robot's back.
  const Segment air = piece({2, -1}, {2, 1}), wall = piece({5, -1}, {5, 1}),
                behind = piece({6, -1}, {6, 1}), back = piece({-2, 1}, {-2, -1});
  SegmentMap map(o, {air, wall, behind, back});
  const Scan scan = look(world, {}, {}, 0);
  std::vector<SegmentPair> pairs = {{1, 0}};
  EXPECT_TRUE(map.remove_passed(scan, {}, pairs).empty());
  EXPECT_TRUE(map.remove_passed(scan, {}, pairs).empty());
  const auto removed = map.remove_passed(scan, {}, pairs);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed[0].a, air.a);
  EXPECT_EQ(map.segments().size(), 3U);
  EXPECT_EQ(pairs[0].map, 0U) << "numbers are mended";
}

TEST(SegmentMapSteps, SeeingItAgainSavesIt) {
  sim::Scene scene;
  outline(scene, {{-5, -5}, {5, -5}, {5, 5}, {-5, 5}});
  const Scan scan = look(sim::World(scene), {}, {}, 0);
  SegmentMapOptions o;
  o.removal_scans = 2;
  SegmentMap map(o, {piece({2, -1}, {2, 1})});
  std::vector<SegmentPair> none, match = {{0, 0}};
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(map.remove_passed(scan, {}, none).empty());
    EXPECT_TRUE(map.remove_passed(scan, {}, match).empty());
  }
}

// --- Whole maps --------------------------------------------------------------------------------

class SegmentMapOfPolygons : public testing::TestWithParam<Correspondence> {};

TEST_P(SegmentMapOfPolygons, HasEachWallOnceAndNothingElse) {
  SegmentMapOptions o;
  o.correspondence = GetParam();
  for (const double noise : {0.0, 0.01}) {
    const sim::World world(polygons());
    const Site site = drive(world, round_trip(), {361, kPi, 30, noise});
    const auto walls = build_segments(site, o).walls();
    EXPECT_EQ(walls.size(), world.scene().segments.size());
    for (const sim::Segment& wall : world.scene().segments) {
      const auto found = of_wall(walls, wall);
      ASSERT_EQ(found.size(), 1U) << wall.a.transpose() << " " << noise;
      EXPECT_LT(end_error(found[0], wall), 0.02) << wall.a.transpose() << " " << noise;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Both, SegmentMapOfPolygons,
                         testing::Values(Correspondence::thresholds, Correspondence::mahalanobis));

TEST(SegmentMap, ForgetsAnObstacleThatIsGone) {
  Site site = drive(sim::World(polygons(true)), round_trip(), {});
  const std::size_t before = build_segments(site).walls().size();
  const Site after = drive(sim::World(polygons(false)), round_trip(), {});
  site.scans.insert(site.scans.end(), after.scans.begin(), after.scans.end());
  const auto walls = build_segments(site).walls();
  EXPECT_EQ(walls.size(), before - 4);
  for (const Segment& s : walls) EXPECT_GT(distance_to(s, {2.5, 2.0}), 1);
}

TEST(SegmentMap, KnownBeforehandIsKeptAndGrows) {
  const sim::World world(polygons());
  const Site site = drive(world, round_trip(), {});
  const auto first = build_segments(site).walls();
  SegmentMap map({}, first);
  for (const PosedScan& posed : site.scans) map.add(posed.scan, posed.estimate.T_map_robot);
  ASSERT_EQ(map.walls().size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_LT((map.walls()[i].a - first[i].a).norm(), 0.01);
    EXPECT_GT(map.walls()[i].points, first[i].points);
  }
}

TEST(SegmentMap, TurnsWithThePoses) {
  const sim::World world(polygons());
  Site site = drive(world, round_trip(), {361, kPi, 30, 0.01});
  SegmentMapOptions o;
  o.refinement.enabled = false;  // its squares do not turn
  const auto plain = build_segments(site, o).walls();
  const Pose2 T{-20, 7, 2.2};
  for (PosedScan& posed : site.scans) posed.estimate.T_map_robot = T * posed.estimate.T_map_robot;
  const auto turned = build_segments(site, o).walls();
  ASSERT_EQ(turned.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_LT((turned[i].a - T * plain[i].a).norm(), 1e-9);
    EXPECT_LT((turned[i].b - T * plain[i].b).norm(), 1e-9);
  }
}

bool in_a_pillar(const sim::World& world, const Vec2& corner) {
  const auto& discs = world.scene().discs;
  return std::any_of(discs.begin(), discs.end(), [&](const sim::Disc& d) {
    return (d.centre - corner).norm() < d.radius + 0.02;
  });
}

// Rooms with doors, furniture and pillars; every wall has two faces 15 cm apart.
TEST(SegmentMap, OfABuilding) {
  const sim::World world(sim::building());
  const sim::Path path = sim::plan_tour(world);
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i + 3 < path.points.size(); i += 3) {
    const Vec2 way = path.points[i + 3] - path.points[i];
    poses.push_back({path.points[i].x(), path.points[i].y(), std::atan2(way.y(), way.x())});
  }
  const Site site = drive(world, poses, {361, kPi, 30, 0.01});
  const auto walls = build_segments(site).walls();

  // What the laser saw of each straight thing: from the first to the last hit, in steps of 5 cm.
  const auto& scene = world.scene().segments;
  std::vector<std::vector<int>> hit(scene.size());
  for (const Pose2& pose : poses)
    for (int i = 0; i < 361; ++i) {
      const double angle = pose.theta - kPi / 2 + i * kPi / 360;
      const sim::Hit at = world.cast(pose.translation(), angle, 30);
      if (at.object < 0 || at.object >= static_cast<int>(scene.size())) continue;
      const auto object = static_cast<std::size_t>(at.object);
      const double length = (scene[object].b - scene[object].a).norm();
      const Vec2 p = pose.translation() + at.range * Vec2(std::cos(angle), std::sin(angle));
      hit[object].resize(static_cast<std::size_t>(std::ceil(length / 0.05)));
      ++hit[object][std::min(hit[object].size() - 1,
                             static_cast<std::size_t>((p - scene[object].a).norm() / 0.05))];
    }
  int whole = 0, once = 0, ends = 0, exact = 0, inside = 0;
  double seen = 0, mapped = 0, worst = 0;
  for (std::size_t k = 0; k < scene.size(); ++k) {
    const double share =
        static_cast<double>(hit[k].size() -
                            static_cast<std::size_t>(std::count(hit[k].begin(), hit[k].end(), 0))) /
        std::max(1.0, static_cast<double>(hit[k].size()));
    for (std::size_t i = 0; i < hit[k].size(); ++i) {
      if (hit[k][i] < 3) continue;  // three returns of 5 cm make it seen
      const Vec2 t = (scene[k].b - scene[k].a).normalized();
      const Vec2 p = scene[k].a + (static_cast<double>(i) + 0.5) * 0.05 * t;
      seen += 0.05;
      mapped += 0.05 * std::any_of(walls.begin(), walls.end(),
                                   [&](const Segment& s) { return distance_to(s, p) < 0.02; });
    }
    if ((scene[k].b - scene[k].a).norm() < 1 || share < 0.98) continue;
    const auto found = of_wall(walls, scene[k]);
    ++whole;
    once += found.size() == 1;
    if (found.size() != 1) continue;
    const bool same_way = found[0].direction().dot(scene[k].b - scene[k].a) > 0;
    for (const bool at_b : {false, true}) {
      const Vec2 corner = at_b == same_way ? scene[k].b : scene[k].a;
      const auto& near = at_b == same_way ? hit[k].back() : hit[k].front();
      if (near < 3 || in_a_pillar(world, corner)) continue;
      const Vec2 error = (at_b ? found[0].b : found[0].a) - corner;
      const Eigen::Matrix2d c = at_b ? covariance_of_b(found[0]) : covariance_of_a(found[0]);
      ++ends;
      exact += error.norm() < 0.02;
      inside += error.dot(c.inverse() * error) < 5.991;
      worst = std::max(worst, error.norm());
    }
  }
  double length = 0, right = 0;
  for (const Segment& s : walls)
    for (double u = 0.025; u < s.length(); u += 0.05) {
      length += 0.05;
      right += 0.05 * (world.clearance(s.a + u * s.direction()) < 0.02);
    }
  EXPECT_EQ(whole, 40);
  EXPECT_EQ(once, whole) << "one wall is one segment";
  EXPECT_GE(exact, ends - 1) << "of " << ends;
  EXPECT_LT(worst, 0.08) << "m; of the end of a wall that was seen whole";
  EXPECT_GE(inside, 0.9 * ends) << "95 % ellipses";
  EXPECT_GT(mapped / seen, 0.99);
  EXPECT_GT(right / length, 0.995);
}

// --- What was done -----------------------------------------------------------------------------

TEST(SegmentMap, LogsItsSteps) {
  const sim::World world(polygons());
  SegmentMapOptions o;
  o.refinement.enabled = false;
  const Site site = drive(world, round_trip(), {361, kPi, 30, 0.01});
  std::vector<SegmentSteps> log;
  const SegmentMap map = build_segments(site, o, &log);
  ASSERT_EQ(log.size(), site.scans.size());
  int in_map = 0;
  for (const SegmentSteps& s : log) {
    EXPECT_LE(s.kept, s.pairs);
    EXPECT_EQ(s.kept + s.inserted, s.seen);
    in_map += s.inserted - s.removed - s.merged;
    EXPECT_EQ(s.in_map, in_map);
  }
  EXPECT_EQ(map.segments().size(), static_cast<std::size_t>(in_map));
}

TEST(SegmentMap, OptionsOutOfRangeAndEmptySites) {
  SegmentMapOptions o;
  o.max_distance = -1;
  EXPECT_THROW(build_segments(Site{}, o), Error);
  EXPECT_TRUE(build_segments(Site{}).segments().empty());
}

TEST(SegmentMap, LostScansTellNothing) {
  Site site = drive(sim::World(polygons()), round_trip(), {});
  for (PosedScan& posed : site.scans) posed.estimate.health = Health::lost;
  EXPECT_TRUE(build_segments(site).segments().empty());
}

}  // namespace
}  // namespace majak::map
