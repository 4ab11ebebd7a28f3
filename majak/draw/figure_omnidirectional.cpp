// SPDX-License-Identifier: Apache-2.0
// Figure 4 of the thesis: three wheels that also roll sidewards.
#include <cmath>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/motion/drive.hpp"
#include "majak/motion/wheel_matrix.hpp"

namespace majak::draw {
namespace {

constexpr double kArm = 0.3;  // m
const Colour kWheels[] = {ink::blue, ink::green, ink::orange};

void draw_robot(std::vector<Mark>& marks, const Pose2& pose, double alpha) {
  const auto wheels = motion::omni_wheels(3, kArm);
  Polyline body{{}, {ink::black.faint(alpha), 1.6}, true, ink::sky.faint(0.14)};
  for (const auto& w : wheels) {  // a blunt triangle: two corners beside each wheel
    for (const double side : {-0.14, 0.14}) {
      const Pose2 T = pose * Pose2{w.place.x(), w.place.y(), w.heading};
      body.points.push_back(point(T * Vec2(side, 0.02)));
    }
  }
  marks.push_back(std::move(body));
  for (int i = 0; i < 3; ++i)
    marks.push_back(wheel(pose * Pose2{wheels[i].place.x(), wheels[i].place.y(), wheels[i].heading},
                          kWheels[i].faint(alpha), 0.16));
}

Panel wheels_panel(const Box& place) {
  Panel panel{.place = place, .title = "wheels and their directions", .framed = false};
  auto& marks = panel.marks;
  draw_robot(marks, kLooksUp, 1);
  const char* const names[] = {"d₁", "d₂", "d₃"};
  const auto wheels = motion::omni_wheels(3, kArm);
  for (int i = 0; i < 3; ++i) {
    const Pose2 T = kLooksUp * Pose2{wheels[i].place.x(), wheels[i].place.y(), wheels[i].heading};
    marks.push_back(Polyline{{{0, 0}, point(T.translation())}, {ink::grey, 1.2, 5}});
    marks.push_back(Arrow{
        point(T * Vec2(0.02, -0.075)), point(T * Vec2(0.24, -0.075)), {kWheels[i], 2.6}, false});
    marks.push_back(
        Label{point(T * Vec2(0.13, -0.15)), names[i], 0, -6, Anchor::middle, 19, kWheels[i]});
  }
  marks.push_back(Label{{0.15, 0}, "b", 0, 7, Anchor::middle, 18});
  marks.push_back(Arrow{{0, 0}, {0, 0.24}, {ink::red, 2.4}, false});
  marks.push_back(Label{{0, 0.24}, "dx", 8, -6, Anchor::start, 17, ink::red});
  marks.push_back(Arrow{{0, 0}, {-0.24, 0}, {ink::red, 2.4}, false});
  marks.push_back(Label{{-0.24, 0}, "dy", 8, 10, Anchor::start, 17, ink::red});
  return panel;
}

/// A straight way while the robot turns by 150 degrees: what no other drive can.
Panel motion_panel(const Box& place) {
  Panel panel{.place = place, .title = "a straight way, turning all along", .framed = false};
  auto& marks = panel.marks;
  const motion::Omnidirectional drive{kArm};
  constexpr int kSteps = 300, kShown = 4;
  const double turn = radians(150) / kSteps, step = 1.7 / kSteps;
  Pose2 pose{0, 0, kPi / 2};
  std::vector<Point> centre, ways[3];
  for (int i = 0; i <= kSteps; ++i) {
    if (i % (kSteps / (kShown - 1)) == 0) draw_robot(marks, pose, 0.35 + 0.65 * (i == kSteps));
    centre.push_back(point(pose.translation()));
    // The way ahead on the sheet, in the robot's own axes at the middle of the step.
    const Vec2 ahead = Pose2{0, 0, -(pose.theta + turn / 2)} * Vec2(step, 0.5 * step);
    pose = pose * exp(drive.forward(drive.inverse({ahead.x(), ahead.y(), turn})));
  }
  marks.push_back(Polyline{std::move(centre), {ink::red, 2.4}});
  return panel;
}

}  // namespace

Figure figure_omnidirectional(const std::vector<Event>&) {
  Figure figure{.width = 960, .height = 560, .title = "Omnidirectional drive with three wheels"};
  const Box all = figure.whole();
  const double height = all.height - 60;
  figure.panels.push_back(wheels_panel({0, all.top, 400, height}));
  figure.panels.push_back(motion_panel({400, all.top, 560, height}));
  Panel words{.place = {0, all.top + height, all.width, 60},
              .x = {"", 0, 1},
              .y = {"", 0, 1},
              .equal = false,
              .framed = false};
  words.marks.push_back(Label{{0.5, 0.4},
                              "d₁ = dx + bθ      d₂ = −dx / 2 + √3 / 2 · dy + bθ      "
                              "d₃ = −dx / 2 − √3 / 2 · dy + bθ",
                              0,
                              0,
                              Anchor::middle,
                              18});
  figure.panels.push_back(std::move(words));
  return figure;
}

}  // namespace majak::draw
