// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/doors.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/random.hpp"
#include "majak/sim/streams.hpp"

namespace majak::sim {
namespace {

constexpr double kOnTheWay = 0.35;  // m; a path that near leads through
constexpr double kInTheWay = 0.5;   // m; an open leaf that near would be hit

Segment turned(const Segment& closed, double angle) {
  const Vec2 arm = closed.b - closed.a;
  const double c = std::cos(angle), s = std::sin(angle);
  return {closed.a, closed.a + Vec2(c * arm.x() - s * arm.y(), s * arm.x() + c * arm.y()),
          closed.reflectivity};
}

bool keeps_off(const Path& path, const Segment& leaf, double distance) {
  return std::none_of(path.points.begin(), path.points.end(),
                      [&](const Vec2& p) { return distance_to(leaf, p) < distance; });
}

}  // namespace

bool Door::open_at(Duration time) const {
  const auto passed = std::upper_bound(changes.begin(), changes.end(), time) - changes.begin();
  return open_at_first != (passed % 2 == 1);
}

double Door::opening(Duration time) const {
  const auto next = std::upper_bound(changes.begin(), changes.end(), time);
  const double now = open_at(time) ? 1 : 0;
  if (next == changes.begin() || time - *(next - 1) >= kMoves) return now;
  const double moved = static_cast<double>(time - *(next - 1)) / static_cast<double>(kMoves);
  return (1 - moved) * (1 - now) + moved * now;
}

std::vector<Door> draw_doors(const Scene& scene, const Path& path, double period, Duration run,
                             std::uint64_t seed) {
  std::vector<Door> doors;
  for (std::size_t i = 0; i < scene.doorways.size(); ++i) {
    RandomStream random(seed, kDoorRun, i);
    Door door;
    door.closed = scene.doorways[i];
    if (random.uniform() < 0.5) std::swap(door.closed.a, door.closed.b);
    door.open_at_first = random.uniform() < 0.5;
    if (!keeps_off(path, door.closed, kOnTheWay)) continue;
    if (random.uniform() < 0.5) door.swing = -door.swing;
    if (!keeps_off(path, turned(door.closed, door.swing), kInTheWay)) door.swing = -door.swing;
    door.slides = !keeps_off(path, turned(door.closed, door.swing), kInTheWay);
    for (Duration t = 0;;) {
      t += std::max(2 * Door::kMoves, from_seconds(-period * std::log1p(-random.uniform())));
      if (t >= run) break;
      door.changes.push_back(t);
    }
    doors.push_back(std::move(door));
  }
  return doors;
}

std::vector<Segment> leaves(const std::vector<Door>& doors, Duration time) {
  std::vector<Segment> seen;
  for (const Door& door : doors) {
    const double opening = door.opening(time);
    if (!door.slides) {
      seen.push_back(turned(door.closed, door.swing * opening));
    } else if (opening < 1) {
      const Segment& c = door.closed;
      seen.push_back({c.a, c.b + opening * (c.a - c.b), c.reflectivity});
    }
  }
  return seen;
}

}  // namespace majak::sim
