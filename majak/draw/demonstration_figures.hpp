// SPDX-License-Identifier: Apache-2.0
// The demonstration as pictures: what was driven and seen, and how wrong it was over time and over
// range.
#pragma once

#include "majak/draw/figure.hpp"
#include "majak/eval/demonstration.hpp"

namespace majak::draw {

/// Path and trunks with all that the log has, the whole and the part that was passed most often;
/// below, the errors over time and range. The picture to look at first.
Figure demonstration_picture(const eval::Demonstration& demonstration);

/// One panel a kind of run: EKF-SLAM as known at each time, the graph as known at last.
Figure errors_over_time(const eval::Demonstration& demonstration);
/// Of the trunks' sightings: along the beam and across it, and what of the latter is the heading's.
Figure errors_over_range(const eval::Demonstration& demonstration);
/// NIS of the landmarks by degree of freedom and minute; 1 is honest. With truth also the pose's
/// NEES by degree of freedom.
Figure consistency_over_time(const eval::Demonstration& demonstration);
/// Time of each scan in EKF-SLAM over the size of its map.
Figure time_over_size(const eval::Demonstration& demonstration);

}  // namespace majak::draw
