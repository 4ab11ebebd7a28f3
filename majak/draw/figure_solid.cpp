// SPDX-License-Identifier: Apache-2.0
// Figure 20 of the thesis: a map of objects. A robot with one level and one upright laser has
// driven through rooms; seen from above, without the ceiling: the upright one's points, and the
// planes among them as polygons on the floor that the level one knows.
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "majak/draw/solid_view.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/map/raised_walls.hpp"
#include "majak/map/solid_map.hpp"
#include "majak/sim/solid_simulator.hpp"

namespace majak::draw {
namespace {

constexpr double kCeiling = 2.4;  // m; points above are left out
const Vec3 kEye{2.5, -9.5, 11.5}, kAt{6, 3.6, 0.6};

/// What the robot has brought home.
struct Drive {
  Site site;
  map::SolidCloud cloud;
};

Drive drive() {
  const sim::SolidRooms rooms = sim::solid_rooms();
  const sim::World world(rooms.plan);
  const sim::SolidWorld solid(rooms.solid);
  sim::SolidSimulator simulator(world, solid, sim::plan_tour(world), {});
  Drive out;
  std::vector<Scan> upright;
  while (const auto event = simulator.next()) {
    if (const auto* scan = std::get_if<Scan>(&*event)) {
      if (scan->laser == 0)
        out.site.scans.emplace_back().scan = *scan;
      else
        upright.push_back(*scan);
    } else if (const auto* truth = std::get_if<Truth>(&*event)) {
      out.site.scans.back().estimate.T_map_robot = truth->T_world_robot;
    }
  }
  map::SolidPoints points(out.site, map::LaserMounting{});
  for (const Scan& scan : upright) points.add(scan);
  out.cloud = points.cloud();
  return out;
}

/// Points below the ceiling, those high up darker.
std::vector<Mark> points_of(const map::SolidCloud& cloud, const Camera& camera) {
  constexpr Colour kBands[] = {ink::sky, ink::green, ink::orange};
  std::vector<Dots> bands;
  for (const Colour& colour : kBands) bands.push_back({{}, 0.75, colour});
  for (const map::SolidPoint& p : cloud.points) {
    if (p.mean.z() > kCeiling) continue;
    const auto band = static_cast<std::size_t>(std::clamp(p.mean.z() / 0.85, 0.0, 2.0));
    bands[band].at.push_back(camera.see(p.mean));
  }
  std::vector<Mark> marks;
  for (Dots& band : bands) marks.emplace_back(std::move(band));
  return marks;
}

}  // namespace

Figure figure_solid(const std::vector<Event>& /*events*/) {
  const Drive driven = drive();
  const map::PlaneMap planes = map::find_planes(driven.cloud);
  map::Solid solid = map::build_solid(driven.cloud, planes);
  const map::SolidCount n = map::count(solid);
  const map::Solid floor =
      map::raise_walls({}, map::known_map(map::build_occupancy_grid(driven.site)));
  solid.parts.insert(solid.parts.end(), floor.parts.begin(), floor.parts.end());
  const Camera camera(kEye, kAt);

  Figure figure{.width = 1400,
                .height = 580,
                .title = "A map of objects: what an upright laser saw of two rooms and a corridor"};
  const Box all = figure.whole();
  Panel points{
      .place = {0, all.top, all.width / 2, all.height},
      .title = fmt::format("{} points, without those of the ceiling", driven.cloud.points.size()),
      .framed = false,
      .marks = points_of(driven.cloud, camera)};
  points.legend = {{"0.5 to 0.85 m up", {}, ink::sky},
                   {"to 1.7 m", {}, ink::green},
                   {"to 2.4 m", {}, ink::orange}};
  Panel polygons{
      .place = {all.width / 2, all.top, all.width / 2, all.height},
      .title = fmt::format("{} planes as {} rectangles; {} triangles of what is not flat",
                           planes.planes.size(), n.quads, n.triangles),
      .framed = false,
      .marks = view_of(solid, camera)};
  figure.panels.push_back(std::move(points));
  figure.panels.push_back(std::move(polygons));
  return figure;
}

}  // namespace majak::draw
