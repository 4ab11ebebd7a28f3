// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "majak/draw/thesis_figures.hpp"
#include "majak/motion/drive.hpp"

namespace majak::draw {
namespace {

constexpr double kWheelbase = 1.2, kTrack = 0.8, kSteering = 0.5;  // m, m, rad
const Pen kThin{ink::grey, 1.2, 5}, kBody{ink::black, 2.2}, kWay{ink::blue, 2.4};

/// A wheel as a narrow box, its axle across.
Polyline wheel(const Vec2& at, double heading, const Colour& colour) {
  constexpr double kHalfLength = 0.15, kHalfWidth = 0.045;
  const Pose2 T{at.x(), at.y(), heading};
  Polyline box{{}, {colour, 1.6}, true, colour.faint(0.85)};
  for (const Vec2& corner : {Vec2(1, 1), Vec2(-1, 1), Vec2(-1, -1), Vec2(1, -1)}) {
    const Vec2 p = T * Vec2(corner.x() * kHalfLength, corner.y() * kHalfWidth);
    box.points.push_back({p.x(), p.y()});
  }
  return box;
}

/// Part of a circle about a centre, directions in rad.
std::vector<Point> arc(const Point& centre, double radius, double from, double to) {
  std::vector<Point> points;
  for (int i = 0; i <= 60; ++i) {
    const double t = from + (to - from) * i / 60;
    points.push_back({centre.x + radius * std::cos(t), centre.y + radius * std::sin(t)});
  }
  return points;
}

}  // namespace

// The robot looks up the sheet: x ahead is drawn upwards, y to the left.
Figure figure_ackermann(const std::vector<Event>&) {
  const motion::Ackermann drive{kWheelbase};
  const double radius = drive.radius(kSteering);
  const double up = kPi / 2;
  const Point centre{-radius, 0}, front{0, kWheelbase};
  const double front_radius = std::hypot(radius, kWheelbase);

  Figure figure{
      .width = 900, .height = 620, .title = "Ackermann drive: all wheels turn about one point"};
  Panel panel{.place = figure.whole(), .framed = false};
  auto& marks = panel.marks;
  marks.push_back(Polyline{{centre, {kTrack / 2 + 0.35, 0}}, kThin});
  marks.push_back(Polyline{{centre, front}, kThin});
  marks.push_back(Polyline{arc(centre, radius, 0, 0.75), kWay});
  marks.push_back(
      Polyline{arc(centre, front_radius, kSteering, kSteering + 0.62), {ink::green, 2.4}});
  marks.push_back(Polyline{{{-kTrack / 2, 0}, {kTrack / 2, 0}}, kBody});
  marks.push_back(Polyline{{{0, 0}, front}, kBody});
  marks.push_back(wheel({-kTrack / 2, 0}, up, ink::black));
  marks.push_back(wheel({kTrack / 2, 0}, up, ink::black));
  marks.push_back(wheel({0, kWheelbase}, up + kSteering, ink::green));
  marks.push_back(Polyline{{front, {0, kWheelbase + 0.55}}, kThin});
  marks.push_back(Polyline{
      {front, {-0.55 * std::sin(kSteering), kWheelbase + 0.55 * std::cos(kSteering)}}, kThin});
  marks.push_back(Polyline{arc(front, 0.42, up, up + kSteering), {ink::red, 1.8}});
  marks.push_back(Label{front, "ω", -14, 76, Anchor::middle, 19, ink::red});
  marks.push_back(Dots{{centre}, 5, ink::red});
  marks.push_back(Label{centre, "centre of the circle", 0, -26, Anchor::start, 16, ink::red});
  marks.push_back(Arrow{{-radius, -0.28}, {0, -0.28}, {ink::black, 1.3}, true});
  marks.push_back(Label{{-radius / 2, -0.28}, "R = l / tan ω", 0, -24, Anchor::middle, 17});
  marks.push_back(Arrow{{0.75, 0}, {0.75, kWheelbase}, {ink::black, 1.3}, true});
  marks.push_back(Label{{0.75, kWheelbase / 2}, "l", 12, -5, Anchor::start, 17});
  marks.push_back(Polyline{{front, {0.85, kWheelbase}}, kThin});
  figure.panels.push_back(panel);
  return figure;
}

}  // namespace majak::draw
