// SPDX-License-Identifier: Apache-2.0
// Figure 18 of the thesis: obstacles on a grid grow by the robot's size, and robots that stand as
// near as they may: to the middles of obstacles' cells, to any part of them, and a robot that is no
// disc.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/map/inflation.hpp"

namespace majak::draw {
namespace {

constexpr double kCell = 0.1, kRadius = 0.27, kApart = 0.8;  // m
constexpr std::size_t kRobots = 4;
const map::Polygon kCart{{{0.5, 0.2}, {-0.2, 0.2}, {-0.2, -0.2}, {0.5, -0.2}}, radians(25)};

constexpr int kSide = 22;  // cells
constexpr map::CellBox kObstacles[] = {{5, 13, 1, 1}, {14, 15, 4, 2}, {17, 12, 1, 3},
                                       {7, 7, 2, 1},  {8, 6, 2, 1},   {9, 5, 2, 1}};

map::CellMask obstacles() {
  map::CellMask mask{kSide, kSide, std::vector<std::uint8_t>(std::size_t{kSide} * kSide)};
  for (const map::CellBox& box : kObstacles)
    for (int y = box.y0; y < box.y0 + box.height; ++y)
      for (int x = box.x0; x < box.x0 + box.width; ++x) mask.cells[mask.index(x, y)] = 1;
  return mask;
}

Vec2 middle(int ix, int iy) { return {(ix + 0.5) * kCell, (iy + 0.5) * kCell}; }

Polyline cell(int ix, int iy, const Colour& fill) {
  const double x = ix * kCell, y = iy * kCell;
  return {{{x, y}, {x + kCell, y}, {x + kCell, y + kCell}, {x, y + kCell}},
          {ink::light, 0.8},
          true,
          fill};
}

struct Place {
  Vec2 at;     // m
  double gap;  // m, to the nearest obstacle as the meaning has it
};

double gap(const map::CellMask& mask, const Vec2& p, map::InflationMeaning meaning) {
  const double half = meaning == map::InflationMeaning::touch ? kCell / 2 : 0;
  double least = 1e9;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (mask.at(x, y)) {
        const Vec2 off = (middle(x, y) - p).cwiseAbs() - Vec2(half, half);
        least = std::min(least, off.cwiseMax(0).norm());
      }
  return least;
}

/// Free cells nearest to the obstacles, no two robots in each other's way.
std::vector<Vec2> nearest_places(const map::CellMask& mask, const map::CellMask& blocked,
                                 map::InflationMeaning meaning) {
  std::vector<Place> free;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (!blocked.at(x, y)) free.push_back({middle(x, y), gap(mask, middle(x, y), meaning)});
  std::stable_sort(free.begin(), free.end(),
                   [](const Place& a, const Place& b) { return a.gap < b.gap - 1e-9; });
  std::vector<Vec2> chosen;
  for (const Place& place : free)
    if (chosen.size() < kRobots && std::all_of(chosen.begin(), chosen.end(), [&](const Vec2& p) {
          return (p - place.at).norm() > kApart;
        }))
      chosen.push_back(place.at);
  return chosen;
}

void add_robot(Panel& panel, const Vec2& p, const map::Footprint& robot) {
  const Pen pen{ink::blue, 1.8};
  const Colour fill = ink::sky.faint(0.25);
  if (const auto* disc = std::get_if<map::Disc>(&robot)) {
    panel.marks.emplace_back(circle(point(p), disc->radius, pen, fill));
    return;
  }
  const auto& polygon = std::get<map::Polygon>(robot);
  Polyline outline{{}, pen, true, fill};
  for (const Vec2& corner : polygon.corners)
    outline.points.push_back(point(Pose2{p.x(), p.y(), *polygon.heading} * corner));
  panel.marks.emplace_back(outline);
}

Panel inflated(const Box& place, const std::string& title, const map::Footprint& robot,
               map::InflationMeaning meaning) {
  const map::CellMask mask = obstacles();
  const map::CellMask blocked = map::inflate(mask, kCell, robot, meaning);
  Panel panel{.place = place, .title = title, .x = {"x (m)", -0.1, 2.4}, .y = {"y (m)", -0.1, 2.4}};
  Dots middles{{}, 1.6, ink::white}, robots{{}, 2.5, ink::blue};
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      panel.marks.emplace_back(cell(x, y,
                                    mask.at(x, y)      ? ink::black
                                    : blocked.at(x, y) ? ink::orange.faint(0.45)
                                                       : ink::white));
      if (mask.at(x, y)) middles.at.push_back(point(middle(x, y)));
    }
  panel.marks.emplace_back(middles);
  for (const Vec2& p : nearest_places(mask, blocked, meaning)) {
    add_robot(panel, p, robot);
    robots.at.push_back(point(p));
  }
  panel.marks.emplace_back(robots);
  return panel;
}

}  // namespace

Figure figure_inflation(const std::vector<Event>& /*events*/) {
  Figure figure{.width = 1380,
                .height = 540,
                .title = "Obstacles grow by the robot's size, the robot is a point"};
  const Box all = figure.whole();
  const double width = all.width / 3;
  const auto third = [&](int k) { return Box{width * k, all.top, width, all.height}; };
  const map::Disc disc{kRadius};
  figure.panels = {
      inflated(third(0), "Kept clear: the middles of obstacles' cells", disc,
               map::InflationMeaning::centre),
      inflated(third(1), "Kept clear: all of obstacles' cells", disc, map::InflationMeaning::touch),
      inflated(third(2), "The same for a cart that heads 25\u00b0", kCart,
               map::InflationMeaning::touch)};
  return figure;
}

}  // namespace majak::draw
