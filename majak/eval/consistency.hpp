// SPDX-License-Identifier: Apache-2.0
// Are the covariances honest? The normalized estimation error squared (NEES) of n independent
// estimates with d degrees of freedom each is chi-square distributed with n d of them
// (Bar-Shalom, Li, Kirubarajan 2001, section 5.4.2).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "majak/core/chi_square.hpp"
#include "majak/core/estimate.hpp"
#include "majak/eval/trajectory.hpp"

namespace majak::eval {

using majak::chi_square_cdf;
using majak::chi_square_quantile;

/// e' P^-1 e of one pose, e in the map's axes as the covariance is; nullopt if P is not positive
/// definite (the pose that fixes the map, say).
std::optional<double> nees(const Pose2& T_map_robot, const Mat3& covariance,
                           const Pose2& T_map_truth);

struct NeesSummary {
  std::size_t count = 0;
  double mean = 0;      ///< of the NEES; its expectation is the degrees of freedom
  double band_low = 0;  ///< two-sided band of that mean, were the samples independent
  double band_high = 0;
  double inside_share = 0;  ///< samples within their own ellipse of that confidence
  bool inside_band() const { return count > 0 && mean >= band_low && mean <= band_high; }
};

/// Of independent samples with `dof` each. The poses of one run are not independent: take one pose
/// of each of many runs for the band; for one run only inside_share says something.
NeesSummary summarize_nees(const std::vector<double>& samples, double dof = 3,
                           double confidence = 0.95);

/// NEES of each estimate that has truth and a proper covariance. The map's frame is fixed by its
/// first pose, so the truth is moved there by the first pair.
std::vector<double> nees_of_run(const std::vector<Estimate>& estimates, const Trajectory& truth);

}  // namespace majak::eval
