// SPDX-License-Identifier: Apache-2.0
// Joint compatibility: which landmark is which, decided for all sightings of a scan together: a
// pairing that each alone would allow is refused where it contradicts the others (Neira and Tardos
// 2001, JCBB).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/pose2.hpp"

namespace majak::slam {

/// A sighting that may be of a landmark.
struct Pairing {
  int landmark = -1;
  Vec2 innovation = Vec2::Zero();  ///< measured less expected, m, robot frame
  /// Of the expectation, by x, y, theta and the landmark's x, y.
  Eigen::Matrix<double, 2, 5> by_state = Eigen::Matrix<double, 2, 5>::Zero();
  int column = 0;                                    ///< of the landmark in the covariance
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();  ///< of the innovation
  double nis = 0;
};

struct JointCompatibilityOptions {
  double gate = 0.99;     ///< probability with which true pairings pass, each and together
  int most_nodes = 3000;  ///< of the search; then the best so far counts
};

void describe(OptionFields& fields, JointCompatibilityOptions& options);

/// candidates[s]: the pairings that sighting s alone allows, likeliest first. Returns one index
/// into each list, -1 for none; no landmark twice. As many as are jointly compatible, and of these
/// the nearest. In whatever order the sightings come: those with the fewest candidates are paired
/// first, each with those before. `covariance`: of the state, x, y, theta first.
std::vector<int> associate_jointly(const std::vector<std::vector<Pairing>>& candidates,
                                   const Eigen::MatrixXd& covariance,
                                   const JointCompatibilityOptions& options = {});

/// Covariance of two pairings' innovations, H_a P H_b'.
Eigen::Matrix2d shared_spread(const Pairing& a, const Pairing& b,
                              const Eigen::MatrixXd& covariance);

}  // namespace majak::slam
