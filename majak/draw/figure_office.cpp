// SPDX-License-Identifier: Apache-2.0
// Figure 17 of the thesis: an office building mapped scan by scan, each at its most likely place,
// with no doubt stored; beside it by the hybrid, whose particles know by how much that may be off.
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
#include "majak/slam/hybrid.hpp"
#include "majak/slam/incremental_ml.hpp"

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

/// The hybrid's map and what it knew on the way.
struct HybridRun {
  slam::Mapping mapping;
  std::vector<double> spread;    ///< m, of the particles at each scan, one sigma
  std::vector<Point> particles;  ///< at some scans, in the map as it then was
};

HybridRun run_hybrid(const std::vector<Event>& events, const Pose2& T_world_start) {
  constexpr std::size_t kEach = 250;  // scans between two sets that are drawn
  HybridRun run;
  slam::Hybrid hybrid({}, {}, {});
  for (const Event& event : events) {
    if (!hybrid.add(event)) continue;
    run.spread.push_back(hybrid.widest());
    if (run.spread.size() % kEach != 0) continue;
    for (const Pose2& p : hybrid.particles())
      run.particles.push_back(point((T_world_start * p).translation()));
  }
  run.mapping = hybrid.finish();
  run.spread.resize(run.mapping.site.scans.size(), run.spread.back());
  return run;
}

Panel map_of(const Box& place, const sim::World& world, const MappedDrive& drive,
             const std::vector<Pose2>& poses, const char* name) {
  const std::vector<double> errors = place_errors(drive, poses);
  Panel map = plan_of(place);
  map.title = fmt::format("{}: {:.0f} cm off (rms), {:.0f} cm at most", name, 100 * rms(errors),
                          100 * *std::max_element(errors.begin(), errors.end()));
  add_plan(map.marks, world, {ink::light, 3});
  map.marks.emplace_back(Dots{map_cells(drive, poses, 0, poses.size(), 0.1), 0.8, ink::blue});
  map.marks.emplace_back(Polyline{way_through(poses), {ink::green, 1.4}});
  return map;
}

}  // namespace

Figure figure_office(const std::vector<Event>&) {
  const sim::World world(sim::building());
  const std::vector<Event> events = sim::simulate(world, sim::plan_tour(world), {});
  const MappedDrive drive = map_drive(events, {});
  slam::IncrementalMl incremental({}, {}, {});
  for (const Event& event : events) incremental.add(event);
  const std::vector<Pose2> alone = laid_on_truth(drive, incremental.finish().site);
  const HybridRun run = run_hybrid(events, drive.truth.front());
  const std::vector<Pose2> hybrid = laid_on_truth(drive, run.mapping.site);
  Figure figure{.width = 1300,
                .height = 780,
                .title = "An office building, scan by scan and with particles for its loops"};
  const Box all = figure.whole();
  const double half = all.width / 2, split = 450;

  figure.panels.push_back(map_of({0, all.top, half, split}, world, drive, alone, "Incremental"));
  Panel map = map_of({half, all.top, half, split}, world, drive, hybrid, "Hybrid");
  map.marks.emplace_back(Dots{run.particles, 1.2, ink::orange});
  std::vector<Point> found;
  for (const slam::LoopCorrection& c : run.mapping.corrections)
    found.push_back(point(hybrid[c.scan].translation()));
  map.marks.emplace_back(Dots{found, 4, ink::red});
  map.legend = {{"particles now and then", {}, ink::orange},
                {"found on old ground, and corrected", {}, ink::red}};
  figure.panels.push_back(std::move(map));

  Panel error{.place = {0, all.top + split, all.width, all.height - split},
              .x = {"distance driven (m)", 0},
              .y = {"error of the place (cm)", 0},
              .equal = false};
  error.marks = {Polyline{over_way(drive.truth, place_errors(drive, alone)), {ink::blue, 2}},
                 Polyline{over_way(drive.truth, place_errors(drive, hybrid)), {ink::green, 2}},
                 Polyline{over_way(drive.truth, run.spread), {ink::orange, 1.4}}};
  error.legend = {{"incremental", Pen{ink::blue, 2}},
                  {"hybrid, in the end", Pen{ink::green, 2}},
                  {"spread of its particles on the way", Pen{ink::orange, 1.4}}};
  figure.panels.push_back(std::move(error));
  return figure;
}

}  // namespace majak::draw
