// SPDX-License-Identifier: Apache-2.0
// Pseudoranges: distances that are all too long by the same unknown amount, because the receiver's
// clock is not the beacons'. In the plane and in space. docs/MATH.md "Beacons".
#pragma once

#include <limits>
#include <optional>
#include <span>

#include "majak/beacon/fix.hpp"

namespace majak::beacon {

/// |p - beacon| + bias = range.
template <int D>
struct PseudorangeTo {
  Eigen::Matrix<double, D, 1> p_map = Eigen::Matrix<double, D, 1>::Zero();
  double range = 0;  ///< m, of any sign
  double sigma = 1;  ///< m
};

/// Dilution of precision: m of error a m of pseudorange error, by the geometry alone.
struct Dilution {
  double gdop = std::numeric_limits<double>::infinity();  ///< everything, the clock as m
  double pdop = gdop;                                     ///< position
  double hdop = gdop;                                     ///< its x and y
  double vdop = gdop;                                     ///< its z; infinite in the plane
  double tdop = gdop;                                     ///< clock
};

template <int D>
struct PseudorangeFix {
  FixProblem problem = FixProblem::too_few;
  Eigen::Matrix<double, D, 1> p_map = Eigen::Matrix<double, D, 1>::Zero();
  double bias = 0;  ///< m; over the signal's speed: s
  /// Of (position, bias), m^2.
  Eigen::Matrix<double, D + 1, D + 1> covariance = Eigen::Matrix<double, D + 1, D + 1>::Zero();
  /// The other place that explains the pseudoranges as well.
  std::optional<Eigen::Matrix<double, D, 1>> mirror{};
  double chi2 = 0;
  int dof = 0;
  Dilution dilution{};
  double nonlinearity = 0;  ///< sigmas, of the residuals within two sigmas; see FixOptions
  Mask used = 0;
  int iterations = 0;
};

/// D is 2 (three pseudoranges and more) or 3 (four and more). Closed form, then least squares;
/// gross errors are left out by consensus where there are two more than needed. Of two places that
/// explain all, the one nearer to the prior. Throws Error for more than kMostMeasurements;
/// everything else is told in `problem`.
template <int D>
PseudorangeFix<D> locate(std::span<const PseudorangeTo<D>> ranges,
                         const std::optional<Eigen::Matrix<double, D, 1>>& prior = {},
                         const FixOptions& options = {});

extern template PseudorangeFix<2> locate<2>(std::span<const PseudorangeTo<2>>,
                                            const std::optional<Vec2>&, const FixOptions&);
extern template PseudorangeFix<3> locate<3>(std::span<const PseudorangeTo<3>>,
                                            const std::optional<Vec3>&, const FixOptions&);

}  // namespace majak::beacon
