// SPDX-License-Identifier: Apache-2.0
// Figure 17 of the thesis: an office building mapped scan by scan, each at its most likely place,
// with no doubt stored and no loop closed; and how far off that is.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "majak/draw/mapped_drive.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::draw {
namespace {

Panel plan_of(const Box& place) {
  return {.place = place, .x = {"x (m)", -1.0, 41.0}, .y = {"y (m)", -1.0, 26.0}};
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Errors (cm) over the true way (m).
std::vector<Point> over_way(const std::vector<Pose2>& truth, const std::vector<double>& errors) {
  std::vector<Point> points;
  double way = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (i > 0) way += (truth[i].translation() - truth[i - 1].translation()).norm();
    points.push_back({way, 100 * errors[i]});
  }
  return simplify(points, 0.05);
}

}  // namespace

Figure figure_office(const std::vector<Event>&) {
  const sim::World world(sim::building());
  const MappedDrive drive = map_drive(sim::simulate(world, sim::plan_tour(world), {}), {});
  const std::vector<double> matching = place_errors(drive, drive.matching);
  const std::vector<double> closed = place_errors(drive, drive.closed);
  Figure figure{.width = 1300,
                .height = 780,
                .title = "An office building mapped scan by scan, no loop closed"};
  const Box all = figure.whole();
  const double half = all.width / 2, split = 450;

  Panel truth = plan_of({0, all.top, half, split});
  truth.title = "Truth, and the way driven";
  add_plan(truth.marks, world, {ink::black, 1.4});
  truth.marks.emplace_back(Polyline{way_through(drive.truth), {ink::green, 1.4}});

  Panel map = plan_of({half, all.top, half, split});
  map.title =
      fmt::format("Map by matching alone: {:.0f} cm off (rms), {:.0f} cm at most",
                  100 * rms(matching), 100 * *std::max_element(matching.begin(), matching.end()));
  add_plan(map.marks, world, {ink::light, 3});
  map.marks.emplace_back(
      Dots{map_cells(drive, drive.matching, 0, drive.truth.size(), 0.1), 0.8, ink::blue});
  map.marks.emplace_back(Polyline{way_through(drive.matching), {ink::green, 1.4}});

  Panel error{.place = {0, all.top + split, all.width, all.height - split},
              .x = {"distance driven (m)", 0},
              .y = {"error of the place (cm)", 0},
              .equal = false};
  error.marks = {Polyline{over_way(drive.truth, matching), {ink::blue, 2}},
                 Polyline{over_way(drive.truth, closed), {ink::orange, 2}}};
  error.legend = {{"scan by scan", Pen{ink::blue, 2}}, {"with loops closed", Pen{ink::orange, 2}}};
  figure.panels = {std::move(truth), std::move(map), std::move(error)};
  return figure;
}

}  // namespace majak::draw
