// SPDX-License-Identifier: Apache-2.0
#include "majak/match/scan_points.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/beam_delay.hpp"

namespace majak::match {
namespace {

void project(const Scan& scan, const ScanPointsOptions& options, const BeamDirections& directions,
             ScanPoints& points, std::vector<int>& beams) {
  const std::size_t n = scan.ranges.size();
  points.x.resize(n);
  points.y.resize(n);
  beams.resize(n);
  const auto low = static_cast<float>(options.min_range),
             high = static_cast<float>(options.max_range);
  const auto lx = static_cast<float>(scan.T_robot_laser.x),
             ly = static_cast<float>(scan.T_robot_laser.y),
             offset = static_cast<float>(options.range_offset);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float range = scan.ranges[i];
    points.x[kept] = lx + (range - offset) * directions.cos[i];
    points.y[kept] = ly + (range - offset) * directions.sin[i];
    beams[kept] = static_cast<int>(i);
    kept += range > low && range < high;  // also false for NaN
  }
  points.x.resize(kept);
  points.y.resize(kept);
  beams.resize(kept);
}

// To first order: in a turn of the mirror the robot moves by centimetres.
void undo_motion(const Scan& scan, const ScanPointsOptions& options, const std::vector<int>& beams,
                 ScanPoints& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = beam_time(scan, static_cast<std::size_t>(beams[i]), options.mirror_turn);
    const Vec3 moved = t * options.twist;
    const double x = points.x[i], y = points.y[i];
    points.x[i] = static_cast<float>(x + moved.x() - moved.z() * y);
    points.y[i] = static_cast<float>(y + moved.y() + moved.z() * x);
  }
}

struct LineFit {
  float sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, n = 0;
  void add(float x, float y) { sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y, n += 1; }
};

// Neighbours on one side, as long as they follow one another on the same surface.
template <class Visit>
void walk(const ScanPoints& points, const std::vector<int>& beams, int i, int direction,
          float window, float gap, const Visit& visit) {
  const int n = static_cast<int>(beams.size());
  int last = i;
  for (int k = i + direction, count = 0; k >= 0 && k < n; k += direction) {
    if (std::abs(beams[k] - beams[last]) > 2) return;
    const float dx = points.x[k] - points.x[last], dy = points.y[k] - points.y[last];
    if (dx * dx + dy * dy > gap * gap) return;
    const float ex = points.x[k] - points.x[i], ey = points.y[k] - points.y[i];
    if (count >= 2 && ex * ex + ey * ey > window * window) return;
    visit(ex, ey);
    last = k;
    ++count;
  }
}

}  // namespace

double beam_time(const Scan& scan, std::size_t beam, double mirror_turn) {
  return beam_delay(scan.angle_step, beam, mirror_turn);
}

void BeamDirections::update(const Scan& scan) {
  const double first = scan.start_angle + scan.T_robot_laser.theta;
  if (start == first && step == scan.angle_step && cos.size() >= scan.ranges.size()) return;
  start = first, step = scan.angle_step;
  cos.resize(scan.ranges.size());
  sin.resize(scan.ranges.size());
  for (std::size_t i = 0; i < cos.size(); ++i) {
    const double angle = start + static_cast<double>(i) * step;
    cos[i] = static_cast<float>(std::cos(angle));
    sin[i] = static_cast<float>(std::sin(angle));
  }
}

ScanPoints scan_points(const Scan& scan, const ScanPointsOptions& options, bool with_normals) {
  BeamDirections directions;
  return scan_points(scan, options, with_normals, directions);
}

ScanPoints scan_points(const Scan& scan, const ScanPointsOptions& options, bool with_normals,
                       BeamDirections& directions) {
  ScanPoints points;
  std::vector<int> beams;
  directions.update(scan);
  points.laser = scan.T_robot_laser.translation();
  project(scan, options, directions, points, beams);
  if (!options.twist.isZero(0)) undo_motion(scan, options, beams, points);
  if (!with_normals) return points;

  const int n = static_cast<int>(points.size());
  points.nx.assign(n, 0.0F);
  points.ny.assign(n, 0.0F);
  points.target.assign(n, 0);
  const auto window = static_cast<float>(options.normal_window);
  const auto lx = static_cast<float>(scan.T_robot_laser.x),
             ly = static_cast<float>(scan.T_robot_laser.y);
  for (int i = 0; i < n; ++i) {
    const float rx = points.x[i] - lx, ry = points.y[i] - ly;
    const float range = std::sqrt(rx * rx + ry * ry);
    // A wall seen at 75 degrees of incidence spaces its returns four times wider than one seen
    // square.
    const float gap = std::max(0.10F, 4.0F * range * static_cast<float>(scan.angle_step));
    LineFit fit;
    fit.add(0, 0);
    const auto add = [&](float x, float y) { fit.add(x, y); };
    walk(points, beams, i, -1, window, gap, add);
    walk(points, beams, i, +1, window, gap, add);
    if (fit.n < 3) continue;
    const float mx = fit.sx / fit.n, my = fit.sy / fit.n;
    const float cxx = fit.sxx / fit.n - mx * mx, cyy = fit.syy / fit.n - my * my,
                cxy = fit.sxy / fit.n - mx * my;
    const float half_trace = 0.5F * (cxx + cyy), half_diff = 0.5F * (cxx - cyy);
    const float root = std::sqrt(half_diff * half_diff + cxy * cxy);
    const float large = half_trace + root, small = std::max(half_trace - root, 0.0F);
    const auto flat = static_cast<float>(options.max_flatness);
    if (large <= 0) continue;
    if (small > flat * flat * large) {
      const auto size = static_cast<float>(options.point_size);
      points.target[i] = 12.0F * large < size * size;  // rms along it to length of a bar
      continue;
    }
    points.target[i] = 1;
    // Normal: eigenvector of the smaller eigenvalue, turned towards the laser.
    float nx, ny;
    if (std::abs(cxy) > 1e-12F) {
      nx = small - cyy, ny = cxy;
      if (std::abs(nx) + std::abs(ny) < 1e-9F) nx = cxy, ny = small - cxx;
    } else {
      nx = cxx < cyy ? 1.0F : 0.0F, ny = cxx < cyy ? 0.0F : 1.0F;
    }
    const float norm = std::sqrt(nx * nx + ny * ny);
    const float sign = nx * rx + ny * ry > 0 ? -1.0F : 1.0F;
    points.nx[i] = sign * nx / norm;
    points.ny[i] = sign * ny / norm;
  }
  return points;
}

ScanPoints without_lone_things(const ScanPoints& points, double size, double depth) {
  const std::size_t n = points.size();
  const auto at = [&](std::size_t i) { return Vec2(points.x[i], points.y[i]); };
  const auto range = [&](std::size_t i) { return (at(i) - points.laser).norm(); };
  const auto farther = [&](std::size_t i, double than) { return range(i) > than + depth; };
  ScanPoints kept;
  kept.laser = points.laser;
  for (std::size_t first = 0, end = 0; first < n; first = end) {
    for (end = first + 1; end < n && (at(end) - at(end - 1)).norm() < depth;) ++end;
    const bool small = (at(end - 1) - at(first)).norm() < size;
    if (small && (first == 0 || farther(first - 1, range(first))) &&
        (end == n || farther(end, range(end - 1))))
      continue;
    for (std::size_t i = first; i < end; ++i) {
      kept.x.push_back(points.x[i]), kept.y.push_back(points.y[i]);
      if (points.nx.empty()) continue;
      kept.nx.push_back(points.nx[i]), kept.ny.push_back(points.ny[i]);
      kept.target.push_back(points.target[i]);
    }
  }
  return kept;
}

template <class Map>
void add_to(Map& map, const ScanPoints& points, const Pose2& T_map_robot) {
  const auto c = static_cast<float>(std::cos(T_map_robot.theta)),
             s = static_cast<float>(std::sin(T_map_robot.theta));
  const auto px = static_cast<float>(T_map_robot.x), py = static_cast<float>(T_map_robot.y);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points.target[i]) continue;
    map.add(px + c * points.x[i] - s * points.y[i], py + s * points.x[i] + c * points.y[i],
            c * points.nx[i] - s * points.ny[i], s * points.nx[i] + c * points.ny[i]);
  }
}

template void add_to(map::SurfelMap&, const ScanPoints&, const Pose2&);
template void add_to(map::SharedSurfelMap&, const ScanPoints&, const Pose2&);

}  // namespace majak::match
