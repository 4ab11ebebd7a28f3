// SPDX-License-Identifier: Apache-2.0
// Figure 10 of the thesis: Markov localization in a corridor with three doors that look alike. It
// runs round a house: its end is where it begins.
#include <algorithm>
#include <string>
#include <vector>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/filter/histogram.hpp"

namespace majak::draw {
namespace {

constexpr int kCells = 60, kDoor = 5;              // cells, of the corridor and of a door
constexpr double kCell = 0.2;                      // m
constexpr int kDoors[] = {8, 18, 42};              // their first cells
constexpr double kRight = 0.8, kWrong = 0.1;       // a door is seen where one is, and where none
constexpr int kStep = 10;                          // cells that the robot moves
constexpr double kVariance = 4;                    // cells^2, of that
constexpr double kTop = 0.17;                      // probability, of the panels
constexpr double kAtDoor = kDoors[0] + kDoor / 2;  // the cell where the robot begins

Polyline band(double from, double to, double top, const Colour& fill) {
  return {{{from, 0}, {from, top}, {to, top}, {to, 0}}, {ink::black, 0}, true, fill};
}

Panel panel_of(const Box& place, const std::string& title, const filter::Histogram& belief,
               double robot_cell) {
  Panel panel{.place = place,
              .title = title,
              .x = {"", 0, kCells * kCell},
              .y = {"Bel", 0, kTop},
              .equal = false};
  for (const int door : kDoors)
    panel.marks.push_back(
        band(door * kCell, (door + kDoor) * kCell, kTop, ink::orange.faint(0.18)));
  Polyline bars{{{0, 0}}, {ink::blue, 1.6}, true, ink::blue.faint(0.25)};
  for (int i = 0; i < kCells; ++i) {
    bars.points.push_back({i * kCell, belief.p[static_cast<std::size_t>(i)]});
    bars.points.push_back({(i + 1) * kCell, belief.p[static_cast<std::size_t>(i)]});
  }
  bars.points.push_back({kCells * kCell, 0});
  panel.marks.push_back(bars);
  panel.marks.push_back(Dots{{{(robot_cell + 0.5) * kCell, 0.008}}, 6, ink::red});
  return panel;
}

}  // namespace

Figure figure_markov(const std::vector<Event>&) {
  Figure figure{
      .width = 900,
      .height = 1000,
      .title = "Markov localization: a corridor round a house, with three doors that look alike"};
  const Box whole = figure.whole();
  const double height = whole.height / 5;
  std::vector<double> door(kCells, kWrong);
  for (const int first : kDoors) std::fill_n(door.begin() + first, kDoor, kRight);
  filter::Histogram belief = filter::Histogram::uniform(kCells, true);
  double robot = kAtDoor;
  const auto show = [&](const char* title) {
    const double top = whole.top + height * static_cast<double>(figure.panels.size());
    figure.panels.push_back(panel_of({0, top, whole.width, height}, title, belief, robot));
  };
  show("nobody told it where it is");
  belief.see(door);
  show("it sees a door: three places are likely");
  belief.move(kStep, kVariance), robot += kStep;
  show("it moves 2 m: all of the belief goes along, and is blurred");
  belief.see(door);
  show("it sees a door again: only one place fits both");
  belief.move(kStep, kVariance), robot += kStep;
  show("it moves on");
  figure.panels.back().x.label = "along the corridor (m)";
  figure.panels.front().legend = {{"belief", Pen{ink::blue, 1.6}},
                                  {"doors", Pen{ink::orange.faint(0.4), 8}},
                                  {"where the robot is", {}, ink::red}};
  return figure;
}

}  // namespace majak::draw
