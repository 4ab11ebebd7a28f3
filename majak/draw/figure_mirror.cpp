// SPDX-License-Identifier: Apache-2.0
// Figure 12 of the thesis: the mirror turns, pulse after pulse flies out and comes back, and the
// contour of the room grows with it. Below, when each pulse was fired and how long it was away.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/match/scan_points.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::draw {
namespace {

constexpr double kLight = 299792458;      // m/s
constexpr double kMirrorTurn = 1.0 / 75;  // s
constexpr int kMoments = 4;

/// A pulse that came back.
struct Pulse {
  Point at;      // m, laser's frame
  double fired;  // ms after the first
  double away;   // ns, there and back
};

std::vector<Pulse> pulses_of(const Scan& scan) {
  std::vector<Pulse> pulses;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double d = scan.ranges[i];
    if (!std::isfinite(d)) continue;
    const double angle = scan.angle(i);
    pulses.push_back({{d * std::cos(angle), d * std::sin(angle)},
                      1e3 * match::beam_time(scan, i, kMirrorTurn),
                      1e9 * 2 * d / kLight});
  }
  std::stable_sort(pulses.begin(), pulses.end(),
                   [](const Pulse& a, const Pulse& b) { return a.fired < b.fired; });
  return pulses;
}

/// The first scan of the log that sees anything; without a log one of a simulated building.
Scan example(const std::vector<Event>& events) {
  for (const Event& event : events)
    if (const auto* scan = std::get_if<Scan>(&event))
      if (std::any_of(scan->ranges.begin(), scan->ranges.end(),
                      [](float r) { return std::isfinite(r); }))
        return *scan;
  const sim::World world(sim::building());
  for (const Event& event : sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), {}))
    if (const auto* scan = std::get_if<Scan>(&event)) return *scan;
  return {};
}

/// The pulses of the first so many ms, and the one that is out.
Panel sweep(const Box& place, const std::vector<Pulse>& pulses, double until) {
  Panel panel{.place = place, .x = {"x (m)"}, .y = {"y (m)"}};
  Dots contour{{}, 1.8, ink::blue};
  Polyline last{{{0, 0}}, {ink::red, 1.8}};
  // All panels show as much of the room.
  Polyline room{{}, {ink::black, 0}};
  for (const Pulse& p : pulses) {
    room.points.push_back(p.at);
    if (p.fired > until) continue;
    panel.marks.emplace_back(Polyline{{{0, 0}, p.at}, {ink::orange.faint(0.25), 0.8}});
    contour.at.push_back(p.at);
    last.points.resize(1), last.points.push_back(p.at);
  }
  panel.title = fmt::format("after {:.1f} ms", until);
  panel.marks.emplace_back(room);
  panel.marks.emplace_back(contour);
  panel.marks.emplace_back(last);
  panel.marks.emplace_back(Dots{{{0, 0}}, 5, ink::black});
  return panel;
}

/// A stem a pulse: fired when, away how long.
Panel flights(const Box& place, const std::vector<Pulse>& pulses) {
  Panel panel{.place = place,
              .title = "Each pulse: t = 2 d / c",
              .x = {"fired (ms after the first)"},
              .y = {"away (ns)", 0.0},
              .equal = false};
  Dots back{{}, 1.8, ink::blue};
  for (const Pulse& p : pulses) {
    panel.marks.emplace_back(
        Polyline{{{p.fired, 0}, {p.fired, p.away}}, {ink::orange.faint(0.5), 0.8}});
    back.at.push_back({p.fired, p.away});
  }
  panel.marks.emplace_back(back);
  return panel;
}

}  // namespace

Figure figure_mirror(const std::vector<Event>& events) {
  const std::vector<Pulse> pulses = pulses_of(example(events));
  Figure figure{.width = 1000, .height = 1100, .title = "A mirror turns, a contour grows"};
  const Box all = figure.whole();
  const double width = all.width / 2, height = all.height / 3;
  const double end = pulses.empty() ? 0 : pulses.back().fired;
  for (int k = 0; k < kMoments; ++k)
    figure.panels.push_back(sweep({width * (k % 2), all.top + height * (k / 2), width, height},
                                  pulses, end * (k + 1) / kMoments));
  figure.panels.push_back(flights({0, all.top + 2 * height, all.width, height}, pulses));
  return figure;
}

}  // namespace majak::draw
