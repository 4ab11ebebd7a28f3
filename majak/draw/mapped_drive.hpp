// SPDX-License-Identifier: Apache-2.0
// Simulated drives that were mapped, for figures: the same drive by truth, by wheels, by matching
// alone and with its loops closed.
#pragma once

#include <span>
#include <vector>

#include "majak/core/event.hpp"
#include "majak/core/site.hpp"
#include "majak/draw/figure.hpp"
#include "majak/sim/world.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::draw {

/// Poses T_world_robot, one a scan; all ways are laid on the true one where they begin.
struct MappedDrive {
  Site site;
  std::vector<Pose2> truth;
  std::vector<Pose2> wheels;    ///< odometry alone
  std::vector<Pose2> matching;  ///< scan by scan, before any loop is closed
  std::vector<Pose2> closed;    ///< the finished estimate
};

/// `events` with a Truth for every scan, as simulators write them.
MappedDrive map_drive(const std::vector<Event>& events, const slam::GraphSlamOptions& options);

/// The poses of another map of the same scans, laid on the true way where it begins.
std::vector<Pose2> laid_on_truth(const MappedDrive& drive, const Site& site);

/// How far each pose is from its true place, m.
std::vector<double> place_errors(const MappedDrive& drive, std::span<const Pose2> poses);

/// The map that scans [first, last) make at these poses: centres of the cells (`cell` m wide) in
/// which three returns or more from at most 10 m lie.
std::vector<Point> map_cells(const MappedDrive& drive, std::span<const Pose2> poses,
                             std::size_t first, std::size_t last, double cell);

std::vector<Point> way_through(std::span<const Pose2> poses);

void add_plan(std::vector<Mark>& marks, const sim::World& world, const Pen& pen);

}  // namespace majak::draw
