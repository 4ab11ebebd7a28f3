// SPDX-License-Identifier: Apache-2.0
#include "majak/map/trajectory.hpp"

#include <algorithm>

namespace majak::map {

Trajectory::Trajectory(const Site& site, Duration max_gap) : max_gap_(max_gap) {
  for (const PosedScan& posed : site.scans)
    if (posed.estimate.health != Health::lost && posed.estimate.T_map_robot.finite())
      stops_.push_back({posed.scan.time, posed.estimate.T_map_robot});
  std::stable_sort(stops_.begin(), stops_.end(),
                   [](const Stop& a, const Stop& b) { return a.time < b.time; });
  const auto last = std::unique(stops_.begin(), stops_.end(),
                                [](const Stop& a, const Stop& b) { return a.time == b.time; });
  stops_.erase(last, stops_.end());
}

std::optional<Pose2> Trajectory::at(Time time) const {
  const auto after = std::lower_bound(stops_.begin(), stops_.end(), time,
                                      [](const Stop& s, Time t) { return s.time < t; });
  if (after == stops_.end()) return std::nullopt;
  if (after->time == time) return after->T_map_robot;
  if (after == stops_.begin()) return std::nullopt;
  const Stop& before = *std::prev(after);
  const Duration gap = after->time - before.time;
  if (gap > max_gap_) return std::nullopt;
  return interpolate(before.T_map_robot, after->T_map_robot,
                     to_seconds(time - before.time) / to_seconds(gap));
}

}  // namespace majak::map
