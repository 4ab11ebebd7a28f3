// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "majak/core/site.hpp"

namespace majak::map {

/// Where the robot of a site was at any time: at its scans where they say, between two of them on
/// the arc from one to the other.
class Trajectory {
 public:
  /// Lost scans and poses that are not finite are left out; of equal stamps the first counts.
  explicit Trajectory(const Site& site, Duration max_gap = kSecond);

  /// T_map_robot; nothing before the first scan, after the last one, and where its neighbours are
  /// more than max_gap apart.
  std::optional<Pose2> at(Time time) const;

 private:
  struct Stop {
    Time time;
    Pose2 T_map_robot;
  };
  std::vector<Stop> stops_;
  Duration max_gap_;
};

}  // namespace majak::map
