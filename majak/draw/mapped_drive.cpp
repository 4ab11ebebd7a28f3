// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/mapped_drive.hpp"

#include <cmath>
#include <map>
#include <utility>
#include <variant>

#include "majak/draw/sketch.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::draw {

MappedDrive map_drive(const std::vector<Event>& events, const slam::GraphSlamOptions& options) {
  slam::GraphSlam slam(options, {});
  std::map<Time, Pose2> truth;
  for (const Event& event : events) {
    if (const auto* t = std::get_if<Truth>(&event)) truth[t->time] = t->T_world_robot;
    slam.add(event);
  }
  MappedDrive drive{slam.finish().site, {}, {}, {}, {}};
  for (const PosedScan& s : drive.site.scans) {
    drive.truth.push_back(truth.at(s.scan.time));
    drive.wheels.push_back(s.T_odom_robot.value_or(Pose2{}));
    drive.matching.push_back(s.T_map_robot_front_end);
    drive.closed.push_back(s.estimate.T_map_robot);
  }
  for (auto* poses : {&drive.wheels, &drive.matching, &drive.closed}) {
    const Pose2 T_world_map = drive.truth.front() * poses->front().inverse();
    for (Pose2& pose : *poses) pose = T_world_map * pose;
  }
  return drive;
}

std::vector<Pose2> laid_on_truth(const MappedDrive& drive, const Site& site) {
  const Pose2 T_world_map = drive.truth.front() * site.scans.front().estimate.T_map_robot.inverse();
  std::vector<Pose2> poses;
  for (const PosedScan& s : site.scans) poses.push_back(T_world_map * s.estimate.T_map_robot);
  return poses;
}

std::vector<double> place_errors(const MappedDrive& drive, std::span<const Pose2> poses) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < poses.size(); ++i)
    errors.push_back((poses[i].translation() - drive.truth[i].translation()).norm());
  return errors;
}

std::vector<Point> map_cells(const MappedDrive& drive, std::span<const Pose2> poses,
                             std::size_t first, std::size_t last, double cell) {
  constexpr int kLeast = 3;
  const match::ScanPointsOptions near{.max_range = 10};
  match::BeamDirections directions;
  std::map<std::pair<int, int>, int> hits;
  for (std::size_t i = first; i < last; ++i) {
    const auto points = match::scan_points(drive.site.scans[i].scan, near, false, directions);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec2 p = poses[i] * Vec2(points.x[k], points.y[k]);
      ++hits[{int(std::floor(p.x() / cell)), int(std::floor(p.y() / cell))}];
    }
  }
  std::vector<Point> cells;
  for (const auto& [at, count] : hits)
    if (count >= kLeast) cells.push_back({(at.first + 0.5) * cell, (at.second + 0.5) * cell});
  return cells;
}

std::vector<Point> way_through(std::span<const Pose2> poses) {
  std::vector<Point> way;
  for (const Pose2& pose : poses) way.push_back(point(pose.translation()));
  return simplify(way, 0.01);
}

void add_plan(std::vector<Mark>& marks, const sim::World& world, const Pen& pen) {
  for (const sim::Segment& s : world.scene().segments)
    marks.emplace_back(Polyline{{point(s.a), point(s.b)}, pen});
  for (const sim::Disc& d : world.scene().discs)
    marks.emplace_back(circle(point(d.centre), d.radius, pen));
}

}  // namespace majak::draw
