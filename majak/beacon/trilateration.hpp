// SPDX-License-Identifier: Apache-2.0
// Trilateration: where one stands, from distances to beacons of known places. docs/MATH.md
// "Beacons".
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>

#include "majak/beacon/fix.hpp"

namespace majak::beacon {

struct Circle {
  Vec2 centre = Vec2::Zero();
  double radius = 0;  ///< m
};

struct Intersection {
  int count = 0;                 ///< 0, 1 (they touch) or 2
  std::array<Vec2, 2> points{};  ///< the first lies to the left of the way from a to b
  bool same = false;             ///< one circle twice: every point of it
};

/// Where two circles meet. They touch where the gap between them, or their overlap, is at most
/// `tolerance` (m); the point then lies on the line of centres, in the middle of the gap.
Intersection intersect(const Circle& a, const Circle& b, double tolerance = 1e-9);

/// A distance to a beacon.
struct RangeTo {
  Vec2 p_map = Vec2::Zero();
  double range = 0;  ///< m
  double sigma = 1;  ///< m
};

struct Trilateration {
  FixProblem problem = FixProblem::too_few;
  Vec2 p_map = Vec2::Zero();
  Mat2 covariance = Mat2::Zero();  ///< m^2
  /// The other place that explains the ranges as well; kept also where the prior has decided.
  std::optional<Vec2> mirror{};
  double chi2 = 0;  ///< sum of squared residuals in sigmas; passes_residual_test()
  int dof = 0;
  double hdop = std::numeric_limits<double>::infinity();  ///< m of position a m of range
  double nonlinearity = 0;  ///< sigmas, of the residuals within two sigmas; see FixOptions
  Mask used = 0;            ///< the others are gross errors
  int iterations = 0;
};

/// Two ranges give two places (one if they touch), and `prior` decides which. Three and more:
/// closed form, then least squares; gross errors are left out by consensus where there are four and
/// more. Throws Error for more than kMostMeasurements; everything else is told in `problem`.
Trilateration trilaterate(std::span<const RangeTo> ranges, const std::optional<Vec2>& prior = {},
                          const FixOptions& options = {});

}  // namespace majak::beacon
