// SPDX-License-Identifier: Apache-2.0
// From the simulator's brightness to numbered sightings, and how good they are.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "majak/beacon/reflectors.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::beacon {
namespace {

/// Along the walls of the ring's corridor, unevenly.
const BeaconMap kRing = {{{1, {4, 0.1}, ""},
                          {2, {9, 2.0}, ""},
                          {3, {17, 0.1}, ""},
                          {4, {22.5, 2.0}, ""},
                          {5, {30.2, 5}, ""},
                          {6, {28.3, 9.5}, ""},
                          {7, {30.2, 16}, ""},
                          {8, {24, 20.2}, ""},
                          {9, {13, 18.4}, ""},
                          {10, {5, 20.2}, ""},
                          {11, {0.2, 14}, ""},
                          {12, {2.0, 8}, ""}}};

struct Drive {
  std::vector<Scan> scans;
  std::map<Time, Pose2> truth;
};

Drive simulated(int seed, int beams) {
  sim::Scene scene = sim::built_in("ring");
  for (const Beacon& b : kRing.beacons) scene.discs.push_back(sim::reflector(b.p_map));
  const sim::World world(std::move(scene));
  sim::SimulationOptions options;
  options.seed = seed;
  options.beams = beams;
  options.intensities = true;
  Drive run;
  for (const Event& event :
       sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), options)) {
    if (const auto* scan = std::get_if<Scan>(&event)) run.scans.push_back(*scan);
    if (const auto* truth = std::get_if<Truth>(&event))
      run.truth[truth->time] = truth->T_world_robot;
  }
  return run;
}

TEST(SimulatedReflectors, AreSeenWhereTheyStandWithinTheirSigmas) {
  int seen = 0, scans = 0, wrong = 0;
  double range_nis = 0, bearing_nis = 0;
  for (const int seed : {1, 2}) {
    const Drive run = simulated(seed, 361);
    for (std::size_t i = 0; i < run.scans.size(); i += 5, ++scans) {
      const Pose2 truth = run.truth.at(run.scans[i].time);
      // Beams are fired one after the other: in a curve the last one is turned against the first.
      const bool turns = i > 0 && std::abs(angle_diff(run.truth.at(run.scans[i - 1].time).theta,
                                                      truth.theta)) > 0.005;
      if (turns) continue;
      PosePrior prior{truth, Mat3::Zero()};
      prior.covariance.diagonal() << 0.04, 0.04, 0.0025;
      const auto found = find_reflectors(run.scans[i]);
      const auto named = associate(found, kRing, prior);
      wrong += static_cast<int>(found.size() - named.size());
      for (const BeaconSighting& s : named) {
        const Vec2 way = (truth * s.T_robot_sensor).inverse() * kRing.find(s.beacon)->p_map;
        range_nis += std::pow((*s.range - way.norm()) / s.range_sigma, 2);
        bearing_nis +=
            std::pow(angle_diff(*s.bearing, std::atan2(way.y(), way.x())) / s.bearing_sigma, 2);
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 1.05 * scans);
  EXPECT_LT(wrong, 0.025 * seen);
  EXPECT_NEAR(range_nis / seen, 1, 0.5);    // seen: 1.1
  EXPECT_NEAR(bearing_nis / seen, 1, 0.5);  // seen: 0.6
}

TEST(SimulatedReflectors, TellWhoTheyAreWithoutAPrior) {
  const Drive run = simulated(4, 361);
  int named = 0, right = 0;
  for (std::size_t i = 0; i < run.scans.size(); i += 5) {
    const Pose2 truth = run.truth.at(run.scans[i].time);
    for (const BeaconSighting& s : sightings(run.scans[i], kRing)) {
      const Vec2 way = (truth * s.T_robot_sensor).inverse() * kRing.find(s.beacon)->p_map;
      right += std::abs(way.norm() - *s.range) < 0.3;
      ++named;
    }
  }
  EXPECT_GT(named, 40);
  EXPECT_GT(right, 0.99 * named);
}

TEST(SimulatedReflectors, WithoutThemNothingShines) {
  const sim::World world(sim::built_in("building"));
  sim::SimulationOptions options;
  options.intensities = true;
  sim::Simulator simulator(world, sim::plan_tour(world, {.short_tour = true}), options);
  int scans = 0, found = 0;
  while (const auto event = simulator.next()) {
    if (const auto* scan = std::get_if<Scan>(&*event)) {
      ++scans;
      found += static_cast<int>(find_reflectors(*scan).size());
    }
  }
  EXPECT_GT(scans, 1000);
  EXPECT_LT(found, 0.02 * scans);
}

}  // namespace
}  // namespace majak::beacon
