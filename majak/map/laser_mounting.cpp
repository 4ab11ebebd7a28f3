// SPDX-License-Identifier: Apache-2.0
#include "majak/map/laser_mounting.hpp"

#include <algorithm>

#include "majak/core/error.hpp"

namespace majak::map {

LaserMounting looking(const std::string& where, LaserMounting mounting) {
  struct Turn {
    const char* name;
    double roll, pitch, yaw;  // degrees
  };
  constexpr Turn kTurns[] = {{"up", 0, -90, 0},
                             {"left", 90, 0, 90},
                             {"right", 90, 0, -90},
                             {"down", 0, 20, 0},
                             {"level", 0, 0, 0}};
  for (const Turn& turn : kTurns) {
    if (where != turn.name) continue;
    mounting.roll = radians(turn.roll), mounting.pitch = radians(turn.pitch);
    mounting.yaw = radians(turn.yaw);
    return mounting;
  }
  throw Error("a laser looks up, left, right, down or level, not " + where);
}

TiltTrack::TiltTrack(std::vector<std::pair<Time, double>> samples) : samples_(std::move(samples)) {
  const auto earlier = [](const auto& a, const auto& b) { return a.first < b.first; };
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  std::stable_sort(samples_.begin(), samples_.end(), earlier);
  samples_.erase(std::unique(samples_.begin(), samples_.end(), same), samples_.end());
}

double TiltTrack::at(Time time) const {
  if (samples_.empty()) return 0;
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), time,
                                      [](const auto& s, Time t) { return s.first < t; });
  if (after == samples_.begin()) return after->second;
  if (after == samples_.end()) return samples_.back().second;
  const auto before = std::prev(after);
  const double share = to_seconds(time - before->first) / to_seconds(after->first - before->first);
  return before->second + share * (after->second - before->second);
}

}  // namespace majak::map
