// SPDX-License-Identifier: Apache-2.0
#include "majak/map/scan_choice.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/map/drawable.hpp"

namespace majak::map {
std::vector<std::size_t> scans_to_draw(const Site& site, const ScanChoice& choice) {
  std::vector<std::size_t> chosen;
  std::vector<std::pair<int, Pose2>> last;  // by laser
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const PosedScan& posed = site.scans[i];
    if (!drawable(posed, choice.resolution, choice.max_range)) continue;
    const Pose2& pose = posed.estimate.T_map_robot;
    const auto same = std::find_if(last.begin(), last.end(),
                                   [&](const auto& l) { return l.first == posed.scan.laser; });
    if (same != last.end()) {
      const double moved = (pose.translation() - same->second.translation()).norm();
      const double turned = std::abs(angle_diff(pose.theta, same->second.theta));
      if (moved < choice.spacing && turned < choice.turn) continue;
      same->second = pose;
    } else {
      last.emplace_back(posed.scan.laser, pose);
    }
    chosen.push_back(i);
  }
  return chosen;
}

}  // namespace majak::map
