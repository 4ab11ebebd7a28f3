// SPDX-License-Identifier: Apache-2.0
// Three dimensions: walls raised from the plane, and what a laser out of the plane has seen.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/draw/face.hpp"
#include "majak/draw/face_figure.hpp"
#include "majak/draw/solid_view.hpp"
#include "majak/io/solid_files.hpp"

namespace majak::draw {
namespace {

const map::SolidCloud& cloud_of(const FaceOptions& o) {
  if (o.cloud == nullptr)
    throw Error("that takes the log of a second laser, out of the plane: --log LOG --look up");
  if (o.cloud->points.empty()) throw Error("no beam of the second laser met anything");
  return *o.cloud;
}

std::vector<FaceFile> solid_files(const std::string& name, const map::Solid& solid) {
  return {{name + ".wrl", io::solid_vrml(solid)},
          {name + ".glb", io::solid_gltf(solid)},
          {name + ".ply", io::solid_ply(solid)}};
}

/// Figure, files and counts of a solid.
FacePage page_of(const std::string& title, const std::string& name, const map::Solid& solid) {
  const map::SolidCount n = map::count(solid);
  FacePage page;
  Panel panel{.place = {0, 40, 1000, 660}, .framed = false};
  panel.marks = view_of(solid, overlooking(solid));
  page.figure = {.width = 1000, .height = 700, .title = title};
  page.figure.panels.push_back(std::move(panel));
  page.figures = {{"parts", static_cast<double>(n.parts)},
                  {"rectangles", static_cast<double>(n.quads)},
                  {"triangles", static_cast<double>(n.triangles)},
                  {"vertices", static_cast<double>(n.vertices)}};
  page.bytes = n.vertices * (2 * sizeof(Eigen::Vector3f) + sizeof(map::Rgb)) +
               n.quads * sizeof(std::array<std::uint32_t, 4>) +
               n.triangles * sizeof(std::array<std::uint32_t, 3>);
  page.files = solid_files(name, solid);
  return page;
}

Colour height_colour(double share) {
  const auto part = [&](double low, double high) {
    return static_cast<std::uint8_t>(std::lround(low + (high - low) * std::clamp(share, 0.0, 1.0)));
  };
  return {part(48, 240), part(92, 226), part(140, 160)};
}

}  // namespace

FacePage raised_face(const Site& site, const FaceOptions& o) {
  const map::Solid solid = map::raise_walls(site, o.raise, o.segments, o.grid, o.threads);
  if (solid.parts.empty())
    throw Error("no wall and no free floor; try --set segments.min_length=0.2");
  FacePage page = page_of("Walls, raised", "walls", solid);
  page.lead = fmt::format(
      "The walls of the segment map, upright on the free floor. How high they are no level laser "
      "sees: they are drawn {} m high.",
      o.raise.height);
  return page;
}

FacePage solid_face(const Site& /*site*/, const FaceOptions& o) {
  const map::SolidCloud& cloud = cloud_of(o);
  const map::PlaneMap planes = map::find_planes(cloud, o.planes, o.threads);
  const auto flat = std::count_if(planes.plane_of.begin(), planes.plane_of.end(),
                                  [](std::int32_t plane) { return plane >= 0; });
  FacePage page =
      page_of("Planes, and what is not flat", "solid", map::build_solid(cloud, planes, o.solid));
  page.lead =
      "What the second laser saw: flat surfaces as rectangles, everything else as the small "
      "triangles of neighbouring beams; what faces away from here is not drawn.";
  page.figures.emplace_back("planes", static_cast<double>(planes.planes.size()));
  page.figures.emplace_back("points", static_cast<double>(cloud.points.size()));
  page.figures.emplace_back("points_on_planes", static_cast<double>(flat));
  page.files.push_back({"points.ply", io::solid_ply(map::points_solid(cloud))});
  page.files.push_back({"mesh.ply", io::solid_ply(map::mesh_solid(cloud))});
  return page;
}

FacePage elevation_face(const Site& /*site*/, const FaceOptions& o) {
  const map::Elevation map = map::build_elevation(cloud_of(o), o.elevation);
  double low = 1e30, high = -1e30, counts[5] = {};
  for (const map::ElevationCell& cell : map.cells) {
    ++counts[static_cast<std::size_t>(cell.ground)];
    if (cell.ground == map::Ground::unknown || cell.ground == map::Ground::obstacle) continue;
    low = std::min(low, cell.height), high = std::max(high, cell.height);
  }
  const auto colour = [&](int ix, int iy) -> Colour {
    const map::ElevationCell& cell = map.at(ix, iy);
    switch (cell.ground) {
      case map::Ground::unknown:
        return ink::white;
      case map::Ground::obstacle:
        return ink::black;
      case map::Ground::step:
        return ink::red;
      case map::Ground::steep:
        return ink::orange;
      case map::Ground::passable:
        break;
    }
    return height_colour((cell.height - low) / std::max(high - low, 0.1));
  };
  std::vector<Mark> marks;
  if (auto picture = cells_picture(map.box, map.resolution, colour))
    marks.emplace_back(std::move(*picture));
  FacePage page;
  page.lead = fmt::format(
      "Passable ground from {:.2f} m (dark) to {:.2f} m (light); black: obstacles, red: steps of "
      "more than {} m, orange: steeper than {:.0f} degrees. The robot itself is taken to move in "
      "the plane.",
      std::min(low, high), high, o.elevation.max_step, degrees(o.elevation.max_slope));
  page.figure = map_sheet("Elevation", std::move(marks));
  page.bytes = map.cells.size() * sizeof(map::ElevationCell);
  const double cell = map.resolution * map.resolution;
  page.figures = {{"passable_m2", counts[1] * cell},
                  {"steep_m2", counts[2] * cell},
                  {"step_m2", counts[3] * cell},
                  {"obstacle_m2", counts[4] * cell}};
  page.files = solid_files("elevation", map::elevation_solid(map));
  return page;
}

}  // namespace majak::draw
