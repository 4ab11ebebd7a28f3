// SPDX-License-Identifier: Apache-2.0
#include "majak/map/solid_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/map/rectangles.hpp"

namespace majak::map {
namespace {

constexpr double kUpright = 0.3, kLevel = 0.95;  // |z| of a normal: below: wall; above: floor
constexpr double kDarkest = 0.02;                // of all points are darker than what is black
constexpr int kMostCells = 8192;                 // along a side of a plane

/// From intensity to grey: even steps of the logarithm, between what few are darker and brighter.
class Shades {
 public:
  explicit Shades(const SolidCloud& cloud) {
    std::vector<float> all;
    for (const SolidPoint& p : cloud.points)
      if (p.intensity > 0) all.push_back(p.intensity);
    if (!cloud.has_intensity || all.empty()) return;
    std::sort(all.begin(), all.end());
    const auto at = [&](double share) {
      return std::log(static_cast<double>(
          all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))]));
    };
    low_ = at(kDarkest), high_ = std::max(at(1 - kDarkest), low_ + 1e-3), known_ = true;
  }
  bool known() const { return known_; }
  Rgb of(double intensity) const {
    const double share = (std::log(std::max(intensity, 1e-9)) - low_) / (high_ - low_);
    const auto grey =
        static_cast<std::uint8_t>(std::lround(40 + 210 * std::clamp(share, 0.0, 1.0)));
    return {grey, grey, grey};
  }

 private:
  bool known_ = false;
  double low_ = 0, high_ = 1;
};

/// A hue a number, far from those before (steps of the golden angle).
Rgb hue(std::size_t number) {
  const auto part = [&](double shift) {
    const double turn = 0.618033988749895 * static_cast<double>(number) + shift;
    return static_cast<std::uint8_t>(std::lround(165 + 65 * std::cos(2 * kPi * turn)));
  };
  return {part(0), part(1.0 / 3), part(2.0 / 3)};
}

const char* kind_of(const Plane& plane) {
  const double z = plane.normal.z();
  if (std::abs(z) < kUpright) return "wall";
  if (z > kLevel) return "floor";
  return z < -kLevel ? "ceiling" : "slope";
}

/// The direction of most walls, rad, modulo a quarter turn: rectangles on floors lie along it.
double wall_direction(const PlaneMap& planes) {
  double c = 0, s = 0;
  for (const Plane& plane : planes.planes) {
    if (std::abs(plane.normal.z()) >= kUpright) continue;
    const double angle = std::atan2(plane.normal.y(), plane.normal.x());
    c += plane.support * std::cos(4 * angle), s += plane.support * std::sin(4 * angle);
  }
  return std::atan2(s, c) / 4;
}

/// Axes within a plane: u x v = normal; u level, on floors along the walls.
struct PlaneAxes {
  Vec3 u, v;
  PlaneAxes(const Vec3& normal, double walls) {
    const bool level = std::abs(normal.z()) > kLevel;
    const Vec3 across{-std::sin(walls), std::cos(walls), 0};
    u = (level ? across.cross(normal) : Vec3::UnitZ().cross(normal)).normalized();
    v = normal.cross(u);
  }
};

/// Cells of a plane that hold points, and what is known of each.
struct PlaneCells {
  CellMask mask;
  int x0 = 0, y0 = 0;
  std::vector<double> intensity;  // mean, a cell; 0: no point
};

PlaneCells cells_of(const SolidCloud& cloud, const std::vector<std::uint32_t>& members,
                    const Plane& plane, const PlaneAxes& axes, int border) {
  struct Hit {
    int x, y;
    double intensity;
  };
  std::vector<Hit> hits;
  for (const std::uint32_t i : members) {
    const Vec3 off = cloud.points[i].mean - plane.centre;
    hits.push_back({static_cast<int>(std::floor(off.dot(axes.u) / cloud.voxel)),
                    static_cast<int>(std::floor(off.dot(axes.v) / cloud.voxel)),
                    static_cast<double>(cloud.points[i].intensity)});
  }
  PlaneCells cells;
  const auto [left, right] = std::minmax_element(
      hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.x < b.x; });
  const auto [low, high] = std::minmax_element(
      hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.y < b.y; });
  cells.x0 = left->x - border, cells.y0 = low->y - border;
  cells.mask.width = std::min(right->x - left->x + 1 + 2 * border, kMostCells);
  cells.mask.height = std::min(high->y - low->y + 1 + 2 * border, kMostCells);
  cells.mask.cells.resize(cells.mask.index(0, cells.mask.height));
  cells.intensity.resize(cells.mask.cells.size());
  std::vector<int> count(cells.mask.cells.size());
  for (const Hit& hit : hits) {
    const int x = hit.x - cells.x0, y = hit.y - cells.y0;
    if (!cells.mask.inside(x, y)) continue;
    const std::size_t at = cells.mask.index(x, y);
    cells.mask.cells[at] = 1;
    cells.intensity[at] += (hit.intensity - cells.intensity[at]) / ++count[at];
  }
  return cells;
}

/// Morphological closing: cells from which no disc of that radius outside the mask reaches.
void close_gaps(CellMask& mask, double radius, double cell) {
  const double square = radius / cell * (radius / cell);
  const auto far_from = [&](const CellMask& from) {
    const std::vector<std::int32_t> distance = squared_distances(from);
    CellMask far = from;
    for (std::size_t i = 0; i < far.cells.size(); ++i)
      far.cells[i] = static_cast<double>(distance[i]) > square;
    return far;
  };
  mask = far_from(far_from(mask));
}

double mean_intensity(const PlaneCells& cells, const CellBox& box) {
  double sum = 0;
  int n = 0;
  for (int y = box.y0; y < box.y0 + box.height; ++y)
    for (int x = box.x0; x < box.x0 + box.width; ++x)
      if (const double i = cells.intensity[cells.mask.index(x, y)]; i > 0) sum += i, ++n;
  return n > 0 ? sum / n : 0;
}

void add_flat(SolidPart& part, const SolidCloud& cloud, const std::vector<std::uint32_t>& members,
              const Plane& plane, const PlaneAxes& axes, const Shades& shades, const Rgb& plain,
              double close) {
  const double side = cloud.voxel;
  PlaneCells cells =
      cells_of(cloud, members, plane, axes, 1 + static_cast<int>(std::ceil(close / side)));
  close_gaps(cells.mask, close, side);
  for (const CellBox& box : rectangles_of(cells.mask)) {
    const Vec3 corner =
        plane.centre + (cells.x0 + box.x0) * side * axes.u + (cells.y0 + box.y0) * side * axes.v;
    add_rectangle(part, corner, box.width * side * axes.u, box.height * side * axes.v,
                  shades.known() ? shades.of(mean_intensity(cells, box)) : plain);
  }
}

/// The triangles that `keep` wants, with the points that they need.
template <class Keep>
SolidPart triangles_of(const SolidCloud& cloud, const Shades& shades, std::string name,
                       const Keep& keep) {
  SolidPart part{.name = std::move(name)};
  std::vector<std::uint32_t> number(cloud.points.size(), UINT32_MAX);
  for (const auto& triangle : cloud.triangles) {
    if (!keep(triangle)) continue;
    std::array<std::uint32_t, 3> face{};
    for (std::size_t k = 0; k < 3; ++k) {
      const SolidPoint& p = cloud.points[triangle[k]];
      if (number[triangle[k]] == UINT32_MAX) {
        number[triangle[k]] = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(p.mean.cast<float>());
        part.normals.push_back((p.normal.isZero() ? p.towards : p.normal).cast<float>());
        part.colours.push_back(shades.known() ? shades.of(static_cast<double>(p.intensity))
                                              : Rgb{120, 160, 120});
      }
      face[k] = number[triangle[k]];
    }
    part.triangles.push_back(face);
  }
  return part;
}

}  // namespace

Solid build_solid(const SolidCloud& cloud, const PlaneMap& planes, const SolidOptions& options) {
  if (!(options.close >= 0 && options.close <= 10)) throw Error("solid: close must be 0 ... 10 m");
  Solid solid;
  const Shades shades(cloud);
  const double walls = wall_direction(planes);
  std::vector<std::vector<std::uint32_t>> members(planes.planes.size());
  for (std::uint32_t i = 0; i < planes.plane_of.size(); ++i)
    if (planes.plane_of[i] >= 0) members[static_cast<std::size_t>(planes.plane_of[i])].push_back(i);
  std::map<std::string, int> numbers;
  for (std::size_t j = 0; j < members.size(); ++j) {
    if (members[j].empty()) continue;
    const Plane& plane = planes.planes[j];
    const std::string kind = kind_of(plane);
    SolidPart part{.name = kind + " " + std::to_string(++numbers[kind])};
    add_flat(part, cloud, members[j], plane, {plane.normal, walls}, shades, hue(j), options.close);
    solid.parts.push_back(std::move(part));
  }
  SolidPart rest = triangles_of(cloud, shades, "rest", [&](const auto& triangle) {
    return std::any_of(triangle.begin(), triangle.end(),
                       [&](std::uint32_t i) { return planes.plane_of[i] < 0; });
  });
  if (!rest.cloud()) solid.parts.push_back(std::move(rest));
  return solid;
}

Solid points_solid(const SolidCloud& cloud) {
  const Shades shades(cloud);
  SolidPart part{.name = "points"};
  for (const SolidPoint& p : cloud.points) {
    part.vertices.push_back(p.mean.cast<float>());
    part.normals.push_back((p.normal.isZero() ? p.towards : p.normal).cast<float>());
    part.colours.push_back(shades.known() ? shades.of(static_cast<double>(p.intensity)) : hue(0));
  }
  return {{std::move(part)}};
}

Solid mesh_solid(const SolidCloud& cloud) {
  return {{triangles_of(cloud, Shades(cloud), "mesh", [](const auto&) { return true; })}};
}

}  // namespace majak::map
