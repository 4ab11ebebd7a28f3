// SPDX-License-Identifier: Apache-2.0
// Figure 9 of the thesis: particles all over a building, and where a few scans leave them.
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "majak/draw/mapped_drive.hpp"
#include "majak/draw/sketch.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/localize/monte_carlo.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/known_map.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::draw {
namespace {

constexpr int kPasses = 15;

/// The cloud as a picture shows it, and where the robot is.
struct Cloud {
  std::vector<Point> particles;
  Pose2 truth;
};

Cloud cloud_of(const localize::MonteCarlo& filter, const Pose2& truth) {
  Cloud cloud{{}, truth};
  for (std::size_t i = 0; i < filter.poses().size(); ++i)
    cloud.particles.push_back({filter.poses().x[i], filter.poses().y[i]});
  return cloud;
}

/// Before any scan, after one, after `kPasses`. Beams count for less than by default, so that the
/// first scan leaves more than one place to see.
std::vector<Cloud> clouds(const sim::World& world) {
  const sim::Path path = sim::plan_tour(world, {.short_tour = true});
  localize::MonteCarlo filter(localize::place_of(sim::known_map(world)),
                              {.least = 5000, .effective = 6});
  localize::ScanFeed feed;
  localize::FedScan blind;  // sees nothing: the particles stay as they are drawn
  filter.add(blind);
  std::vector<Cloud> seen{cloud_of(filter, path.start)};
  Pose2 truth = path.start;
  for (const Event& event : sim::simulate(world, path, {})) {
    if (const auto* t = std::get_if<Truth>(&event)) truth = t->T_world_robot;
    feed.add(event);
    while (auto scan = feed.next()) {
      filter.add(*scan);
      if (!filter.updated()) continue;
      if (filter.updates() == 1 || filter.updates() == kPasses)
        seen.push_back(cloud_of(filter, truth));
      if (filter.updates() == kPasses) return seen;
    }
  }
  return seen;
}

Panel panel_of(const Box& place, const sim::World& world, const Cloud& cloud, std::string title) {
  Panel panel{.place = place, .title = std::move(title), .x = {"x (m)"}, .y = {"y (m)"}};
  add_plan(panel.marks, world, {ink::black, 1.2});
  panel.marks.emplace_back(Dots{cloud.particles, 0.9, ink::blue.faint(0.6)});
  const Vec2 ahead = cloud.truth * Vec2(2, 0);
  panel.marks.emplace_back(circle(point(cloud.truth.translation()), 0.6, {ink::red, 1.8}));
  panel.marks.emplace_back(Arrow{point(cloud.truth.translation()), point(ahead), {ink::red, 1.8}});
  return panel;
}

}  // namespace

Figure figure_monte_carlo(const std::vector<Event>&) {
  const sim::World world(sim::building());
  const std::vector<Cloud> seen = clouds(world);
  Figure figure{.width = 800, .height = 1560, .title = "5000 particles look for their robot (red)"};
  const Box all = figure.whole();
  const char* titles[] = {"Anywhere", "After the first scan", "After 15 scans"};
  const double height = all.height / 3;
  for (std::size_t k = 0; k < seen.size(); ++k)
    figure.panels.push_back(
        panel_of({0, all.top + height * static_cast<double>(k), all.width, height}, world, seen[k],
                 titles[k]));
  return figure;
}

}  // namespace majak::draw
