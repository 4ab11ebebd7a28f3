// SPDX-License-Identifier: Apache-2.0
// Figure 7: three directions give place and heading; and how well, over the plane.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "majak/beacon/triangulation.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

constexpr double kSigma = 0.1;  // degrees
constexpr double kField = 20, kCell = 0.25;
const Pose2 kRobot{11, 7, 0.5};
const std::array<Vec2, 3> kBeacons = {Vec2(4, 4), Vec2(17, 6), Vec2(9, 15)};
const std::array<Colour, 3> kInks = {ink::blue, ink::green, ink::orange};

/// Steps of the map: up to so many metres; the last is where no ellipse holds.
struct Band {
  double most;
  Colour colour;
  const char* words;
};
const std::array<Band, 6> kBands{{{0.02, {20, 80, 130}, "up to 2 cm"},
                                  {0.03, {60, 135, 175}, "up to 3 cm"},
                                  {0.05, {135, 190, 190}, "up to 5 cm"},
                                  {0.1, {215, 225, 175}, "up to 10 cm"},
                                  {HUGE_VAL, {250, 205, 110}, "more than 10 cm"},
                                  {HUGE_VAL, {185, 45, 40}, "reported: no ellipse holds"}}};

std::array<beacon::BearingTo, 3> bearings_at(const Pose2& pose) {
  std::array<beacon::BearingTo, 3> out;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 way = kBeacons[i] - pose.translation();
    out[i] = {kBeacons[i], angle_diff(std::atan2(way.y(), way.x()), pose.theta), radians(kSigma)};
  }
  return out;
}

/// The circle through three points.
Ellipse circle_through(const Vec2& a, const Vec2& b, const Vec2& c, Pen pen) {
  const Vec2 u = b - a, v = c - a;
  const double d = 2 * (u.x() * v.y() - u.y() * v.x());
  const Vec2 centre = Vec2(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                           u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) /
                      d;
  return circle(point(a + centre), centre.norm(), pen);
}

std::size_t band_at(const Vec2& p) {
  const auto fix = beacon::triangulate(bearings_at({p.x(), p.y(), 0}));
  if (fix.problem != beacon::FixProblem::none) return kBands.size() - 1;
  const double error = std::sqrt(fix.covariance.topLeftCorner<2, 2>().trace());
  std::size_t band = 0;
  while (error > kBands[band].most) ++band;
  return band;
}

/// Rows of cells, each run of one band a box.
void add_field(std::vector<Mark>& marks) {
  const int n = static_cast<int>(kField / kCell);
  for (int row = 0; row < n; ++row) {
    const double y = row * kCell;
    for (int from = 0, to = 0; from < n; from = to) {
      const std::size_t band = band_at({(from + 0.5) * kCell, y + kCell / 2});
      for (to = from + 1; to < n && band_at({(to + 0.5) * kCell, y + kCell / 2}) == band;) ++to;
      const double x0 = from * kCell, x1 = to * kCell, y1 = y + kCell;
      const Colour& colour = kBands[band].colour;
      marks.push_back(Polyline{{{x0, y}, {x1, y}, {x1, y1}, {x0, y1}}, {colour, 1}, true, colour});
    }
  }
}

void add_beacons(std::vector<Mark>& marks, bool coloured) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Colour colour = coloured ? kInks[i] : ink::black;
    marks.push_back(Dots{{point(kBeacons[i])}, 5.5, colour});
    marks.push_back(
        Label{point(kBeacons[i]), "B" + std::to_string(i + 1), 8, 8, Anchor::start, 16, colour});
  }
}

Panel directions(const Box& place) {
  Panel panel{.place = place, .title = "three bearings, three circles, one place"};
  panel.x = {"x (m)", -2, 22};
  panel.y = {"y (m)", -5, 19};
  const Vec2 robot = kRobot.translation();
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    panel.marks.push_back(circle_through(robot, kBeacons[i], kBeacons[next], {ink::grey, 1.3, 5}));
    panel.marks.push_back(Polyline{{point(robot), point(kBeacons[i])}, {kInks[i], 2}});
  }
  add_beacons(panel.marks, true);
  const auto fix = beacon::triangulate(bearings_at(kRobot));
  const Vec2 found = fix.T_map_sensor.translation();
  const Vec2 ahead = fix.T_map_sensor * Vec2(3, 0);
  panel.marks.push_back(Arrow{point(found), point(ahead), {ink::red, 2.4}});
  panel.marks.push_back(Dots{{point(found)}, 4, ink::red});
  panel.legend = {{"direction measured", Pen{ink::blue, 2}},
                  {"sees two beacons under one angle", Pen{ink::grey, 1.3, 5}},
                  {"heading", Pen{ink::red, 2.4}}};
  return panel;
}

Panel field(const Box& place) {
  Panel panel{.place = place, .title = "error of position by 0.1 degrees of bearing"};
  panel.x = {"x (m)", 0, kField + 10.5};  // room for the legend
  panel.y = {"y (m)", 0, kField};
  add_field(panel.marks);
  panel.marks.push_back(circle_through(kBeacons[0], kBeacons[1], kBeacons[2], {ink::black, 2, 6}));
  add_beacons(panel.marks, false);
  for (const Band& band : kBands) panel.legend.push_back({band.words, {}, band.colour});
  panel.legend.push_back({"danger circle", Pen{ink::black, 2, 6}});
  panel.legend_at = Corner::top_right;
  return panel;
}

}  // namespace

Figure figure_triangulation(const std::vector<Event>&) {
  Figure figure{.width = 1320, .height = 600, .title = "Triangulation by three beacons"};
  const Box whole = figure.whole();
  figure.panels = {directions({0, whole.top, 540, whole.height}),
                   field({540, whole.top, 780, whole.height})};
  return figure;
}

}  // namespace majak::draw
