// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/pose_graph.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <string>

#include "majak/core/error.hpp"

namespace majak::graph {
namespace {

/// All principal minors, each against the scale of its own diagonal, so that units do not matter.
bool positive_semidefinite(const Mat3& m) {
  constexpr double kTolerance = 1e-9;
  for (int i = 0; i < 3; ++i) {
    if (m(i, i) < 0) return false;
    const int j = (i + 1) % 3;
    const double scale = m(i, i) * m(j, j);
    if (scale - m(i, j) * m(j, i) < -kTolerance * scale) return false;
  }
  return m.determinant() >= -kTolerance * m(0, 0) * m(1, 1) * m(2, 2);
}

bool symmetric(const Mat3& m) {
  return (m - m.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * m.cwiseAbs().maxCoeff();
}

void check_edge(const PoseGraph& graph, std::size_t index) {
  const Edge& e = graph.edges[index];
  const int n = static_cast<int>(graph.poses.size());
  const auto fail = [&](const char* what) {
    throw Error("pose graph: edge " + std::to_string(index) + " (" + std::to_string(e.from) +
                " to " + std::to_string(e.to) + ") " + what);
  };
  if (e.from < 0 || e.to < 0 || e.from >= n || e.to >= n) fail("names a pose that does not exist");
  if (e.from == e.to) fail("joins a pose to itself");
  if (!e.T_from_to.finite()) fail("has a measurement that is not finite");
  if (!e.information.allFinite()) fail("has an information that is not finite");
  if (!symmetric(e.information)) fail("has an information that is not symmetric");
  if (!positive_semidefinite(e.information))
    fail("has an information that is not positive semi-definite");
}

}  // namespace

Vec3 residual(const Pose2& T_map_from, const Pose2& T_map_to, const Pose2& T_from_to) {
  return between(T_from_to, between(T_map_from, T_map_to)).vector();
}

ResidualJacobians residual_jacobians(const Pose2& T_map_from, const Pose2& T_map_to,
                                     const Pose2& T_from_to) {
  const double angle = T_map_from.theta + T_from_to.theta;
  const double c = std::cos(angle), s = std::sin(angle);
  const double dx = T_map_to.x - T_map_from.x, dy = T_map_to.y - T_map_from.y;
  ResidualJacobians j;
  j.to << c, s, 0, -s, c, 0, 0, 0, 1;
  j.from = -j.to;
  j.from(0, 2) = -s * dx + c * dy;
  j.from(1, 2) = -c * dx - s * dy;
  return j;
}

double chi2(const PoseGraph& graph, const Edge& edge) {
  const Vec3 e = residual(graph.poses[static_cast<std::size_t>(edge.from)],
                          graph.poses[static_cast<std::size_t>(edge.to)], edge.T_from_to);
  return e.dot(edge.information * e);
}

double chi2(const PoseGraph& graph) {
  double sum = 0;
  for (const Edge& edge : graph.edges) sum += chi2(graph, edge);
  return sum;
}

void check(const PoseGraph& graph) {
  const int n = static_cast<int>(graph.poses.size());
  for (int i = 0; i < n; ++i)
    if (!graph.poses[static_cast<std::size_t>(i)].finite())
      throw Error("pose graph: pose " + std::to_string(i) + " is not finite");
  if (n > 0 && (graph.fixed < 0 || graph.fixed >= n))
    throw Error("pose graph: the fixed pose " + std::to_string(graph.fixed) + " does not exist");
  for (std::size_t k = 0; k < graph.edges.size(); ++k) check_edge(graph, k);
}

namespace {

/// The first pose of each pose's component; robust edges join only if asked.
std::vector<int> component_roots(const PoseGraph& graph, bool with_robust) {
  std::vector<int> root(graph.poses.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const Edge& e : graph.edges) {
    if (e.robust && !with_robust) continue;
    const int a = find(e.from), b = find(e.to);
    root[std::max(a, b)] = std::min(a, b);  // so that a root is the first pose of its component
  }
  for (int i = 0; i < static_cast<int>(root.size()); ++i) root[i] = find(i);
  return root;
}

}  // namespace

std::vector<int> anchors(const PoseGraph& graph) {
  std::vector<int> result;
  if (graph.poses.empty()) return result;
  const std::vector<int> root = component_roots(graph, true);
  for (int i = 0; i < static_cast<int>(root.size()); ++i)
    if (root[i] == i) result.push_back(i == root[graph.fixed] ? graph.fixed : i);
  std::sort(result.begin(), result.end());
  return result;
}

bool trusted_edges_connect(const PoseGraph& graph) {
  return component_roots(graph, false) == component_roots(graph, true);
}

}  // namespace majak::graph
