// SPDX-License-Identifier: Apache-2.0
// What the fixes of this folder have in common: the measurements that count, what can go wrong,
// and when a measurement is a gross error.
#pragma once

#include <cstdint>
#include <optional>

#include "majak/core/chi_square.hpp"
#include "majak/core/pose2.hpp"

namespace majak::beacon {

using Mat2 = Eigen::Matrix2d;

/// Measurements of one fix: bit i stands for the i-th of them.
using Mask = std::uint64_t;
inline constexpr int kMostMeasurements = 64;

enum class FixProblem : std::uint8_t {
  none,
  too_few,          ///< fewer measurements than unknowns
  bad_value,        ///< a number that is not finite, a negative range, a sigma that is not positive
  identical,        ///< the beacons stand in one place
  ambiguous,        ///< two places explain the measurements alike (beacons in one line, two ranges)
  ill_conditioned,  ///< the covariance does not hold: near the danger circle, or too far off
  inconsistent,     ///< no place explains enough of the measurements
};
/// One line for people, without a full stop.
const char* describe(FixProblem problem);

struct FixOptions {
  double gate = 3.3;       ///< sigmas; beyond it a measurement is a gross error
  int most_sets = 300;     ///< minimal sets tried where there are gross errors
  double nonlinear = 0.4;  ///< sigmas that the residuals may bend within two sigmas of position
};

/// Is the sum of squared residuals one that noise makes in all but 1 of 1000 cases?
inline bool passes_residual_test(double chi2, int dof) {
  return dof == 0 || chi_square_cdf(chi2, dof) < 0.999;
}

}  // namespace majak::beacon
