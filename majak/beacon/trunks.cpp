// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/trunks.hpp"

#include <algorithm>
#include <cmath>

namespace majak::beacon {
namespace {

constexpr double kUneven = 0.15;    // m, by which bark and branches differ from a circle
constexpr double kVague = 0.5;      // of an angle step, of where an edge lies
constexpr double kThinnest = 1e-4;  // rad, half the angle of what is no wider than a beam
constexpr double kLost = 0.1;       // m between the beams beside one that was lost on a trunk

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

// Of a circle that is seen under the half angle `half` and whose nearest point is `near` m off:
// sin(half) = (d / 2) / (near + d / 2).
double diameter(double near, double half) {
  const double sine = std::sin(half);
  return 2 * near * sine / (1 - sine);
}

// Way to the bark in the direction `aside`, in the mean over these beams.
double bark_range(const Scan& scan, std::size_t first, std::size_t last, double aside) {
  double sum = 0;
  int met = 0;
  for (std::size_t i = first; i <= last; ++i)
    if (std::isfinite(scan.ranges[i]))
      sum += scan.ranges[i] * std::cos(scan.angle(i) - aside), ++met;
  return sum / met;
}

// How far behind that the centre is, of a diameter, seen under the half angle `half`: the mean over
// directions that are spread evenly over this share of it (MATH 14.2).
double depth(double share, double half) {
  constexpr int kParts = 16;
  const double sine = std::sin(half);
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    const double angle = share * half * (i + 0.5) / kParts, across = std::sin(angle) / sine;
    sum += across * across * sine + std::cos(angle) * std::sqrt(1 - across * across);
  }
  return sum / (2 * kParts);
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
    const double half = std::clamp(0.5 * (beams * step - o.spot), kThinnest, kPi / 4);
    const double d = diameter(near, half);
    if (d > o.max_diameter || far - near > d / 2 + kUneven) continue;
    if (!lone(scan, first, last, near, o.lone)) continue;
    LandmarkSighting s;
    s.diameter = d;
    s.diameter_sigma = std::hypot(near * step * kVague, kUneven / 3);
    const std::size_t edge = (last - first + 1) / 4;  // the outer beams tell little
    s.bearing = 0.5 * (scan.angle(first) + scan.angle(last));
    s.depth = depth(1 - 2.0 * static_cast<double>(edge) / beams, half);
    s.range = bark_range(scan, first + edge, last - edge, s.bearing) + s.depth * d;
    s.bearing = wrap_angle(s.bearing);
    s.range_sigma = std::hypot(o.range_sigma, s.depth * s.diameter_sigma);
    s.bearing_sigma = o.bearing_sigma * step;
    s.beam = (first + last) / 2;
    found.push_back(s);
  }
  return found;
}

void describe(OptionFields& f, TrunkOptions& o) {
  f.add("trunks.max_range", o.max_range, {"m", "of trunks and poles", 1, 1000});
  f.add("trunks.min_range", o.min_range, {"m", "of trunks and poles", 0, 1000});
  f.add("trunks.max_diameter", o.max_diameter, {"m", "of one", 0.01, 100});
  f.add("trunks.gap", o.gap, {"m", "between neighbouring beams on one", 0.001, 10});
  f.add("trunks.clearance", o.clearance, {"m", "everything beside it is farther by this", 0, 100});
  f.add("trunks.lone", o.lone, {"m", "within which nothing else is seen", 0, 100});
  f.add("trunks.least_beams", o.least_beams, {"1", "that see it", 1, 1000});
  f.add("trunks.spot", o.spot, {"rad", "by which the beam's width makes it wider", 0, 0.1});
  f.add("trunks.range_sigma", o.range_sigma, {"m", "of the range to the bark", 0.001, 10});
  f.add("trunks.bearing_sigma", o.bearing_sigma, {"1", "of an angle step", 0.001, 100});
}

}  // namespace majak::beacon
