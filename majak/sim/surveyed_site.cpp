// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/surveyed_site.hpp"

#include <map>
#include <utility>

namespace majak::sim {

Site surveyed_site(const World& world, const Path& path, const SimulationOptions& options) {
  Site site;
  site.source_name = world.scene().name;
  Simulator simulator(world, path, options);
  std::map<Time, Pose2> poses;
  while (auto event = simulator.next()) {
    if (const auto* truth = std::get_if<Truth>(&*event)) {
      site.truth.push_back(*truth);
      poses[truth->time] = truth->T_world_robot;
    } else if (auto* scan = std::get_if<Scan>(&*event)) {
      PosedScan posed;
      posed.estimate.time = scan->time;
      posed.scan = std::move(*scan);
      site.scans.push_back(std::move(posed));
    }
  }
  for (PosedScan& s : site.scans)
    s.estimate.T_map_robot = s.T_map_robot_front_end = poses.at(s.scan.time);
  return site;
}

}  // namespace majak::sim
