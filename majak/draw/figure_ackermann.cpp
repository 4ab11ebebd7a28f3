// SPDX-License-Identifier: Apache-2.0
// Figure 2 of the thesis: the geometry of a steered wheel ahead of a fixed axle.
#include <cmath>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/motion/drive.hpp"

namespace majak::draw {
namespace {

constexpr double kWheelbase = 1.2, kTrack = 0.8, kSteering = 0.5;  // m, m, rad
const Pen kThin{ink::grey, 1.2, 5}, kBody{ink::black, 2.6}, kSize{ink::black, 1.3};

void draw_car(std::vector<Mark>& marks, const Point& front) {
  const double half = kTrack / 2;
  marks.push_back(Polyline{{{-half, 0}, {half, 0}}, kBody});
  marks.push_back(Polyline{{{0, 0}, front}, kBody});
  for (const double x : {-half, half}) marks.push_back(wheel({x, 0, kPi / 2}, ink::black, 0.3));
  marks.push_back(wheel({front.x, front.y, kPi / 2 + kSteering}, ink::green, 0.3));
  marks.push_back(Dots{{{0, 0}}, 5, ink::blue});
}

void draw_steering(std::vector<Mark>& marks, const Point& front) {
  constexpr double kReach = 0.62;
  const double up = kPi / 2;
  const auto ray = [&](double direction) {
    return Point{front.x + kReach * std::cos(direction), front.y + kReach * std::sin(direction)};
  };
  marks.push_back(Polyline{{front, ray(up)}, kThin});
  marks.push_back(Polyline{{front, ray(up + kSteering)}, kThin});
  marks.push_back(Polyline{arc(front, 0.5, up, up + kSteering), {ink::red, 1.8}});
  const double middle = up + kSteering / 2;
  marks.push_back(Label{{front.x + 0.5 * std::cos(middle), front.y + 0.5 * std::sin(middle)},
                        "ω",
                        -3,
                        9,
                        Anchor::middle,
                        20,
                        ink::red});
}

void draw_circle(std::vector<Mark>& marks, const Point& centre, const Point& front) {
  const double radius = -centre.x, front_radius = std::hypot(radius, kWheelbase);
  marks.push_back(Polyline{{centre, {0.86, 0}}, kThin});
  marks.push_back(Polyline{{centre, front}, kThin});
  marks.push_back(Polyline{arc(centre, radius, 0, 0.8), {ink::blue, 2.2}});
  marks.push_back(
      Polyline{arc(centre, front_radius, kSteering, kSteering + 0.66), {ink::green, 2.2}});
  marks.push_back(Polyline{arc(centre, 0.42, 0, kSteering), {ink::red, 1.8}});
  marks.push_back(Label{{centre.x + 0.42, 0.1}, "ω", 8, 0, Anchor::start, 20, ink::red});
  marks.push_back(Dots{{centre}, 6, ink::red});
  marks.push_back(Label{centre, "centre of all circles", -6, -28, Anchor::start, 16, ink::red});
}

}  // namespace

// The robot looks up the sheet: x ahead is drawn upwards, y to the left.
Figure figure_ackermann(const std::vector<Event>&) {
  const double radius = motion::Ackermann{kWheelbase}.radius(kSteering);
  const Point centre{-radius, 0}, front{0, kWheelbase};
  Figure figure{.width = 900,
                .height = 640,
                .title = "Ackermann drive: the centre lies on the line of the fixed axle"};
  Panel panel{.place = figure.whole(), .framed = false};
  draw_circle(panel.marks, centre, front);
  draw_car(panel.marks, front);
  draw_steering(panel.marks, front);
  panel.marks.push_back(Arrow{{centre.x, -0.3}, {0, -0.3}, kSize, true});
  panel.marks.push_back(Label{{centre.x / 2, -0.3}, "R = l / tan ω", 0, -26, Anchor::middle, 19});
  panel.marks.push_back(Polyline{{front, {0.86, kWheelbase}}, kThin});
  panel.marks.push_back(Arrow{{0.8, 0}, {0.8, kWheelbase}, kSize, true});
  panel.marks.push_back(Label{{0.8, kWheelbase / 2}, "l", 12, -6, Anchor::start, 19});
  panel.marks.push_back(Label{{-0.02, 0.62}, "axle's centre", -30, 0, Anchor::end, 15, ink::blue});
  panel.marks.push_back(
      Label{{-0.62, 1.75}, "steered wheel: rolls d", -14, 30, Anchor::end, 15, ink::green});
  panel.marks.push_back(Label{{centre.x, 1.5}, "turn θ = d sin ω / l", 0, 0, Anchor::start, 19});
  figure.panels.push_back(std::move(panel));
  return figure;
}

}  // namespace majak::draw
