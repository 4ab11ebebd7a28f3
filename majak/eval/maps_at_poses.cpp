// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/maps_at_poses.hpp"

#include <algorithm>
#include <cmath>

#include "majak/eval/ate_rpe.hpp"
#include "majak/eval/true_walls.hpp"
#include "majak/map/dynamics.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/map/segment_map.hpp"

namespace majak::eval {
namespace {

constexpr double kOccupied = 0.6;  // log-odds from which on a cell is drawn as wall
constexpr double kDash = 0.05;     // m between points of a drawn segment

std::vector<Vec2> occupied_cells(const map::OccupancyGrid& grid) {
  std::vector<Vec2> cells;
  grid.for_each([&](int ix, int iy, float log_odds) {
    if (log_odds > kOccupied) cells.push_back(grid.resolution() * Vec2(ix + 0.5, iy + 0.5));
  });
  return cells;
}

GivenMap::Drawn occupancy_grid(const Site& site) {
  const auto grid = map::build_occupancy_grid(site);
  const double cell = grid.resolution() * grid.resolution();
  return {occupied_cells(grid), static_cast<std::size_t>(std::lround(grid.known_area() / cell)),
          grid.bytes()};
}

// In a plane the planes are the walls.
GivenMap::Drawn walls(const Site& site) {
  const std::vector<map::Segment> walls = map::build_segments(site).walls();
  GivenMap::Drawn drawn{{}, walls.size(), walls.size() * sizeof(map::Segment)};
  for (const map::Segment& wall : walls)
    for (double at = 0; at <= wall.length(); at += kDash)
      drawn.walls.push_back(wall.a + at * wall.direction());
  return drawn;
}

GivenMap::Drawn cells_over_time(const Site& site) {
  const auto dynamics = map::build_dynamics(site);
  const auto now = map::map_at(dynamics, dynamics.duration());
  const double cell = now.resolution() * now.resolution();
  return {occupied_cells(now), static_cast<std::size_t>(std::lround(now.known_area() / cell)),
          dynamics.bytes()};
}

const GivenMap kMaps[] = {
    {"occupancy-grid", "occupancy grids", "cells", occupancy_grid},
    {"multi-planar", "multi-planar maps", "walls", walls},
    {"dogma", "Dogma: cells that change with time", "cells", cells_over_time},
};

/// Scans where the truth knows them, at the poses that are asked for, in the truth's frame.
Site at_poses(const Site& site, const Trajectory& truth, PosesFrom from) {
  const TrajectoryIndex index(truth);
  Site posed;
  std::vector<PosePair> pairs;
  for (const PosedScan& s : site.scans) {
    const auto at = index.at(s.scan.time);
    if (!at || (from == PosesFrom::wheels && !s.T_odom_robot)) continue;
    posed.scans.push_back(s);
    Pose2& pose = posed.scans.back().estimate.T_map_robot;
    posed.scans.back().estimate.health = Health::ok;
    if (from == PosesFrom::truth) pose = at->pose;
    if (from == PosesFrom::wheels) pose = *s.T_odom_robot;
    pairs.push_back({s.scan.time, pose, at->pose, true});
  }
  const Pose2 T_truth_map = align(pairs);
  for (PosedScan& s : posed.scans) s.estimate.T_map_robot = T_truth_map * s.estimate.T_map_robot;
  return posed;
}

}  // namespace

std::span<const GivenMap> given_maps() { return kMaps; }

GivenScore try_given(const GivenMap& map, const Site& site, const Trajectory& truth,
                     PosesFrom poses, const std::function<double()>& clock) {
  const auto now = [&] { return clock ? clock() : 0; };
  const Site posed = at_poses(site, truth, poses);
  const Site right = at_poses(site, truth, PosesFrom::truth);
  GivenScore score;
  const double before = now();
  const GivenMap::Drawn drawn = map.draw(posed);
  score.cpu = now() - before;
  score.elements = drawn.elements;
  score.bytes = drawn.bytes;
  TrueWalls walls;
  for (std::size_t i = 0; i < right.scans.size(); ++i) {
    const Pose2& at = right.scans[i].estimate.T_map_robot;
    if (i > 0)
      score.way +=
          (at.translation() - right.scans[i - 1].estimate.T_map_robot.translation()).norm();
    if (right.scans[i].key) walls.add(right.scans[i].scan, at);
  }
  double sum = 0;
  for (const Vec2& p : drawn.walls) sum += walls.off(p);
  if (!drawn.walls.empty()) score.map_error = sum / static_cast<double>(drawn.walls.size());
  return score;
}

}  // namespace majak::eval
