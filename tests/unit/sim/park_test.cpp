// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/park.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::sim {
namespace {

const World& the_park() {
  static const World world(park());
  return world;
}
const Path& the_tour() {
  static const Path path = plan_tour(the_park());
  return path;
}

TEST(Park, IsAlwaysTheSame) {
  const Scene a = park(), b = park();
  ASSERT_EQ(a.discs.size(), b.discs.size());
  for (std::size_t i = 0; i < a.discs.size(); ++i) {
    EXPECT_EQ(a.discs[i].centre, b.discs[i].centre);
    EXPECT_EQ(a.discs[i].radius, b.discs[i].radius);
  }
}

TEST(Park, TwoHundredTrunksOfEveryWidthApartFromAllElse) {
  const Scene& scene = the_park().scene();
  EXPECT_NEAR(static_cast<double>(scene.discs.size()), 200, 20);
  int thin = 0, thick = 0;
  for (const Disc& d : scene.discs) {
    EXPECT_TRUE(d.radius >= 0.1 && d.radius <= 0.5);
    thin += d.radius<0.2, thick += d.radius> 0.35;
    EXPECT_TRUE(d.centre.x() > 0 && d.centre.x() < 250 && d.centre.y() > 0 && d.centre.y() < 200);
    for (const Segment& s : scene.segments) EXPECT_GT(distance_to(s, d.centre), d.radius + 0.5);
    for (const Disc& other : scene.discs) {
      if (&other == &d) continue;
      EXPECT_GT((other.centre - d.centre).norm(), d.radius + other.radius + 0.5);
    }
  }
  EXPECT_GT(thin, 30);
  EXPECT_GT(thick, 30);
}

// Share of the tour's points by which the car comes again more than half a minute later, and
// that in the opposite direction.
TEST(Park, TheTourComesByMostOfItsPlacesAgainInBothDirections) {
  const auto& points = the_tour().points;
  EXPECT_GT(length(points), 1500);
  EXPECT_LT(length(points), 2500);
  EXPECT_LT((points.back() - points.front()).norm(), 0.2);
  int again = 0, against = 0, all = 0;
  for (std::size_t i = 0; i + 1 < points.size(); i += 50, ++all) {
    bool seen = false, turned = false;
    for (std::size_t k = 0; k + 1 < points.size(); k += 5) {
      const bool later = std::max(i, k) - std::min(i, k) > 1000;  // 100 m
      if (!later || (points[k] - points[i]).norm() > 1) continue;
      seen = true;
      turned |= (points[k + 1] - points[k]).dot(points[i + 1] - points[i]) < 0;
    }
    again += seen, against += turned;
  }
  EXPECT_GT(again, all / 2);
  EXPECT_GT(against, all * 3 / 10);
  const Vec2 last = points.back() - points[points.size() - 2];
  EXPECT_NEAR(std::atan2(last.y(), last.x()), the_tour().start.theta, 0.05);
}

TEST(Park, ACarFollowsItsWays) {
  for (const double speed : {3.0, 5.0}) {
    SimulationOptions o;
    make_car(o);
    o.robot.speed = speed;
    const RobotRun run = drive_path(the_tour(), o.robot, 1);
    EXPECT_NEAR(run.path_length(), length(the_tour().points), 20);
    EXPECT_TRUE(to_seconds(run.duration()) > 300 && to_seconds(run.duration()) < 660);
    double nearest = 10;
    for (std::size_t i = 0; i < run.states().size(); i += 10) {
      const RobotState& s = run.states()[i];
      EXPECT_GE(s.twist.x(), 0);  // no shunting
      for (const double ahead : {0.0, o.mounting_x})
        nearest = std::min(nearest, the_park().clearance(s.T_world_robot * Vec2(ahead, 0)));
    }
    EXPECT_GT(nearest, 2);  // a car is less than 2 m wide
  }
}

// From anywhere on the way some trunks are near enough to be fixes, and most beams see nothing.
TEST(Park, TrunksAreInSightEverywhere) {
  const auto& points = the_tour().points;
  double beams = 0, open = 0;
  for (std::size_t i = 0; i < points.size(); i += 500) {
    std::vector<int> seen;
    for (double angle = -kPi; angle < kPi; angle += radians(0.5)) {
      const Hit hit = the_park().cast(points[i], angle, 40);
      ++beams, open += hit.object < 0;
      if (hit.object >= static_cast<int>(the_park().scene().segments.size()))
        seen.push_back(hit.object);
    }
    std::sort(seen.begin(), seen.end());
    EXPECT_GE(std::unique(seen.begin(), seen.end()) - seen.begin(), 4) << points[i].transpose();
  }
  EXPECT_GT(open, 0.5 * beams);
}

TEST(Tour, AStraightTourIsItsPolylineOrRefused) {
  Scene scene;
  scene.straight = true;
  scene.discs = {{{5, 2}, 0.5, 0.4}, {{-20, -20}, 0.5, 0.4}, {{20, 20}, 0.5, 0.4}};
  scene.start = {0, 0, 0};
  scene.tour = {{10, 0}, {10, 7}};
  const Path path = plan_tour(World(scene));
  EXPECT_NEAR(length(path.points), 17, 2 * kPathStep);
  for (const Vec2& p : path.points) EXPECT_TRUE(std::abs(p.y()) < 1e-9 || p.x() > 10 - 0.1);
  scene.tour = {{10, 4}};
  EXPECT_THROW(plan_tour(World(scene)), Error);  // across the first disc
}

}  // namespace
}  // namespace majak::sim
