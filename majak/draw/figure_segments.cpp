// SPDX-License-Identifier: Apache-2.0
// Figure 22 of the thesis: one place as a grid of 380 x 380 cells and as segments, and what each of
// them takes.
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/sim/world.hpp"

namespace majak::draw {
namespace {

constexpr int kSide = 380;                                              // cells
constexpr double kCell = 0.05;                                          // m
constexpr double kNoise = 0.01;                                         // m, of a range
constexpr double kStep = 0.2;                                           // m, between scans
constexpr double kLeft = 8.3, kRight = 10.7, kLow = 6.4, kHigh = 12.5;  // m, inner walls

/// A corridor with three rooms on either side, 18.4 m square; tables and a cupboard.
sim::World storey() {
  sim::Scene scene;
  const auto wall = [&](const Vec2& a, const Vec2& b) { scene.segments.push_back({a, b, 0.6}); };
  const auto box = [&](double x, double y, double w, double h) {
    wall({x, y}, {x + w, y}), wall({x + w, y}, {x + w, y + h});
    wall({x + w, y + h}, {x, y + h}), wall({x, y + h}, {x, y});
  };
  box(0.3, 0.3, 18.4, 18.4);
  for (const double x : {kLeft, kRight}) {
    wall({x, 0.3}, {x, 2.5}), wall({x, 3.5}, {x, 8.7});
    wall({x, 9.7}, {x, 15}), wall({x, 16}, {x, 18.7});
  }
  for (const double y : {kLow, kHigh}) wall({0.3, y}, {kLeft, y}), wall({kRight, y}, {18.7, y});
  box(3, 1.2, 1.6, 0.8);
  box(14, 14.5, 0.8, 2.2);
  return sim::World(scene);
}

/// Along the corridor, and into each room and out again.
std::vector<Vec2> tour() {
  std::vector<Vec2> way = {{9.5, 1}};
  for (const double y : {3.0, 9.2, 15.5})
    for (const Vec2& p : {Vec2(9.5, y), Vec2(2, y), Vec2(9.5, y), Vec2(17, y), Vec2(9.5, y)})
      way.push_back(p);
  way.push_back({9.5, 17.5});
  return way;
}

PosedScan look(const sim::World& world, const Vec2& from, RandomStream& random) {
  PosedScan posed;
  posed.scan.start_angle = -kPi;
  posed.scan.angle_step = radians(0.5);
  posed.scan.max_range = 30;
  posed.estimate.T_map_robot = {from.x(), from.y(), 0};
  for (std::size_t i = 0; i < 720; ++i) {
    const double range = world.cast(from, posed.scan.angle(i), 30).range;
    posed.scan.ranges.push_back(
        std::isfinite(range) ? static_cast<float>(range + kNoise * random.normal()) : kNoReturn);
  }
  return posed;
}

Site drive() {
  const sim::World world = storey();
  Site site;
  RandomStream random(22, 0);
  const std::vector<Vec2> corners = tour();
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vec2 way = corners[i] - corners[i - 1];
    const int steps = static_cast<int>(std::ceil(way.norm() / kStep));
    for (int k = 0; k < steps; ++k)
      site.scans.push_back(look(world, corners[i - 1] + way * k / steps, random));
  }
  return site;
}

Colour colour_of(const map::OccupancyGrid& grid, int ix, int iy) {
  if (!grid.known(ix, iy)) return {205, 205, 205};
  const auto grey = static_cast<std::uint8_t>(
      std::lround(255 / (1 + std::exp(static_cast<double>(grid.log_odds(ix, iy))))));
  return {grey, grey, grey};
}

Panel panel_of(const Box& place, std::string title) {
  return {.place = place,
          .title = std::move(title),
          .x = {"x (m)", 0, kSide * kCell},
          .y = {"y (m)", 0, kSide * kCell}};
}

}  // namespace

Figure figure_segments(const std::vector<Event>&) {
  const Site site = drive();
  const map::OccupancyGrid grid = map::build_occupancy_grid(site, {.resolution = kCell});
  const std::vector<map::Segment> walls = map::build_segments(site).walls();
  const std::size_t bytes = walls.size() * 4 * sizeof(double);
  constexpr int kCells = kSide * kSide;

  Figure figure{.width = 1200, .height = 680, .title = "One place as cells and as segments"};
  const double half = figure.width / 2, high = figure.height - 40;
  figure.panels.push_back(panel_of({0, 40, half, high},
                                   fmt::format("{0} x {0} = {1} cells, {1} bytes", kSide, kCells)));
  if (auto picture = cells_picture({0, 0, kSide, kSide}, kCell,
                                   [&](int x, int y) { return colour_of(grid, x, y); }))
    figure.panels[0].marks.emplace_back(std::move(*picture));
  figure.panels.push_back(
      panel_of({half, 40, half, high},
               fmt::format("{} segments, {} bytes: {:.0f} to 1", walls.size(), bytes,
                           kCells / static_cast<double>(std::max<std::size_t>(bytes, 1)))));
  std::vector<Point> ends;
  for (const map::Segment& wall : walls) {
    figure.panels[1].marks.emplace_back(Polyline{{point(wall.a), point(wall.b)}, {ink::blue, 1.8}});
    ends.push_back(point(wall.a)), ends.push_back(point(wall.b));
  }
  figure.panels[1].marks.emplace_back(Dots{ends, 2.2, ink::red});
  return figure;
}

}  // namespace majak::draw
