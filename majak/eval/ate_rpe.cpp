// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/ate_rpe.hpp"

#include <cmath>

namespace majak::eval {
namespace {

struct ErrorLists {
  std::vector<double> translation, rotation;
  void add(const Pose2& error) {
    translation.push_back(std::hypot(error.x, error.y));
    rotation.push_back(std::abs(error.theta));
  }
};

Pose2 alignment_of(const std::vector<PosePair>& pairs, Alignment alignment) {
  if (pairs.empty() || alignment == Alignment::none) return {};
  if (alignment == Alignment::best) return align(pairs);
  return pairs.front().T_reference_robot * pairs.front().T_map_robot.inverse();
}

/// Distance travelled along the reference up to each pair, m.
std::vector<double> travelled(const std::vector<PosePair>& pairs) {
  std::vector<double> length(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const Pose2& a = pairs[i - 1].T_reference_robot;
    const Pose2& b = pairs[i].T_reference_robot;
    length[i] = length[i - 1] + std::hypot(b.x - a.x, b.y - a.y);
  }
  return length;
}

}  // namespace

Pose2 align(const std::vector<PosePair>& pairs) {
  if (pairs.empty()) return {};
  const double n = static_cast<double>(pairs.size());
  Vec2 mean_map = Vec2::Zero(), mean_reference = Vec2::Zero();
  for (const PosePair& p : pairs) {
    mean_map += p.T_map_robot.translation() / n;
    mean_reference += p.T_reference_robot.translation() / n;
  }
  double dot = 0, cross = 0;
  for (const PosePair& p : pairs) {
    const Vec2 a = p.T_map_robot.translation() - mean_map;
    const Vec2 b = p.T_reference_robot.translation() - mean_reference;
    dot += a.dot(b);
    cross += a.x() * b.y() - a.y() * b.x();
  }
  // Positions in one point say nothing of the turn: the first pair's headings do.
  const double first_turn =
      angle_diff(pairs.front().T_reference_robot.theta, pairs.front().T_map_robot.theta);
  const double turn = std::hypot(dot, cross) > 1e-12 ? std::atan2(cross, dot) : first_turn;
  const Vec2 moved = Pose2{0, 0, turn} * mean_map;
  return {mean_reference.x() - moved.x(), mean_reference.y() - moved.y(), wrap_angle(turn)};
}

AbsoluteError absolute_error(const std::vector<PosePair>& pairs, Alignment alignment) {
  AbsoluteError result;
  result.T_reference_map = alignment_of(pairs, alignment);
  ErrorLists errors;
  for (const PosePair& p : pairs) {
    result.residuals.push_back(
        between(p.T_reference_robot, result.T_reference_map * p.T_map_robot));
    errors.add(result.residuals.back());
  }
  result.translation = error_stats(std::move(errors.translation));
  result.rotation = error_stats(std::move(errors.rotation));
  return result;
}

std::vector<RelativeError> relative_errors(const std::vector<PosePair>& pairs,
                                           const std::vector<double>& distances) {
  const std::vector<double> length = travelled(pairs);
  std::vector<RelativeError> result;
  for (const double distance : distances) {
    ErrorLists errors;
    std::size_t j = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      while (j < pairs.size() && length[j] - length[i] < distance) ++j;
      if (j == pairs.size()) break;
      const Pose2 reference = between(pairs[i].T_reference_robot, pairs[j].T_reference_robot);
      errors.add(between(reference, between(pairs[i].T_map_robot, pairs[j].T_map_robot)));
    }
    if (errors.translation.empty()) continue;
    result.push_back({distance, error_stats(std::move(errors.translation)),
                      error_stats(std::move(errors.rotation))});
  }
  return result;
}

double path_length(const std::vector<PosePair>& pairs) {
  return pairs.empty() ? 0.0 : travelled(pairs).back();
}

}  // namespace majak::eval
