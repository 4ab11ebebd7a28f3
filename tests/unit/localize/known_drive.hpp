// SPDX-License-Identifier: Apache-2.0
// A drive through the simulated building and its map: what methods on a known map are tested with.
#pragma once

#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "majak/localize/place.hpp"
#include "majak/localize/scan_feed.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/known_map.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::localize {

/// A drive through the building: the scans as they are fed, and where the robot was.
struct Drive {
  PlacePtr place;
  std::vector<FedScan> scans;
  std::vector<Pose2> truth;
};

inline const Drive& drive() {
  static const Drive drive = [] {
    const sim::World world(sim::building());
    const sim::Path path = sim::plan_tour(world, {.short_tour = true});
    Drive d{place_of(sim::known_map(world)), {}, {}};
    ScanFeed feed;
    const auto take = [&] {
      while (auto scan = feed.next()) d.scans.push_back(std::move(*scan));
    };
    for (const Event& event : sim::simulate(world, path, {})) {
      if (const auto* truth = std::get_if<Truth>(&event)) d.truth.push_back(truth->T_world_robot);
      feed.add(event), take();
    }
    feed.end(), take();
    return d;
  }();
  return drive;
}

inline bool right(const Pose2& estimate, const Pose2& truth) {
  const Pose2 off = between(truth, estimate);
  return off.translation().norm() < 0.5 && std::abs(off.theta) < radians(10);
}

inline FedScan without_motion(FedScan scan) {
  scan.T_previous_robot = {};
  scan.covariance.setZero();
  return scan;
}

}  // namespace majak::localize
