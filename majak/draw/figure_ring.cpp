// SPDX-License-Identifier: Apache-2.0
// Figure 14 of the thesis: a robot maps a ring of bare corridors. Each scan goes to its most likely
// place, and the map's ends do not meet; the hybrid's particles find where they do.
#include <fmt/format.h>

#include <algorithm>
#include <string>
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

/// Worn wheels: the left one counts 2 % too much, both slip four times as much as new ones. The
/// laser sees 8 m, as in its millimetre mode.
sim::SimulationOptions worn_robot() {
  sim::SimulationOptions robot;
  robot.seed = 6;
  robot.laser.max_range = 8;
  robot.robot.left_scale = 1.02;
  robot.robot.slip = 0.02;
  return robot;
}

/// The scan at which the lap is full.
std::size_t lap_of(const MappedDrive& drive) {
  std::size_t lap = drive.truth.size() / 2;
  const auto away = [&](std::size_t i) {
    return (drive.truth[i].translation() - drive.truth[0].translation()).norm();
  };
  for (std::size_t i = lap; i < drive.truth.size(); ++i)
    if (away(i) < away(lap)) lap = i;
  return lap;
}

/// One map: what the first lap drew, and what was drawn over it afterwards.
struct Map {
  std::string name;
  const std::vector<Pose2>& poses;
  std::size_t lap;
  const MappedDrive& drive;
  std::vector<std::string> says;
  double gap() const { return place_errors(drive, poses)[lap]; }
};

std::vector<Mark> marks_of(const Map& map, const sim::World& world, double cell, double dot,
                           double left = -1e9, double right = 1e9) {
  std::vector<Mark> marks;
  add_plan(marks, world, {ink::light, 4});
  const auto cells = [&](std::size_t first, std::size_t last, const Colour& colour) {
    Dots dots{map_cells(map.drive, map.poses, first, last, cell), dot, colour};
    std::erase_if(dots.at, [&](const Point& p) { return p.x < left || p.x > right; });
    marks.emplace_back(std::move(dots));
  };
  cells(0, map.lap, ink::blue);
  cells(map.lap, map.poses.size(), ink::orange);
  marks.emplace_back(Polyline{way_through(map.poses), {ink::green, 1.4}});
  return marks;
}

std::string in_words(double gap) {
  if (gap < 0.1) return fmt::format("{:.0f} mm", 1e3 * gap);
  return fmt::format("{:.{}f} m", gap, gap < 1 ? 2 : gap < 10 ? 1 : 0);
}

/// From where the robot is to where it believes to be.
void add_gap(std::vector<Mark>& marks, const Map& map) {
  const Point truly = point(map.drive.truth[map.lap].translation());
  const Point believed = point(map.poses[map.lap].translation());
  marks.emplace_back(Dots{{truly, believed}, 4, ink::red});
  marks.emplace_back(Arrow{truly, believed, {ink::red, 2.2}});
  marks.emplace_back(Label{truly, in_words(map.gap()), -8, 5, Anchor::end, 15, ink::red});
}

/// The ring, with words in its middle.
Panel whole_map(const Box& place, const Map& map, const sim::World& world) {
  Panel panel{
      .place = place, .title = map.name, .x = {"x (m)", -4.0, 64.0}, .y = {"y (m)", -6.0, 44.0}};
  panel.marks = marks_of(map, world, 0.2, 0.9);
  panel.marks.emplace_back(  // the grid keeps out of the words
      Polyline{{{4, 13}, {56, 13}, {56, 27}, {4, 27}}, {ink::white, 0}, true, ink::white});
  double dy = 12.0 * static_cast<double>(map.says.size());
  for (const std::string& line : map.says)
    panel.marks.emplace_back(Label{{30, 20}, line, 0, dy -= 24, Anchor::middle});
  return panel;
}

Panel seam(const Box& place, const Map& map, const sim::World& world) {
  constexpr double kLeft = 40, kRight = 64;
  Panel panel{.place = place,
              .title = "Where the lap is full: a gap of " + in_words(map.gap()),
              .x = {"x (m)", kLeft, kRight},
              .y = {"y (m)", -3.8, 7.2}};
  panel.marks = marks_of(map, world, 0.05, 1.1, kLeft - 1, kRight + 1);
  add_gap(panel.marks, map);
  panel.legend = {{"true walls", Pen{ink::light, 4}},
                  {"walls drawn on the first lap", {}, ink::blue},
                  {"walls drawn after it", {}, ink::orange},
                  {"believed way", Pen{ink::green, 1.4}}};
  panel.legend_at = Corner::top_right;
  return panel;
}

template <class Method, class Options>
slam::Mapping mapped_by(const std::vector<Event>& events, const Options& options) {
  Method method({}, options, {});
  for (const Event& event : events) method.add(event);
  return method.finish();
}

std::string loops_in_words(const std::vector<slam::LoopCorrection>& corrections) {
  const auto undone = std::count_if(corrections.begin(), corrections.end(),
                                    [](const slam::LoopCorrection& c) { return c.undone; });
  return fmt::format("{} times found on old ground, {} taken back", corrections.size(), undone);
}

}  // namespace

Figure figure_ring(const std::vector<Event>&) {
  const sim::World world(sim::bare_ring());
  const std::vector<Event> events =
      sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), worn_robot());
  const MappedDrive drive = map_drive(events, {});
  const slam::Mapping by_hybrid = mapped_by<slam::Hybrid>(events, slam::HybridOptions{});
  const std::vector<Pose2> hybrid = laid_on_truth(drive, by_hybrid.site);
  const std::vector<Pose2> alone = laid_on_truth(
      drive, mapped_by<slam::IncrementalMl>(events, slam::IncrementalMlOptions{}).site);
  const std::size_t lap = lap_of(drive);
  const auto gap = [&](const std::vector<Pose2>& poses) {
    return in_words(place_errors(drive, poses)[lap]);
  };
  const Map maps[] = {{"Incremental maximum likelihood",
                       alone,
                       lap,
                       drive,
                       {"Wheels: the left one 2 % too much, slip 20 mm per √m",
                        "Bare walls: only the wheels count the way along them",
                        "By the wheels alone: " + gap(drive.wheels),
                        "Each scan at its most likely place: " + gap(alone)}},
                      {"Hybrid: the same, and a particle set that finds the old ground",
                       hybrid,
                       lap,
                       drive,
                       {loops_in_words(by_hybrid.corrections),
                        "Graph SLAM, for comparison: " + gap(drive.closed)}}};
  Figure figure{.width = 1300,
                .height = 860,
                .title = "A bare ring of 190 m: scan by scan its ends do not meet"};
  const Box all = figure.whole();
  const double width = all.width / 2, split = 470;
  for (int k = 0; k < 2; ++k) {
    figure.panels.push_back(whole_map({width * k, all.top, width, split}, maps[k], world));
    figure.panels.push_back(
        seam({width * k, all.top + split, width, all.height - split}, maps[k], world));
  }
  return figure;
}

}  // namespace majak::draw
