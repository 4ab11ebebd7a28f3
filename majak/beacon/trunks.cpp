// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/trunks.hpp"

#include <algorithm>
#include <cmath>

namespace majak::beacon {
namespace {

constexpr double kUneven = 0.15;  // m, by which bark and branches differ from a circle
constexpr double kVague = 0.5;    // of an angle step, of where an edge lies
constexpr double kLost = 0.1;     // m between the beams beside one that was lost on a trunk

// What a beam tells beside a trunk: nothing nearer than `range` may be there, and nothing is known
// of a beam that was dazzled.
bool clear(const Scan& scan, std::size_t beam, double range) {
  return scan.ranges[beam] > range;  // also where there is no return; not where it is invalid
}

// The beam after `beam` that meets the same thing, or `beam`; one in between may be lost.
std::size_t next_on(const Scan& scan, std::size_t beam, double gap) {
  const auto off = [&](std::size_t next) {
    return std::abs(scan.ranges[next] - scan.ranges[beam]);
  };
  if (beam + 1 < scan.ranges.size() && off(beam + 1) < gap) return beam + 1;
  const bool lost = beam + 2 < scan.ranges.size() && !std::isfinite(scan.ranges[beam + 1]);
  return lost && off(beam + 2) < kLost ? beam + 2 : beam;
}

// Of a circle that is seen under `wide` rad and whose nearest point is `near` m off:
// sin(wide / 2) = (d / 2) / (near + d / 2).
double diameter(double near, double wide) {
  const double sine = std::sin(std::clamp(wide / 2, 0.0, kPi / 4));
  return 2 * near * sine / (1 - sine);
}

// Way to the centre of a circle in the middle of these beams: each says where the centre is if it
// met a circle of that diameter; the outer ones tell little.
double centre_range(const Scan& scan, std::size_t first, std::size_t last, double diameter) {
  const std::size_t edge = (last - first + 1) / 4;
  double sum = 0;
  int middle = 0;
  for (std::size_t i = first + edge; i <= last - edge; ++i) {
    const double r = scan.ranges[i], aside = 0.5 * (scan.angle(last) + scan.angle(first));
    if (!std::isfinite(r)) continue;
    const double off = r * std::sin(scan.angle(i) - aside);
    sum += r * std::cos(scan.angle(i) - aside) +
           std::sqrt(std::max(0.0, diameter * diameter / 4 - off * off));
    ++middle;
  }
  return sum / middle;
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
    for (std::size_t next; (next = next_on(scan, last, o.gap)) != last; last = next)
      near = std::min(near, scan.ranges[next]), far = std::max(far, scan.ranges[next]);
    const auto beams = static_cast<int>(last - first) + 1;
    if (beams < o.least_beams || last + 1 >= n) continue;
    if (!clear(scan, first - 1, far + o.clearance) || !clear(scan, last + 1, far + o.clearance))
      continue;
    const double d = diameter(near, beams * step - o.spot);
    if (d > o.max_diameter || far - near > d / 2 + kUneven) continue;
    if (!lone(scan, first, last, near, o.lone)) continue;
    LandmarkSighting s;
    s.diameter = d;
    s.diameter_sigma = std::hypot(near * step * kVague, kUneven / 3);
    s.range = centre_range(scan, first, last, d);
    s.bearing = wrap_angle(0.5 * (scan.angle(first) + scan.angle(last)));
    s.range_sigma = std::hypot(o.range_sigma, s.diameter_sigma / 2);
    s.bearing_sigma = o.bearing_sigma * step;
    s.beam = (first + last) / 2;
    found.push_back(s);
  }
  return found;
}

}  // namespace majak::beacon
