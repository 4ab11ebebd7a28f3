// SPDX-License-Identifier: Apache-2.0
// What benchmarks of EKF-SLAM show: does it know its errors, and what does a step cost.
#pragma once

#include <string>
#include <vector>

#include "majak/draw/figure.hpp"

namespace majak::draw {

/// Of many runs, at the same times of each.
struct NeesPicture {
  std::string title;
  std::vector<double> seconds;
  std::vector<double> ekf, graph;              ///< mean NEES of the pose, 3 expected
  double band_low = 0, band_high = 0;          ///< of that mean, were the covariances right
  std::vector<double> ekf_place, graph_place;  ///< m, root of the mean square
};

/// NEES above, errors of the place below.
Figure nees_picture(const NeesPicture& picture);

struct StepTimes {
  std::string name;
  std::vector<Point> median, mean;  ///< landmarks on the map; ms of a scan
};

/// What a scan costs against the size of the map, a panel each.
Figure step_time_picture(const std::vector<StepTimes>& runs);

}  // namespace majak::draw
