// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/pose_covariance.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "majak/graph/marginals.hpp"
#include "majak/slam/range_bias.hpp"

namespace majak::slam {
namespace {

constexpr double kPairGate = 0.075;  // m

// An edge's measurement under each of the common errors: the law of the ranges, then the motion.
constexpr int kColumns = RangeBias::kCount + 1;
using Shifts = std::array<std::vector<Vec3>, kColumns>;

// The two key scans whose returns an edge holds against each other; a local map stands for the one
// that began it.
std::optional<std::pair<std::size_t, std::size_t>> scans_of(
    const graph::Edge& edge, std::size_t keys, const std::vector<std::size_t>& local_maps) {
  const auto key_of = [&](int pose) {
    const auto p = static_cast<std::size_t>(pose);
    return p < keys ? p : local_maps[p - keys];
  };
  const std::size_t from = key_of(edge.from), to = key_of(edge.to);
  if (from == to) return std::nullopt;
  return std::pair{from, to};
}

bool is_motion(const graph::Edge& edge, std::size_t keys) {
  return edge.to == edge.from + 1 && static_cast<std::size_t>(edge.to) < keys;
}

Shifts common_errors(const KeyScans& keys, const JointRefinement& refined,
                     const std::vector<UnseenMotion>& unseen) {
  std::vector<LaserView> views;
  for (const KeyScan& key : keys) views.push_back(laser_view(key));
  const auto& edges = refined.chain.graph.edges;
  Shifts shifts;
  shifts.fill(std::vector<Vec3>(edges.size(), Vec3::Zero()));
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (is_motion(edges[e], keys.size())) {
      shifts.back()[e].x() = unseen[static_cast<std::size_t>(edges[e].to)].way;
    } else if (const auto scans = scans_of(edges[e], keys.size(), refined.chain.local_maps)) {
      const auto columns =
          RangeBias::shift(keys[scans->first], views[scans->first], keys[scans->second], kPairGate);
      for (int c = 0; c < RangeBias::kCount; ++c)
        shifts[static_cast<std::size_t>(c)][e] = columns.col(c);
    }
  }
  return shifts;
}

}  // namespace

UnseenMotion unseen_motion(const PosedScan& from, const PosedScan& to) {
  if (from.T_odom_robot && to.T_odom_robot) {
    const Pose2 step = between(*from.T_odom_robot, *to.T_odom_robot);
    return {0.005 + 0.01 * step.translation().norm(), 0.01 + 0.02 * std::abs(step.theta)};
  }
  const double time = std::min(std::abs(to_seconds(to.scan.time - from.scan.time)), 1000.0);
  return {0.01 + 0.5 * time, 0.02 + 0.5 * time};
}

std::vector<Mat3> key_covariances(const KeyScans& keys, const JointRefinement& refined,
                                  const std::vector<UnseenMotion>& unseen) {
  std::vector<Mat3> covariances(keys.size(), Mat3::Zero());
  if (keys.size() < 2) return covariances;
  const graph::PoseGraph& graph = refined.chain.graph;
  const graph::Marginals marginals(graph);
  for (std::size_t k = 0; k < keys.size(); ++k)
    covariances[k] = marginals.covariance(static_cast<int>(k));
  for (const std::vector<Vec3>& shift : common_errors(keys, refined, unseen)) {
    const std::vector<Vec3> response = marginals.response(graph, shift);
    for (std::size_t k = 0; k < keys.size(); ++k)
      covariances[k] += response[k] * response[k].transpose();
  }
  return covariances;
}

Mat3 scan_covariance(const Mat3& key_covariance, const match::Match& match,
                     const UnseenMotion& unseen) {
  Mat3 information = match.information;
  information.diagonal() +=
      Vec3(unseen.way * unseen.way, unseen.way * unseen.way, unseen.turn * unseen.turn)
          .cwiseInverse();
  return key_covariance + information.inverse();
}

}  // namespace majak::slam
