// SPDX-License-Identifier: Apache-2.0
#include "majak/methods/kalman_with_laser.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::methods {
namespace {

// Largest distance from the truth, from a common start.
double worst(const localize::Localizer& method, const std::vector<Event>& events) {
  std::map<Time, Pose2> truth;
  for (const Event& event : events) {
    if (const auto* t = std::get_if<Truth>(&event)) truth[t->time] = t->T_world_robot;
    method.add(event);
  }
  double far = 0;
  const Pose2 start = truth.begin()->second;
  for (const Estimate& e : method.finish().estimates) {
    const auto t = truth.find(e.time);
    if (t == truth.end()) continue;
    far = std::max(far,
                   (between(start, t->second).translation() - e.T_map_robot.translation()).norm());
  }
  return far;
}

TEST(KalmanWithLaser, MatchedScansKeepBadWheelsOnTheWay) {
  const sim::World world(sim::built_in("building"));
  sim::SimulationOptions options;
  options.robot.left_scale = 1.02;  // the odometry drives circles
  const auto events =
      sim::simulate(world, sim::plan_tour(world, {.laps = 1, .short_tour = true}), options);
  const double with = worst(kalman_with_laser({}, {}, {}), events);
  const double without = worst(localize::kalman({}, {}, {}), events);
  EXPECT_GT(without, 5);
  EXPECT_LT(with, without / 4);
}

TEST(KalmanWithLaser, RearScansAreNotMatched) {
  const sim::World world(sim::built_in("ring"));
  auto events = sim::simulate(world, sim::plan_tour(world, {.laps = 1, .short_tour = true}), {});
  std::vector<Event> behind;
  for (Event event : events) {
    if (auto* scan = std::get_if<Scan>(&event)) scan->laser = 1;
    behind.push_back(std::move(event));
  }
  const auto a = kalman_with_laser({}, {}, {}), b = localize::kalman({}, {}, {});
  for (const Event& event : behind) a.add(event), b.add(event);
  EXPECT_EQ(a.finish().estimates.back().T_map_robot, b.finish().estimates.back().T_map_robot);
}

}  // namespace
}  // namespace majak::methods
