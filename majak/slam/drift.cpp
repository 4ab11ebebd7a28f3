// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/drift.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace majak::slam {

Drift drift_to(const KeyScan& key, const DriftOptions& options) {
  const Mat3 by_match = (options.match_share * key.match_information.inverse()).inverse();
  Drift drift;
  drift.covariance = (by_match + key.motion_information).inverse();
  drift.covariance = (0.5 * (drift.covariance + drift.covariance.transpose())).eval();
  drift.by_motion = drift.covariance * key.motion_information;
  if (key.weak_step) {
    const Vec3 sigma(options.weak_way, options.weak_way, options.weak_turn);
    drift.covariance.diagonal() += sigma.cwiseAbs2();
  }
  return drift;
}

std::vector<Pose2> share_out(std::span<const Pose2> chain, std::span<const Mat3> covariances,
                             const Pose2& end) {
  std::vector<Mat3> gathered(1, Mat3::Zero());  // in the axes of the last pose (MATH 24.3)
  for (std::size_t k = 1; k < chain.size(); ++k) {
    const Mat3 a = adjoint(between(chain.back(), chain[k]));
    gathered.push_back(gathered.back() + a * covariances[k] * a.transpose());
  }
  const Vec3 whole = log(between(chain.back(), end));
  const Vec3 a_unit = gathered.back().ldlt().solve(whole);
  std::vector<Pose2> moved;
  for (std::size_t k = 0; k < chain.size(); ++k)
    moved.push_back(chain.back() * exp(gathered[k] * a_unit) * between(chain.back(), chain[k]));
  moved.back() = end;
  return moved;
}

}  // namespace majak::slam
