// SPDX-License-Identifier: Apache-2.0
// Reflectors as beacons: found in a scan by their brightness, told apart by where they stand.
//
//   for (const BeaconSighting& s : beacon::sightings(scan, map, prior)) filter.add(s);
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "majak/beacon/beacon_map.hpp"
#include "majak/core/event.hpp"

namespace majak::beacon {

/// Where the robot is believed to be.
struct PosePrior {
  Pose2 T_map_robot;
  Mat3 covariance = Mat3::Zero();  ///< of (x, y, theta) in the map's axes
};

struct ReflectorOptions {
  double threshold = 0;       ///< raw units of Scan::intensities; 0: from the scan itself
  double contrast = 4;        ///< times as bright as others at that range, if from the scan itself
  double diameter = 0.1;      ///< m, of a round reflector; 0: a flat one
  double largest_gap = 0.3;   ///< m between neighbouring beams of one bright thing
  double range_sigma = 0.02;  ///< m, of the range to the centre
  double bearing_sigma = 0.25;  ///< of an angle step, of the bearing of the centre
  double aside_sigma = 0.01;    ///< m, of the centre across the beam: motion between two beams
  double gate = 13.8;           ///< squared Mahalanobis distance, 2 dof; 99.9 %
  double same_distance =
      0.15;  ///< m, by which a distance of two reflectors may differ from the map
};

/// Reflectors in the scan: range and bearing of each one's centre, number -1, in the scan's order.
/// None where the scan has no intensities.
std::vector<BeaconSighting> find_reflectors(const Scan& scan, const ReflectorOptions& options = {});

/// Gives sightings (with range and bearing) the numbers of the map. With a prior: the nearest
/// within the gate, one to one. Without: by the distances between reflectors, the pose that
/// explains the most of them; nothing if fewer than three agree or two poses explain as many.
/// Sightings without a number are left out.
std::vector<BeaconSighting> associate(std::span<const BeaconSighting> found, const BeaconMap& map,
                                      const std::optional<PosePrior>& prior,
                                      const ReflectorOptions& options = {});

/// Both: the beacons of the map that the scan shows, each with its number.
std::vector<BeaconSighting> sightings(const Scan& scan, const BeaconMap& map,
                                      const std::optional<PosePrior>& prior = {},
                                      const ReflectorOptions& options = {});

}  // namespace majak::beacon
