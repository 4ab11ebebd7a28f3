// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/chain.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace majak::slam {
namespace {

const Vec3 kMatchFloor(4e-6, 4e-6, 1e-6);   // m^2, rad^2
const Vec3 kWeakStep(0.04, 0.04, 0.04);     // m^2, rad^2
constexpr double kLoose = 0.05;             // m; what comes after a match known worse hangs on it
const Vec3 kMotionFloor(1e-6, 1e-6, 1e-6);  // m^2, rad^2

// Rounding leaves an inverse symmetric to a few digits only; the pose graph asks for all of them.
Mat3 symmetric(const Mat3& m) { return 0.5 * (m + m.transpose()); }

// The match's own information, which knows the weak directions, widened by what it does not know.
Mat3 match_information(const FrontEndStep& step, bool weak) {
  const Mat3 r = rotation3(step.T_map_robot.theta);
  const Mat3 information =
      kSharedErrors * r.transpose() * step.match.information * r + 1e-3 * Mat3::Identity();
  const Vec3 unknown = weak ? Vec3(kMatchFloor + kWeakStep) : kMatchFloor;
  // (information^-1 + unknown)^-1 without the inverse of what may be nearly singular.
  const Mat3 widened = Mat3::Identity() + information * unknown.asDiagonal();
  return symmetric(widened.inverse() * information);
}

// The direction (own axes) in which a key scan's match left its pose open, if any.
struct Loose {
  Vec3 direction = Vec3::Zero();
  double variance = 0;  // m^2, along it
};
std::optional<Loose> loose(const KeyScan& key) {
  const Mat3 covariance = key.match_information.inverse();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(covariance.topLeftCorner<2, 2>());
  if (axes.eigenvalues()(1) < kLoose * kLoose) return std::nullopt;
  const Vec2 direction = axes.eigenvectors().col(1);
  return Loose{{direction.x(), direction.y(), 0}, axes.eigenvalues()(1)};
}

// The newest key scan before k in its local map whose match was loose.
std::optional<std::size_t> newest_loose(const KeyScans& keys, std::size_t k) {
  for (std::size_t j = k; j-- > keys[k].local_map + 1;)
    if (loose(keys[j])) return j;
  return std::nullopt;
}

}  // namespace

Mat3 rotation3(double theta) {
  const double c = std::cos(theta), s = std::sin(theta);
  Mat3 r;
  r << c, -s, 0, s, c, 0, 0, 0, 1;
  return r;
}

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

std::vector<graph::Edge> match_edges(const KeyScans& keys, std::size_t k) {
  const std::size_t first = keys[k].local_map;
  if (first >= k) return {};
  const auto edge = [&](std::size_t from, const Mat3& information) {
    return graph::Edge{static_cast<int>(from), static_cast<int>(k),
                       between(keys[from].T_front_robot, keys[k].T_front_robot), information,
                       false};
  };
  const Mat3& information = keys[k].match_information;
  const auto from = newest_loose(keys, k);
  if (!from) return {edge(first, information)};
  const double turn = angle_diff(keys[*from].T_front_robot.theta, keys[k].T_front_robot.theta);
  const Vec3 t = rotation3(turn) * loose(keys[*from])->direction;
  const Mat3 across = Mat3::Identity() - t * t.transpose();
  return {edge(first, across * information * across + 1e-3 * t * t.transpose()),
          edge(*from, t.dot(information * t) * t * t.transpose())};
}

// What a local map's first key scan is off in it: it was matched to none, so as much as the next.
Mat3 information_in_local_map(const KeyScans& keys, std::size_t k) {
  const bool first = keys[k].local_map == k;
  return keys[first && k + 1 < keys.size() ? k + 1 : k].match_information;
}

// The newest local map, begun by key scan `first`, hangs on the one before, which `before` began;
// in a direction that matches left open it hangs on the key scan that began it, as that one does on
// the wheels.
void hang_on(graph::PoseGraph& graph, const KeyScans& keys, std::size_t before, std::size_t first) {
  const int map = static_cast<int>(graph.poses.size()) - 1;
  const Mat3 information =
      Mat3(static_cast<double>(first - before) * Mat3(kLocalMapDrift.asDiagonal())).inverse();
  const Pose2 T = between(keys[before].T_front_robot, keys[first].T_front_robot);
  const auto open = loose(keys[first]) ? std::optional(first) : newest_loose(keys, first);
  if (!open) {
    graph.edges.push_back({map - 1, map, T, information, false});
    return;
  }
  const double turn = angle_diff(keys[*open].T_front_robot.theta, keys[first].T_front_robot.theta);
  const Vec3 t = rotation3(turn) * loose(keys[*open])->direction;
  const Mat3 along = t * t.transpose(), across = Mat3::Identity() - along;
  graph.edges.push_back({map - 1, map, T, across * information * across + 1e-3 * along, false});
  graph.edges.push_back(
      {static_cast<int>(first), map, Pose2{}, t.dot(information * t) * along, false});
}

ChainGraph chain_graph(const KeyScans& keys) {
  ChainGraph chain;
  graph::PoseGraph& graph = chain.graph;
  for (const KeyScan& key : keys) graph.poses.push_back(key.T_map_robot);
  std::size_t map_key = keys.size();  // where the newest local map began
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const int key = static_cast<int>(k);
    if (k > 0) graph.edges.push_back(motion_edge(keys, k));
    const std::size_t first = keys[k].local_map;
    if (first != map_key) {
      const int map = static_cast<int>(graph.poses.size());
      graph.poses.push_back(keys[first].T_map_robot);
      chain.local_maps.push_back(first);
      if (first != k) {  // it took over from the map before
        hang_on(graph, keys, map_key, first);
      } else {
        graph.edges.push_back({map, key, Pose2{}, information_in_local_map(keys, k), false});
      }
      map_key = first;
    }
    for (graph::Edge edge : match_edges(keys, k)) {
      if (edge.from == static_cast<int>(first))
        edge.from = static_cast<int>(graph.poses.size()) - 1;
      graph.edges.push_back(edge);
    }
  }
  return chain;
}

graph::Edge motion_edge(const KeyScans& keys, std::size_t k) {
  return {static_cast<int>(k) - 1, static_cast<int>(k), keys[k].T_previous_predicted,
          keys[k].motion_information, false};
}

Mat3 chain_information(const KeyScans& keys, std::size_t from, std::size_t to) {
  Mat3 moved = Mat3::Zero(), matched = keys[to].match_information.inverse();
  const Mat3 a = adjoint(between(keys[to].T_front_robot, keys[from].T_front_robot));
  matched += a * keys[from].match_information.inverse() * a.transpose();
  matched.diagonal() += static_cast<double>(to - from) * kLocalMapDrift;
  for (std::size_t k = from + 1; k <= to; ++k) {
    const Mat3 b = adjoint(between(keys[to].T_front_robot, keys[k].T_front_robot));
    moved += b * keys[k].motion_information.inverse() * b.transpose();
    if (keys[k].weak_step) matched += b * kWeakStep.asDiagonal() * b.transpose();
    const auto open = k < to ? loose(keys[k]) : std::nullopt;
    if (open)
      matched += open->variance * b * open->direction * open->direction.transpose() * b.transpose();
  }
  return symmetric(matched.inverse() + moved.inverse());
}

}  // namespace majak::slam
