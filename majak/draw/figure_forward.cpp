// SPDX-License-Identifier: Apache-2.0
// Figure 19 of the thesis: a corridor with doorways, seen by beams that are wide. Cells that are
// judged one by one close the narrow doorways, for a beam through them meets a door post; the
// forward model knows that the post explains it.
#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/map/forward_grid.hpp"
#include "majak/sim/world.hpp"

namespace majak::draw {
namespace {

constexpr double kCone = radians(18), kCell = 0.1, kNoise = 0.01;
constexpr int kRays = 15, kModelRays = 9;
constexpr double kWall = 2, kThick = 0.1, kLeft = -5, kRight = 6.5, kTop = 4;  // m
struct Doorway {
  double from, to;
};
constexpr Doorway kDoorways[] = {{-3, -2.5}, {0, 0.6}, {3, 3.9}};

sim::Scene corridor() {
  sim::Scene scene;
  const auto wall = [&](double x0, double y0, double x1, double y1) {
    scene.segments.push_back({{x0, y0}, {x1, y1}});
  };
  double x = kLeft;
  for (const Doorway& door : kDoorways) {
    for (const double y : {kWall, kWall + kThick}) wall(x, y, door.from, y);
    for (const double post : {door.from, door.to}) wall(post, kWall, post, kWall + kThick);
    x = door.to;
  }
  for (const double y : {kWall, kWall + kThick}) wall(x, y, kRight, y);
  wall(kLeft, 0, kRight, 0), wall(kLeft, kTop, kRight, kTop);
  wall(kLeft, 0, kLeft, kTop), wall(kRight, 0, kRight, kTop);
  for (const double between : {-1.2, 1.8}) wall(between, kWall + kThick, between, kTop);
  return scene;
}

PosedScan look(const sim::World& world, const Pose2& pose, std::uint64_t number) {
  PosedScan posed;
  posed.estimate.T_map_robot = pose;
  posed.scan.start_angle = -kPi / 2;
  posed.scan.angle_step = kPi / 60;
  posed.scan.max_range = 20;
  RandomStream random(3, number);
  for (std::size_t k = 0; k <= 60; ++k) {
    double nearest = 20;
    for (int ray = 0; ray < kRays; ++ray) {
      const double aside = kCone * (ray / (kRays - 1.0) - 0.5);
      nearest = std::min(
          nearest,
          world.cast(pose.translation(), pose.theta + posed.scan.angle(k) + aside, 20).range);
    }
    posed.scan.ranges.push_back(static_cast<float>(nearest + kNoise * random.normal()));
  }
  return posed;
}

/// Along the far wall and back, then once near the doorways.
Site drive(const sim::World& world) {
  Site site;
  const auto lane = [&](double y, double from, double to, int looks) {
    for (int i = 0; i < looks; ++i) {
      const double x = from + (to - from) * i / (looks - 1);
      site.scans.push_back(
          look(world, {x, y, (to > from ? 0 : kPi) + 0.02 * (i % 7)}, site.scans.size()));
    }
  };
  lane(0.5, kLeft + 0.6, kRight - 0.6, 90);
  lane(0.6, kRight - 0.6, kLeft + 0.6, 90);
  lane(1.2, kLeft + 0.6, kRight - 0.6, 30);
  return site;
}

Panel panel_of(const Box& place, const std::string& title, const map::OccupancyGrid& grid,
               const sim::Scene& scene, const Site& site) {
  Panel panel{.place = place,
              .title = title,
              .x = {"x (m)", kLeft - 0.3, kRight + 0.3},
              .y = {"y (m)", -1.1, kTop + 0.3}};
  panel.marks.emplace_back(grid_picture(grid));
  for (const sim::Segment& s : scene.segments)
    panel.marks.emplace_back(
        Polyline{{{s.a.x(), s.a.y()}, {s.b.x(), s.b.y()}}, {ink::orange, 1.2}});
  Dots path{{}, 1.4, ink::blue};
  for (const PosedScan& scan : site.scans)
    path.at.push_back({scan.estimate.T_map_robot.x, scan.estimate.T_map_robot.y});
  panel.marks.emplace_back(path);
  panel.legend = {{"walls as they are", Pen{ink::orange, 1.2}}, {"robot", {}, ink::blue}};
  panel.legend_at = Corner::bottom_right;
  return panel;
}

}  // namespace

Figure figure_forward(const std::vector<Event>& /*events*/) {
  const sim::Scene scene = corridor();
  const Site site = drive(sim::World(scene));
  map::OccupancyGridOptions standard;
  standard.resolution = kCell;
  standard.scan_spacing = standard.scan_turn = 0;
  map::ForwardGridOptions forward;
  forward.resolution = kCell;
  forward.scan_spacing = forward.scan_turn = 0;
  forward.beam_width = kCone;
  forward.rays = kModelRays;

  Figure figure{.width = 1000,
                .height = 1000,
                .title = "A corridor with three doorways, seen by beams 18\u00b0 wide"};
  Box half = figure.whole();
  half.height /= 2;
  const Box lower{half.left, half.top + half.height, half.width, half.height};
  figure.panels = {panel_of(half, "Standard: each cell by itself (log-odds)",
                            map::build_occupancy_grid(site, standard), scene, site),
                   panel_of(lower, "Forward model: all cells together",
                            map::build_forward_grid(site, forward).log_odds(), scene, site)};
  return figure;
}

}  // namespace majak::draw
