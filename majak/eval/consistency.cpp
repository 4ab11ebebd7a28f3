// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/consistency.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace majak::eval {

std::optional<double> nees(const Pose2& T_map_robot, const Mat3& covariance,
                           const Pose2& T_map_truth) {
  const Eigen::LLT<Mat3> llt(covariance);
  if (llt.info() != Eigen::Success || !(llt.matrixLLT().diagonal().minCoeff() > 1e-9)) {
    return std::nullopt;
  }
  const Vec3 error{T_map_robot.x - T_map_truth.x, T_map_robot.y - T_map_truth.y,
                   angle_diff(T_map_robot.theta, T_map_truth.theta)};
  const double value = error.dot(llt.solve(error));
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

NeesSummary summarize_nees(const std::vector<double>& samples, double dof, double confidence) {
  NeesSummary summary;
  summary.count = samples.size();
  if (samples.empty()) return summary;
  const double n = static_cast<double>(samples.size());
  const double tail = (1 - confidence) / 2;
  const double ellipse = chi_square_quantile(confidence, dof);
  double inside = 0;
  for (const double s : samples) {
    summary.mean += s / n;
    inside += s <= ellipse ? 1 : 0;
  }
  summary.inside_share = inside / n;
  summary.band_low = chi_square_quantile(tail, n * dof) / n;
  summary.band_high = chi_square_quantile(1 - tail, n * dof) / n;
  return summary;
}

std::vector<double> nees_of_run(const std::vector<Estimate>& estimates, const Trajectory& truth) {
  const TrajectoryIndex index(truth);
  std::optional<Pose2> T_map_world;
  std::vector<double> samples;
  for (const Estimate& e : estimates) {
    const auto true_pose = index.at(e.time);
    if (!true_pose) continue;
    if (!T_map_world) T_map_world = e.T_map_robot * true_pose->pose.inverse();
    if (const auto value = nees(e.T_map_robot, e.covariance, *T_map_world * true_pose->pose)) {
      samples.push_back(*value);
    }
  }
  return samples;
}

}  // namespace majak::eval
