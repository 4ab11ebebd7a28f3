// SPDX-License-Identifier: Apache-2.0
// How well a scan fits a pose on a known map: what its beams cost by the likelihood field, how many
// end at a wall, and how many would have passed through one, which no person before the laser
// explains.
#pragma once

#include "majak/core/pose2.hpp"
#include "majak/localize/place.hpp"
#include "majak/match/beams.hpp"

namespace majak::localize {

struct PoseFitOptions {
  double through_wall = 2;  ///< nat, against a beam that would have passed through a wall
  double wall = 0.4;        ///< m, by which it must be beyond
  double at_wall = 0.1;     ///< m, off a wall, or one and a half cells: a return that is explained
};

struct PoseFit {
  double cost = 0;     ///< nat, of a beam in the mean; 0 is perfect
  double at_wall = 1;  ///< share of returns that end at a wall
  double through = 0;  ///< share of returns from beyond walls

  /// 0: all is as the map says. People before the laser cost half of what walls do that are not
  /// there.
  double misfit() const { return 0.5 * (1 - at_wall) + through; }
};

/// A scan without returns fits everywhere.
PoseFit pose_fit(const Place& place, const match::Beams& beams, const Pose2& T_map_robot,
                 const PoseFitOptions& options = {});

}  // namespace majak::localize
