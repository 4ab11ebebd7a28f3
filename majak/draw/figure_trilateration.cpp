// SPDX-License-Identifier: Apache-2.0
// Figure 6: two distances leave two places; a third one decides.
#include <array>
#include <string>
#include <vector>

#include "majak/beacon/trilateration.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

constexpr double kSigma = 0.25;  // m
const Vec2 kRobot(5.5, 4);
const std::array<Vec2, 3> kBeacons = {Vec2(1.5, 1), Vec2(9.5, 1.8), Vec2(7.2, 8.4)};
const std::array<Colour, 3> kInks = {ink::blue, ink::green, ink::orange};

/// The circles of the first n beacons, each with its radius.
std::vector<Mark> circles(std::size_t n) {
  std::vector<Mark> marks;
  for (std::size_t i = 0; i < n; ++i) {
    const double r = (kRobot - kBeacons[i]).norm();
    marks.push_back(circle(point(kBeacons[i]), r, {kInks[i], 2}));
    const Vec2 rim = kBeacons[i] + r * Vec2(i == 1 ? 0.8 : -0.8, i == 2 ? 0.6 : -0.6);
    marks.push_back(Polyline{{point(kBeacons[i]), point(rim)}, {kInks[i], 1.2, 5}});
    marks.push_back(Dots{{point(kBeacons[i])}, 5, kInks[i]});
    const std::string number = std::to_string(i + 1);
    marks.push_back(Label{point(kBeacons[i]), "B" + number, 8, 8, Anchor::start, 16, kInks[i]});
    const Vec2 middle = 0.5 * (kBeacons[i] + rim);
    marks.push_back(Label{point(middle), "r" + number, 0, 8, Anchor::middle, 15, kInks[i]});
  }
  return marks;
}

std::vector<beacon::RangeTo> ranges(std::size_t n) {
  std::vector<beacon::RangeTo> out;
  for (std::size_t i = 0; i < n; ++i)
    out.push_back({kBeacons[i], (kRobot - kBeacons[i]).norm(), kSigma});
  return out;
}

void add_fix(Panel& panel, const beacon::Trilateration& fix) {
  panel.marks.push_back(covariance_ellipse(fix.p_map, fix.covariance, {ink::red, 1.8}));
  panel.marks.push_back(Dots{{point(fix.p_map)}, 5, ink::red});
}

Panel panel_of(const Box& place, const std::string& title, std::size_t n) {
  Panel panel{.place = place, .title = title};
  panel.x = {"x (m)", -4.5, 15.5};
  panel.y = {"y (m)", -5.5, 14.5};
  panel.marks = circles(n);
  return panel;
}

}  // namespace

Figure figure_trilateration(const std::vector<Event>&) {
  Figure figure{
      .width = 1100, .height = 600, .title = "Trilateration: two circles meet in two places"};
  const Box whole = figure.whole();
  const Box left{0, whole.top, 550, whole.height}, right{550, whole.top, 550, whole.height};

  Panel two = panel_of(left, "two beacons: here or there", 2);
  const auto both = beacon::trilaterate(ranges(2), kRobot);
  add_fix(two, both);
  if (both.mirror) {
    const auto other = beacon::trilaterate(ranges(2), both.mirror);
    add_fix(two, other);
    two.marks.push_back(Label{point(other.p_map), "P2", 12, -22, Anchor::start, 17, ink::red});
  }
  two.marks.push_back(Label{point(both.p_map), "P1", 12, 10, Anchor::start, 17, ink::red});
  two.legend = {{"95 % ellipse, range sigma 0.25 m", Pen{ink::red, 1.8}}};

  Panel three = panel_of(right, "the third decides", 3);
  const auto fix = beacon::trilaterate(ranges(3));
  add_fix(three, fix);
  three.marks.push_back(Label{point(fix.p_map), "P", 14, 8, Anchor::start, 17, ink::red});
  if (both.mirror) {
    three.marks.push_back(circle(point(*both.mirror), 0.25, {ink::grey, 1.6, 3}));
    three.marks.push_back(
        Label{point(*both.mirror), "not here", 10, -18, Anchor::start, 14, ink::grey});
  }
  figure.panels = {two, three};
  return figure;
}

}  // namespace majak::draw
