// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/beacons.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::localize {
namespace {

const beacon::BeaconMap kHall = {{{1, {0, 0}, ""}, {2, {20, 2}, ""}, {3, {8, 19}, ""}}};

std::vector<BeaconSighting> bearings_from(const Pose2& pose, Time time) {
  std::vector<BeaconSighting> out;
  for (const beacon::Beacon& b : kHall.beacons) {
    const Vec2 way = pose.inverse() * b.p_map;
    BeaconSighting s;
    s.time = time;
    s.beacon = b.number;
    s.bearing = std::atan2(way.y(), way.x());
    s.bearing_sigma = 0.001;
    out.push_back(s);
  }
  return out;
}

TEST(Beacons, SightingsOfOneTimeAreOneEstimate) {
  const Localizer method = beacons(kHall);
  int estimates = 0;
  for (int i = 0; i < 4; ++i) {
    for (const BeaconSighting& s : bearings_from({9.0 + 0.1 * i, 8, 0.2 * i}, i * kSecond))
      estimates += method.add(s).has_value();
  }
  EXPECT_EQ(estimates, 3);
  const Localization run = method.finish();
  ASSERT_EQ(run.estimates.size(), 4U);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(run.estimates[i].time, i * kSecond);
    EXPECT_NEAR(run.estimates[i].T_map_robot.x, 9 + 0.1 * i, 1e-9);
    EXPECT_NEAR(run.estimates[i].T_map_robot.theta, 0.2 * i, 1e-9);
    EXPECT_GT(run.estimates[i].covariance(0, 0), 0);
  }
  EXPECT_TRUE(run.report.empty());
}

TEST(Beacons, CountsWhatGivesNoFix) {
  const Localizer method = beacons(kHall);
  auto seen = bearings_from({9, 8, 0}, 0);
  seen[1].beacon = 77;
  for (const BeaconSighting& s : seen) method.add(s);
  method.add(Odometry{});
  method.add(Scan{});
  const Localization run = method.finish();
  EXPECT_TRUE(run.estimates.empty());
  EXPECT_EQ(run.report.entries().at("sightings of unknown beacons").count, 1);
  EXPECT_EQ(run.report.entries().at("no fix: too few beacons for a fix").count, 1);
}

TEST(Beacons, ReflectorsAloneLocalizeARobotInARing) {
  sim::Scene scene = sim::built_in("ring");
  beacon::BeaconMap map;
  RandomStream random(1);
  // Along both walls, every two metres or so.
  for (double along = 1; along < 29; along += random.uniform(1.5, 2.5)) {
    for (const Vec2& p : {Vec2(along, 0.2), Vec2(along, 20.1)})
      map.beacons.push_back({static_cast<int>(map.beacons.size()), p, ""});
    if (along > 2.5 && along < 17.5) {
      for (const Vec2& p : {Vec2(0.3, along), Vec2(30.1, along)})
        map.beacons.push_back({static_cast<int>(map.beacons.size()), p, ""});
    }
  }
  for (const beacon::Beacon& b : map.beacons) scene.discs.push_back(sim::reflector(b.p_map));
  const sim::World world(std::move(scene));
  sim::SimulationOptions options;
  options.intensities = true;
  options.beams = 361;
  const Localizer method = beacons(map);
  std::map<Time, Pose2> truth;
  int scans = 0;
  for (const Event& e : simulate(world, sim::plan_tour(world, {.short_tour = true}), options)) {
    if (const auto* t = std::get_if<Truth>(&e)) truth[t->time] = t->T_world_robot;
    scans += std::holds_alternative<Scan>(e);
    method.add(e);
  }
  const Localization run = method.finish();
  EXPECT_GT(static_cast<double>(run.estimates.size()),
            0.5 * scans);  // seen: 0.57, with half the circle
  int near = 0;
  for (const Estimate& e : run.estimates) {
    const Pose2 d = between(truth.at(e.time), e.T_map_robot);
    near += d.translation().norm() < 0.1 && std::abs(d.theta) < radians(1.5);
  }
  EXPECT_GT(near, 0.98 * static_cast<double>(run.estimates.size()));
}

}  // namespace
}  // namespace majak::localize
