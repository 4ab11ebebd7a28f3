// SPDX-License-Identifier: Apache-2.0
// Landmarks: things in a scan that can be told from others and found again.
#pragma once

#include <cstddef>

#include "majak/core/pose2.hpp"

namespace majak::beacon {

/// A landmark as one scan shows it, in the laser's frame.
struct LandmarkSighting {
  double range = 0;                           ///< m, to its centre
  double bearing = 0;                         ///< rad, counter-clockwise from ahead
  double range_sigma = 0, bearing_sigma = 0;  ///< m, rad
  double diameter = 0, diameter_sigma = 0;    ///< m; of trunks
  double depth = 0;      ///< of a diameter: range is that of what was seen and this much more
  std::size_t beam = 0;  ///< in its middle: tells when it was seen

  Vec2 p_laser() const { return {range * std::cos(bearing), range * std::sin(bearing)}; }
};

}  // namespace majak::beacon
