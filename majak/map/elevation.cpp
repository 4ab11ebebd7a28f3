// SPDX-License-Identifier: Apache-2.0
#include "majak/map/elevation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

constexpr int kLongest = 32767;  // cells along a side
constexpr int kFewest = 5;       // cells that tell of a slope
constexpr double kGap = 1.5;     // cubes; layers of a column farther apart do not hang together

void check(const ElevationOptions& o) {
  const bool good = o.max_step > 0 && o.max_slope > 0 && o.max_slope < kPi / 2 && o.clearance > 0 &&
                    o.slope_radius > 0 && o.sigma > 0;
  if (!good) throw Error("elevation: an option is out of its range");
}

CellBox box_of(const SolidCloud& cloud) {
  if (cloud.points.empty()) return {};
  auto low = cloud.points[0].cell, high = low;
  for (const SolidPoint& p : cloud.points)
    for (std::size_t k = 0; k < 2; ++k)
      low[k] = std::min(low[k], p.cell[k]), high[k] = std::max(high[k], p.cell[k]);
  const CellBox box{low[0], low[1], high[0] - low[0] + 1, high[1] - low[1] + 1};
  if (std::max(box.width, box.height) > kLongest)
    throw Error("elevation: the place is larger than 32767 cells; take a larger points.voxel");
  return box;
}

/// The points of one column, from below.
using Column = std::vector<const SolidPoint*>;

/// The ground is what lies lowest, as long as its heights differ by less than a step; what hangs
/// together with it stands on it; what hangs above must leave room for the robot.
ElevationCell cell_of(const Column& column, double voxel, const ElevationOptions& o) {
  ElevationCell cell;
  double sum = 0, squares = 0;
  std::size_t i = 0;
  for (; i < column.size() && column[i]->mean.z() - column[0]->mean.z() < o.max_step; ++i) {
    const SolidPoint& p = *column[i];
    cell.count += p.count;
    sum += p.count * p.mean.z();
    squares += p.count * (p.variance_z + p.mean.z() * p.mean.z());
  }
  cell.height = sum / cell.count;
  const double spread =
      std::max(squares / cell.count - cell.height * cell.height, o.sigma * o.sigma);
  cell.variance = spread / cell.count;
  cell.top = cell.height;
  cell.ground = Ground::passable;
  double below = column[i - 1]->mean.z();
  for (bool stands = true; i < column.size(); ++i) {
    const double z = column[i]->mean.z();
    stands = stands && z - below < kGap * voxel;
    if (!stands && z - cell.height >= o.clearance) break;
    cell.ground = Ground::obstacle;
    cell.top = below = z;
  }
  return cell;
}

/// Plane of least squares through the heights around a cell (22.6), each by its variance.
void fit_slope(const Elevation& map, int ix, int iy, const ElevationOptions& o,
               ElevationCell& cell) {
  const int reach = std::max(1, static_cast<int>(std::lround(o.slope_radius / map.resolution)));
  Mat3 A = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  int n = 0;
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx) {
      if (dx * dx + dy * dy > reach * reach || !map.inside(ix + dx, iy + dy)) continue;
      const ElevationCell& there = map.at(ix + dx, iy + dy);
      if (there.ground == Ground::unknown || there.ground == Ground::obstacle) continue;
      const Vec3 row(1, dx * map.resolution, dy * map.resolution);
      const double weight = 1 / (there.variance + o.sigma * o.sigma);
      A += weight * row * row.transpose(), b += weight * (there.height - cell.height) * row, ++n;
    }
  Mat3 inverse;
  bool regular = false;
  A.computeInverseWithCheck(inverse, regular, 1e-9);
  if (n < kFewest || !regular) return;
  const Vec3 x = inverse * b;
  cell.gradient = x.tail<2>();
  cell.covariance = inverse.bottomRightCorner<2, 2>();
}

bool has_step(const Elevation& map, int ix, int iy, double max_step) {
  const ElevationCell& here = map.at(ix, iy);
  for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    if (!map.inside(ix + dx, iy + dy)) continue;
    const ElevationCell& there = map.at(ix + dx, iy + dy);
    if (there.ground != Ground::unknown && there.ground != Ground::obstacle &&
        std::abs(there.height - here.height) > max_step)
      return true;
  }
  return false;
}

/// Slopes of all cells from the heights of their neighbours, then what kind of ground they are.
void judge(Elevation& map, const ElevationOptions& o) {
  Elevation judged = map;
  std::size_t i = 0;
  for (int iy = map.box.y0; iy < map.box.y0 + map.box.height; ++iy)
    for (int ix = map.box.x0; ix < map.box.x0 + map.box.width; ++ix, ++i) {
      ElevationCell& cell = judged.cells[i];
      if (cell.ground != Ground::passable) continue;
      fit_slope(map, ix, iy, o, cell);
      if (has_step(map, ix, iy, o.max_step))
        cell.ground = Ground::step;
      else if (cell.slope_known() && cell.slope() > o.max_slope)
        cell.ground = Ground::steep;
    }
  map = std::move(judged);
}

constexpr Rgb kColours[] = {{}, {96, 170, 96}, {230, 200, 60}, {230, 140, 40}, {200, 62, 32}};

}  // namespace

const char* name_of(Ground ground) {
  constexpr const char* kNames[] = {"unknown", "passable", "steep", "step", "obstacle"};
  return kNames[static_cast<std::size_t>(ground)];
}

double ElevationCell::slope_sigma() const {
  const double g = gradient.norm();
  const Vec2 along = g > 0 ? Vec2(gradient / g) : Vec2(Vec2::UnitX());
  return std::sqrt(along.dot(covariance * along)) / (1 + g * g);
}

const ElevationCell& Elevation::at(int ix, int iy) const {
  static const ElevationCell none;
  if (!inside(ix, iy)) return none;
  return cells[static_cast<std::size_t>(iy - box.y0) * static_cast<std::size_t>(box.width) +
               static_cast<std::size_t>(ix - box.x0)];
}

const ElevationCell& Elevation::at(const Vec2& p) const {
  return at(static_cast<int>(std::floor(p.x() / resolution)),
            static_cast<int>(std::floor(p.y() / resolution)));
}

Elevation build_elevation(const SolidCloud& cloud, const ElevationOptions& options) {
  check(options);
  Elevation map{cloud.voxel, box_of(cloud), {}};
  const auto width = static_cast<std::size_t>(map.box.width);
  std::vector<Column> columns(width * static_cast<std::size_t>(map.box.height));
  for (const SolidPoint& p : cloud.points)  // from low z
    columns[static_cast<std::size_t>(p.cell[1] - map.box.y0) * width +
            static_cast<std::size_t>(p.cell[0] - map.box.x0)]
        .push_back(&p);
  map.cells.resize(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (!columns[i].empty()) map.cells[i] = cell_of(columns[i], cloud.voxel, options);
  judge(map, options);
  return map;
}

Solid elevation_solid(const Elevation& map) {
  Solid solid;
  for (const Ground kind : {Ground::passable, Ground::steep, Ground::step, Ground::obstacle}) {
    SolidPart part{.name = name_of(kind)};
    std::size_t i = 0;
    for (int iy = map.box.y0; iy < map.box.y0 + map.box.height; ++iy)
      for (int ix = map.box.x0; ix < map.box.x0 + map.box.width; ++ix, ++i) {
        const ElevationCell& cell = map.cells[i];
        if (cell.ground != kind) continue;
        // Tilted as the ground is, about the cell's middle.
        const double side = map.resolution;
        const Vec3 u{side, 0, side * cell.gradient.x()}, v{0, side, side * cell.gradient.y()};
        const Vec3 middle{(ix + 0.5) * side, (iy + 0.5) * side,
                          kind == Ground::obstacle ? cell.top : cell.height};
        add_rectangle(part, middle - (u + v) / 2, u, v, kColours[static_cast<std::size_t>(kind)]);
      }
    if (!part.cloud()) solid.parts.push_back(std::move(part));
  }
  return solid;
}

}  // namespace majak::map
