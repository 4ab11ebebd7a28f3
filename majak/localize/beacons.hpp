// SPDX-License-Identifier: Apache-2.0
// Beacons alone (thesis p. 19): every moment's sightings give a pose of their own; no wheels, no
// map but that of the beacons, no start. Nothing is carried over but which beacon is which.
//
// Needs BeaconSighting with numbers, or scans whose intensities show reflectors. Yields an estimate
// for each moment with enough of them; moments without are counted.
#pragma once

#include "majak/beacon/beacon_map.hpp"
#include "majak/beacon/fix.hpp"
#include "majak/beacon/reflectors.hpp"
#include "majak/localize/localizer.hpp"

namespace majak::localize {

struct BeaconsOptions {
  beacon::ReflectorOptions reflectors;
  beacon::FixOptions fix;
  double speed = 1.5;      ///< m/s, sigma of what the robot may do between two fixes
  double turn_rate = 1.0;  ///< rad/s, the same
  double memory = 2;       ///< s after a fix in which it still tells reflectors apart
};

Localizer beacons(const beacon::BeaconMap& map, const BeaconsOptions& options = {});

}  // namespace majak::localize
