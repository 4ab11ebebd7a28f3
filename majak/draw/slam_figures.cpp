// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/slam_figures.hpp"

#include <algorithm>

namespace majak::draw {
namespace {

const Pen kEkf{ink::red, 2.2}, kGraph{ink::blue, 2.2};

std::vector<Point> over(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<Point> line;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) line.push_back({x[i], y[i]});
  return line;
}

Panel over_time(const Box& place, const NeesPicture& p, std::string unit) {
  const double end = p.seconds.empty() ? 1 : p.seconds.back();
  return {.place = place, .x = {"time (s)", 0.0, end}, .y = {std::move(unit), 0.0}, .equal = false};
}

}  // namespace

Figure nees_picture(const NeesPicture& p) {
  Figure figure{.width = 900, .height = 780, .title = p.title};
  const Box all = figure.whole();
  const double half = all.height / 2;
  Panel nees = over_time({0, all.top, all.width, half}, p, "NEES of the pose");
  const double end = *nees.x.high;
  nees.marks = {Polyline{{{0, p.band_low}, {end, p.band_low}, {end, p.band_high}, {0, p.band_high}},
                         {ink::green, 0},
                         true,
                         ink::green.faint(0.25)},
                Polyline{{{0, 3}, {end, 3}}, {ink::green, 1.2, 5}},
                Polyline{over(p.seconds, p.ekf), kEkf}, Polyline{over(p.seconds, p.graph), kGraph}};
  nees.legend = {{"EKF, as known then", kEkf},
                 {"graph", kGraph},
                 {"95 % of means, were it right", {}, ink::green.faint(0.4)}};
  Panel place = over_time({0, all.top + half, all.width, half}, p, "place, rms (m)");
  place.marks = {Polyline{over(p.seconds, p.ekf_place), kEkf},
                 Polyline{over(p.seconds, p.graph_place), kGraph}};
  figure.panels = {std::move(nees), std::move(place)};
  return figure;
}

Figure step_time_picture(const std::vector<StepTimes>& runs) {
  Figure figure{.width = 900, .height = 420};
  const double width = figure.width / static_cast<double>(std::max<std::size_t>(runs.size(), 1));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Panel panel{.place = {width * static_cast<double>(i), 0, width, figure.height},
                .title = runs[i].name,
                .x = {"landmarks on the map", 0.0},
                .y = {"CPU a scan (ms)", 0.0},
                .equal = false};
    panel.marks = {Polyline{runs[i].mean, kEkf}, Polyline{runs[i].median, kGraph}};
    panel.legend = {{"mean, looks around included", kEkf}, {"median", kGraph}};
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace majak::draw
