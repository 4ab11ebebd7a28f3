// SPDX-License-Identifier: Apache-2.0
// Figure 20 of the thesis: a map of objects. A robot with one level and one upright laser has
// driven through rooms; seen from above, without the ceiling: the upright one's points, and the
// planes among them as polygons on the floor that the level one knows.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "majak/draw/thesis_figures.hpp"
#include "majak/map/raised_walls.hpp"
#include "majak/map/solid_map.hpp"
#include "majak/sim/solid_simulator.hpp"

namespace majak::draw {
namespace {

constexpr double kTile = 0.5;     // m; larger rectangles are cut, so that nearer hides farther
constexpr double kCeiling = 2.4;  // m; points above are left out
const Vec3 kEye{2.5, -9.5, 11.5}, kAt{6, 3.6, 0.6};
const Vec3 kLight = Vec3(0.5, -0.35, 0.8).normalized();

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

/// Perspective: what is at `p` is seen at these tangents, right and up.
class Camera {
 public:
  Camera(const Vec3& eye, const Vec3& at) : eye_(eye), ahead_((at - eye).normalized()) {
    right_ = ahead_.cross(Vec3::UnitZ()).normalized();
    up_ = right_.cross(ahead_);
  }
  Point see(const Vec3& p) const {
    const Vec3 way = p - eye_;
    const double far = way.dot(ahead_);
    return {way.dot(right_) / far, way.dot(up_) / far};
  }
  double distance(const Vec3& p) const { return (p - eye_).norm(); }
  bool faces(const Vec3& normal, const Vec3& p) const { return normal.dot(eye_ - p) > 0; }

 private:
  Vec3 eye_, ahead_, right_, up_;
};

struct Tile {
  double distance;
  Polyline shape;
};

Colour lit(const map::Rgb& c, const Vec3& normal) {
  const double light = 0.68 + 0.32 * normal.dot(kLight);
  const auto part = [&](std::uint8_t v) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(v * light), 0L, 255L));
  };
  return {part(c.r), part(c.g), part(c.b)};
}

void add_tile(std::vector<Tile>& tiles, const Camera& camera, const std::vector<Vec3>& corners,
              const Vec3& normal, const map::Rgb& colour) {
  Vec3 middle = Vec3::Zero();
  Tile tile{0, {{}, {}, true, lit(colour, normal)}};
  for (const Vec3& p : corners) {
    middle += p / static_cast<double>(corners.size());
    tile.shape.points.push_back(camera.see(p));
  }
  if (!camera.faces(normal, middle)) return;
  tile.shape.pen = {*tile.shape.fill, 0.6};  // over the seams
  tile.distance = camera.distance(middle);
  tiles.push_back(std::move(tile));
}

void add_quad(std::vector<Tile>& tiles, const Camera& camera, const map::SolidPart& part,
              const std::array<std::uint32_t, 4>& q) {
  const auto vertex = [&](std::size_t k) { return Vec3(part.vertices[q[k]].cast<double>()); };
  const Vec3 u = vertex(1) - vertex(0), v = vertex(3) - vertex(0);
  const int nu = static_cast<int>(std::ceil(u.norm() / kTile)),
            nv = static_cast<int>(std::ceil(v.norm() / kTile));
  for (int i = 0; i < nu; ++i)
    for (int k = 0; k < nv; ++k) {
      const Vec3 p = vertex(0) + i * u / nu + k * v / nv;
      add_tile(tiles, camera, {p, p + u / nu, p + u / nu + v / nv, p + v / nv},
               part.normals[q[0]].cast<double>(), part.colours[q[0]]);
    }
}

/// Painted from the farthest to the nearest.
std::vector<Mark> seen(const map::Solid& solid, const Camera& camera) {
  std::vector<Tile> tiles;
  for (const map::SolidPart& part : solid.parts) {
    for (const auto& q : part.quads) add_quad(tiles, camera, part, q);
    for (const auto& t : part.triangles) {
      std::vector<Vec3> corners;
      for (const std::uint32_t i : t) corners.emplace_back(part.vertices[i].cast<double>());
      const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
      add_tile(tiles, camera, corners, normal, part.colours[t[0]]);
    }
  }
  std::stable_sort(tiles.begin(), tiles.end(),
                   [](const Tile& a, const Tile& b) { return a.distance > b.distance; });
  std::vector<Mark> marks;
  for (Tile& tile : tiles) marks.emplace_back(std::move(tile.shape));
  return marks;
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
                .height = 620,
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
      .marks = seen(solid, camera)};
  figure.panels.push_back(std::move(points));
  figure.panels.push_back(std::move(polygons));
  return figure;
}

}  // namespace majak::draw
