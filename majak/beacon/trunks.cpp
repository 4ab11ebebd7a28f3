// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/trunks.hpp"

#include <algorithm>
#include <cmath>

namespace majak::beacon {
namespace {

constexpr double kUneven = 0.15;  // m, by which bark and branches differ from a circle
constexpr double kVague = 0.5;    // of an angle step, of where an edge lies

// What a beam tells beside a trunk: nothing nearer than `range` may be there, and nothing is known
// of a beam that was dazzled.
bool clear(const Scan& scan, std::size_t beam, double range) {
  return scan.ranges[beam] > range;  // also where there is no return; not where it is invalid
}

Vec2 point(const Scan& scan, std::size_t beam) {
  return scan.ranges[beam] * Vec2(std::cos(scan.angle(beam)), std::sin(scan.angle(beam)));
}

// Hedges and crowds that some beams miss look like many trunks.
bool lone(const Scan& scan, std::size_t first, std::size_t last, double range, double around) {
  const auto beams = static_cast<std::size_t>(around / range / std::abs(scan.angle_step)) + 1;
  const Vec2 here = point(scan, (first + last) / 2);
  const std::size_t begin = first - std::min(first, beams);
  const std::size_t end = std::min(scan.ranges.size(), last + beams + 1);
  for (std::size_t i = begin; i < end; ++i) {
    const bool own = i >= first && i <= last;
    if (!own && std::isfinite(scan.ranges[i]) && (point(scan, i) - here).norm() < around)
      return false;
  }
  return true;
}

}  // namespace

std::vector<LandmarkSighting> find_trunks(const Scan& scan, const TrunkOptions& o) {
  std::vector<LandmarkSighting> found;
  const std::size_t n = scan.ranges.size();
  const double step = std::abs(scan.angle_step);
  for (std::size_t first = 1, last = 0; first + 1 < n; first = last + 1) {
    last = first;
    float near = scan.ranges[first], far = near;
    if (!(near > o.min_range && near < o.max_range)) continue;
    while (last + 1 < n && std::abs(scan.ranges[last + 1] - scan.ranges[last]) < o.gap) {
      ++last;
      near = std::min(near, scan.ranges[last]), far = std::max(far, scan.ranges[last]);
    }
    const auto beams = static_cast<int>(last - first) + 1;
    if (beams < o.least_beams || last + 1 >= n) continue;
    if (!clear(scan, first - 1, far + o.clearance) || !clear(scan, last + 1, far + o.clearance))
      continue;
    const double d = near * (beams * step);
    if (d > o.max_diameter || far - near > d / 2 + kUneven) continue;
    if (!lone(scan, first, last, near, o.lone)) continue;
    double sum = 0;  // over the middle half, where the circle is flat
    int middle = 0;
    for (std::size_t i = first + static_cast<std::size_t>(beams / 4);
         i <= last - static_cast<std::size_t>(beams / 4); ++i)
      sum += scan.ranges[i], ++middle;
    LandmarkSighting s;
    s.diameter = d;
    s.diameter_sigma = std::hypot(near * step * kVague, kUneven / 3);
    s.range = sum / middle + d / 2;
    s.bearing = wrap_angle(0.5 * (scan.angle(first) + scan.angle(last)));
    s.range_sigma = std::hypot(o.range_sigma, s.diameter_sigma / 2);
    s.bearing_sigma = o.bearing_sigma * step;
    s.beam = (first + last) / 2;
    found.push_back(s);
  }
  return found;
}

}  // namespace majak::beacon
