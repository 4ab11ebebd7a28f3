// SPDX-License-Identifier: Apache-2.0
// PoseGraph: poses in the plane and measured relative poses between them (docs/MATH.md, "Pose
// graph"). The error of an edge and its information follow g2o's convention for EDGE_SE2.
#pragma once

#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::graph {

/// A measured relative pose between two poses of the graph.
struct Edge {
  int from = 0, to = 0;                 ///< indices into PoseGraph::poses
  Pose2 T_from_to;                      ///< the measurement
  Mat3 information = Mat3::Identity();  ///< of residual(); symmetric, positive semi-definite
  bool robust = false;                  ///< may be false: a robust kernel judges it
};

struct PoseGraph {
  std::vector<Pose2> poses;  ///< T_map_node
  std::vector<Edge> edges;
  int fixed = 0;  ///< the pose that stays; every other component keeps its first pose too
};

/// vector(T_from_to^-1 * (T_map_from^-1 * T_map_to)): m, m, rad in the axes of the measured `to`.
Vec3 residual(const Pose2& T_map_from, const Pose2& T_map_to, const Pose2& T_from_to);

/// The residual's derivatives by (x, y, theta) of both poses, map axes (MATH 2.3).
struct ResidualJacobians {
  Mat3 from, to;
};
ResidualJacobians residual_jacobians(const Pose2& T_map_from, const Pose2& T_map_to,
                                     const Pose2& T_from_to);

/// e' Omega e of one edge, and the sum over all edges (robust or not).
double chi2(const PoseGraph& graph, const Edge& edge);
double chi2(const PoseGraph& graph);

/// Throws Error naming the first pose or edge that is not usable: index out of range, an edge from
/// a pose to itself, a value that is not finite, an information that is not symmetric positive
/// semi-definite.
void check(const PoseGraph& graph);

/// One pose of each connected component, ascending: `fixed`, and the first pose of each other
/// component. They carry the gauge freedom and do not move.
std::vector<int> anchors(const PoseGraph& graph);

/// True where the edges that are not robust join all that the edges join together.
bool trusted_edges_connect(const PoseGraph& graph);

}  // namespace majak::graph
