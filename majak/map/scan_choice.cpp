// SPDX-License-Identifier: Apache-2.0
#include "majak/map/scan_choice.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/map/drawable.hpp"

namespace majak::map {

std::vector<std::size_t> scans_to_draw(const Site& site, const ScanChoice& choice) {
  struct Last {
    int laser;
    Pose2 pose;
    Time time;
  };
  std::vector<std::size_t> chosen;
  std::vector<Last> last;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const PosedScan& posed = site.scans[i];
    if (!drawable(posed, choice.resolution, choice.max_range)) continue;
    const Last now{posed.scan.laser, posed.estimate.T_map_robot, posed.scan.time};
    const auto same =
        std::find_if(last.begin(), last.end(), [&](const Last& l) { return l.laser == now.laser; });
    if (same == last.end()) {
      last.push_back(now);
    } else {
      const double moved = (now.pose.translation() - same->pose.translation()).norm();
      const double turned = std::abs(angle_diff(now.pose.theta, same->pose.theta));
      if (moved < choice.spacing && turned < choice.turn &&
          to_seconds(now.time - same->time) < choice.interval)
        continue;
      *same = now;
    }
    chosen.push_back(i);
  }
  return chosen;
}

}  // namespace majak::map
