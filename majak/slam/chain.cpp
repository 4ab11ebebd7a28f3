// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/chain.hpp"

#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace majak::slam {
namespace {

constexpr double kShared =
    0.25;  // of a match's information: returns of one wall share their errors
const Vec3 kMatchFloor(4e-6, 4e-6, 1e-6);  // m^2, rad^2
const Vec3 kDrift(2e-6, 2e-6, 5e-7);  // m^2, rad^2 for a key scan: the local map's own random walk
const Vec3 kWeakStep(0.04, 0.04, 0.04);     // m^2, rad^2
const Vec3 kMotionFloor(1e-6, 1e-6, 1e-6);  // m^2, rad^2

Mat3 rotation3(double theta) {
  const double c = std::cos(theta), s = std::sin(theta);
  Mat3 r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  return r;
}

// The match's own information, which knows the weak directions, widened by what it does not know.
Mat3 match_information(const FrontEndStep& step, bool weak) {
  const Mat3 r = rotation3(step.T_map_robot.theta);
  const Mat3 information = kShared * r.transpose() * step.match.information * r;
  Mat3 covariance = (information + 1e-3 * Mat3::Identity()).inverse();
  covariance.diagonal() += kMatchFloor;
  if (weak) covariance.diagonal() += kWeakStep;
  return covariance.inverse();
}

}  // namespace

KeyScan key_scan(FrontEndStep&& step, std::size_t scan, const Pose2& T_robot_laser, bool weak) {
  KeyScan key;
  key.scan = scan;
  key.points = std::move(step.key_points);
  key.T_robot_laser = T_robot_laser;
  key.T_front_robot = step.T_map_robot;
  key.weak_step = weak;
  key.local_map = step.local_map;
  key.match_information = match_information(step, weak);
  key.T_previous_predicted = step.T_key_predicted;
  Vec3 variance = step.predicted_variance + kMotionFloor;
  if (weak) variance += kWeakStep;
  key.motion_information = variance.cwiseInverse().asDiagonal();
  return key;
}

std::optional<graph::Edge> local_map_edge(const KeyScans& keys, std::size_t k) {
  const std::size_t first = keys[k].local_map;
  if (first >= k) return std::nullopt;
  Mat3 covariance = keys[k].match_information.inverse();
  covariance.diagonal() += static_cast<double>(k - first) * kDrift;
  return graph::Edge{static_cast<int>(first), static_cast<int>(k),
                     between(keys[first].T_front_robot, keys[k].T_front_robot),
                     covariance.inverse(), false};
}

graph::Edge motion_edge(const KeyScans& keys, std::size_t k) {
  return {static_cast<int>(k) - 1, static_cast<int>(k), keys[k].T_previous_predicted,
          keys[k].motion_information, false};
}

Mat3 chain_information(const KeyScans& keys, std::size_t from, std::size_t to) {
  Mat3 moved = Mat3::Zero(), matched = keys[to].match_information.inverse();
  const Mat3 a = adjoint(between(keys[to].T_front_robot, keys[from].T_front_robot));
  matched += a * keys[from].match_information.inverse() * a.transpose();
  matched.diagonal() += static_cast<double>(to - from) * kDrift;
  for (std::size_t k = from + 1; k <= to; ++k) {
    const Mat3 b = adjoint(between(keys[to].T_front_robot, keys[k].T_front_robot));
    moved += b * keys[k].motion_information.inverse() * b.transpose();
    if (keys[k].weak_step) matched += b * kWeakStep.asDiagonal() * b.transpose();
  }
  return matched.inverse() + moved.inverse();
}

}  // namespace majak::slam
