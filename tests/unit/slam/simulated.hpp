// SPDX-License-Identifier: Apache-2.0
// Simulated runs for the tests of SLAM, made once, and how far a result is from their truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/site.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::slam {

/// About 100 m through a built-in world, ordinary noise. Laps of 0: its short tour.
inline std::vector<Event> simulated_run(const std::string& world_name, int laps = 0,
                                        const sim::SimulationOptions& options = {}) {
  const sim::World world(sim::built_in(world_name));
  const sim::Path path =
      sim::plan_tour(world, {.laps = std::max(laps, 1), .short_tour = laps == 0});
  return sim::simulate(world, path, options);
}

inline const std::vector<Event>& building_run() {
  static const std::vector<Event> events = simulated_run("building");
  return events;
}

inline std::map<Time, Pose2> truth_of(const std::vector<Event>& events) {
  std::map<Time, Pose2> truth;
  for (const Event& e : events)
    if (const auto* t = std::get_if<Truth>(&e)) truth[t->time] = t->T_world_robot;
  return truth;
}

inline Site map_of(const std::vector<Event>& events, const GraphSlamOptions& options = {},
                   int threads = 1) {
  GraphSlam slam(options, {threads});
  for (const Event& event : events) slam.add(event);
  return slam.finish().site;
}

/// Position errors in m when the first poses are laid upon each other.
struct PathError {
  double rms = 0, worst = 0;
};
template <class PoseOf>
PathError error_of(const Site& site, const PoseOf& pose_of) {
  std::map<Time, Pose2> truth;
  for (const Truth& t : site.truth) truth[t.time] = t.T_world_robot;
  const PosedScan& first = site.scans.front();
  const Pose2 T_world_map = truth.at(first.scan.time) * pose_of(first).inverse();
  PathError error;
  for (const PosedScan& s : site.scans) {
    const Pose2 off = between(truth.at(s.scan.time), T_world_map * pose_of(s));
    error.rms += off.translation().squaredNorm() / static_cast<double>(site.scans.size());
    error.worst = std::max(error.worst, off.translation().norm());
  }
  error.rms = std::sqrt(error.rms);
  return error;
}
/// The same when the whole paths are laid upon each other: a first pose that is a little turned
/// does not count for all the others.
template <class PoseOf>
PathError shape_error_of(const Site& site, const PoseOf& pose_of) {
  std::map<Time, Pose2> truth;
  for (const Truth& t : site.truth) truth[t.time] = t.T_world_robot;
  Vec2 mean_here = Vec2::Zero(), mean_there = Vec2::Zero();
  for (const PosedScan& s : site.scans) {
    mean_here += pose_of(s).translation() / static_cast<double>(site.scans.size());
    mean_there += truth.at(s.scan.time).translation() / static_cast<double>(site.scans.size());
  }
  double c = 0, s = 0;
  for (const PosedScan& p : site.scans) {
    const Vec2 a = pose_of(p).translation() - mean_here;
    const Vec2 b = truth.at(p.scan.time).translation() - mean_there;
    c += a.dot(b), s += a.x() * b.y() - a.y() * b.x();
  }
  const Pose2 turn{0, 0, std::atan2(s, c)};
  PathError error;
  for (const PosedScan& p : site.scans) {
    const Vec2 off = turn * Vec2(pose_of(p).translation() - mean_here) -
                     (truth.at(p.scan.time).translation() - mean_there);
    error.rms += off.squaredNorm() / static_cast<double>(site.scans.size());
    error.worst = std::max(error.worst, off.norm());
  }
  error.rms = std::sqrt(error.rms);
  return error;
}
inline PathError error_of(const Site& site) {
  return error_of(site, [](const PosedScan& s) { return s.estimate.T_map_robot; });
}
inline PathError front_end_error_of(const Site& site) {
  return error_of(site, [](const PosedScan& s) { return s.T_map_robot_front_end; });
}

inline int closures_of(const Site& site) {
  return static_cast<int>(
      std::count_if(site.constraints.begin(), site.constraints.end(),
                    [](const Constraint& c) { return c.kind == ConstraintKind::closure; }));
}

}  // namespace majak::slam
