// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/reflectors.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace majak::beacon {
namespace {

constexpr double kSlack = 0.05;     // m
constexpr double kSpread = 0.012;   // rad, of a laser's beam
constexpr std::size_t kAlike = 30;  // beams to each side, by range, that a beam is compared with

/// The beams with a return and an intensity.
std::vector<std::size_t> lit_beams(const Scan& scan) {
  std::vector<std::size_t> beams;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (std::isfinite(scan.ranges[i]) && std::isfinite(scan.intensities[i])) beams.push_back(i);
  }
  return beams;
}

/// What is bright: as the option says, or many times as bright as three quarters of the others at
/// about that range (a wall seen head-on is bright among walls seen at a grazing angle).
/// Range by range, because an echo weakens with it by a law that differs from device to device.
std::vector<bool> bright_beams(const Scan& scan, const ReflectorOptions& o) {
  std::vector<bool> bright(scan.ranges.size(), false);
  std::vector<std::size_t> order = lit_beams(scan);
  if (o.threshold > 0) {
    for (const std::size_t i : order) bright[i] = scan.intensities[i] > o.threshold;
    return bright;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return scan.ranges[a] < scan.ranges[b]; });
  std::vector<float> alike;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t window = std::min(2 * kAlike + 1, order.size());
    const std::size_t from = std::min(k > kAlike ? k - kAlike : 0, order.size() - window);
    const std::size_t to = from + window;
    alike.clear();
    for (std::size_t j = from; j < to; ++j) alike.push_back(scan.intensities[order[j]]);
    const auto most_of_them = alike.begin() + static_cast<std::ptrdiff_t>(3 * alike.size() / 4);
    std::nth_element(alike.begin(), most_of_them, alike.end());
    bright[order[k]] = scan.intensities[order[k]] > o.contrast * std::max(*most_of_them, 0.0F);
  }
  return bright;
}

Vec2 point(const Scan& scan, std::size_t beam) {
  const double angle = scan.angle(beam), range = scan.ranges[beam];
  return {range * std::cos(angle), range * std::sin(angle)};
}

/// The centre of a reflector that beams first ... last see. Each beam gives the distance of the
/// centre by the law of cosines: R^2 = r^2 + d^2 - 2 r d cos(offset) (MATH 7.11).
BeaconSighting centre_of(const Scan& scan, std::size_t first, std::size_t last,
                         const ReflectorOptions& o) {
  const double radius = o.diameter / 2;
  const double bearing = 0.5 * (scan.angle(first) + scan.angle(last));
  double sum = 0;
  for (std::size_t i = first; i <= last; ++i) {
    const double r = scan.ranges[i], offset = angle_diff(scan.angle(i), bearing);
    const double aside = r * std::sin(offset);
    sum += r * std::cos(offset) + std::sqrt(std::max(0.0, radius * radius - aside * aside));
  }
  BeaconSighting s;
  s.time = scan.time;
  s.range = sum / static_cast<double>(last - first + 1);
  s.bearing = wrap_angle(bearing);
  s.range_sigma = o.range_sigma;
  s.bearing_sigma = std::hypot(o.bearing_sigma * scan.angle_step, o.aside_sigma / *s.range);
  s.T_robot_sensor = scan.T_robot_laser;
  return s;
}

}  // namespace

std::vector<BeaconSighting> find_reflectors(const Scan& scan, const ReflectorOptions& o) {
  std::vector<BeaconSighting> found;
  if (scan.intensities.size() != scan.ranges.size()) return found;
  const std::vector<bool> bright = bright_beams(scan, o);
  for (std::size_t first = 0; first < bright.size(); ++first) {
    if (!bright[first]) continue;
    std::size_t last = first;
    while (last + 1 < bright.size() && bright[last + 1] &&
           (point(scan, last + 1) - point(scan, last)).norm() <= o.largest_gap) {
      ++last;
    }
    // What is wider than a reflector is something else that shines; what the scan ends in may be.
    const double width = (point(scan, last) - point(scan, first)).norm();
    const double most = o.diameter + kSlack + scan.ranges[first] * (kSpread + 2 * scan.angle_step);
    const bool whole = first > 0 && last + 1 < bright.size();
    if (whole && width <= most) found.push_back(centre_of(scan, first, last, o));
    first = last;
  }
  return found;
}

std::vector<BeaconSighting> sightings(const Scan& scan, const BeaconMap& map,
                                      const std::optional<PosePrior>& prior,
                                      const ReflectorOptions& o) {
  return associate(find_reflectors(scan, o), map, prior, o);
}

}  // namespace majak::beacon
