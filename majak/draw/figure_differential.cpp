// SPDX-License-Identifier: Apache-2.0
// Figure 3 of the thesis: what a differential drive does with equal, unequal and opposite wheels.
#include <fmt/format.h>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/motion/drive.hpp"

namespace majak::draw {
namespace {

constexpr double kTrack = 0.4;  // m
const Vec2 kLeft(0, kTrack / 2), kRight(0, -kTrack / 2);

void draw_robot(std::vector<Mark>& marks, const Pose2& pose, double alpha) {
  const Colour colour = ink::black.faint(alpha);
  marks.push_back(circle(point(pose.translation()), 0.26, {colour, 1.6}, ink::sky.faint(0.16)));
  for (const Vec2& side : {kLeft, kRight})
    marks.push_back(wheel(pose * Pose2{side.x(), side.y(), 0}, colour, 0.16));
  marks.push_back(Polyline{{point(pose.translation()), point(pose * Vec2(0.26, 0))}, {colour, 2}});
}

/// `middle`: of the panel, m to the right of the robot.
Panel drive_panel(const Box& place, const char* title, const char* wheels, double middle,
                  const motion::Differential::Wheels& rolled) {
  const Vec3 twist = motion::Differential{kTrack}.forward(rolled);
  Panel panel{.place = place,
              .title = title,
              .x = {"", middle - 0.75, middle + 0.75},
              .y = {"", -0.62, 1.25},
              .framed = false};
  auto& marks = panel.marks;
  draw_robot(marks, kLooksUp, 1);
  draw_robot(marks, kLooksUp * exp(twist), 0.35);
  marks.push_back(Polyline{way_of(kLeft, kLooksUp, twist), {ink::blue, 2.2}});
  marks.push_back(Polyline{way_of(kRight, kLooksUp, twist), {ink::green, 2.2}});
  const auto speed = [&](const Vec2& side, double way, const Colour& colour) {
    const Vec2 from = kLooksUp * side, to = kLooksUp * (side + Vec2(0.42 * way, 0));
    marks.push_back(Arrow{point(from), point(to), {colour, 3}, false});
  };
  speed(kLeft, rolled.left, ink::blue);
  speed(kRight, rolled.right, ink::green);
  marks.push_back(Label{{middle, -0.5}, wheels, 0, 0, Anchor::middle, 16});
  return panel;
}

void draw_circle(Panel& panel, const motion::Differential::Wheels& rolled) {
  // (MATH 6.1)
  const double radius = kTrack / 2 * (rolled.right + rolled.left) / (rolled.right - rolled.left);
  const Point centre = point(kLooksUp * Vec2(0, radius));
  panel.marks.push_back(Polyline{{centre, {0, 0}}, {ink::grey, 1.2, 5}});
  panel.marks.push_back(Dots{{centre}, 5, ink::red});
  panel.marks.push_back(Label{{centre.x / 2, 0}, "R", -14, 7, Anchor::middle, 18});
}

}  // namespace

Figure figure_differential(const std::vector<Event>&) {
  Figure figure{.width = 960, .height = 520, .title = "Differential drive: three kinds of motion"};
  const Box all = figure.whole();
  const double width = all.width / 3, height = all.height - 70;
  const auto place = [&](int i) { return Box{i * width, all.top, width, height}; };
  figure.panels.push_back(drive_panel(place(0), "straight", "left = right", 0, {0.9, 0.9}));
  figure.panels.push_back(drive_panel(place(1), "arc", "left < right", -0.25, {0.55, 1.05}));
  draw_circle(figure.panels.back(), {0.55, 1.05});
  figure.panels.push_back(drive_panel(place(2), "spin", "left = −right", 0, {-0.5, 0.5}));
  Panel words{.place = {0, all.top + height, all.width, 70},
              .x = {"", 0, 1},
              .y = {"", 0, 1},
              .equal = false,
              .framed = false};
  words.marks.push_back(Label{{0.5, 0.35},
                              "d = (left + right) / 2      θ = (right − left) / b      "
                              "R = b / 2 · (right + left) / (right − left)",
                              0,
                              0,
                              Anchor::middle,
                              18});
  figure.panels.push_back(std::move(words));
  return figure;
}

}  // namespace majak::draw
