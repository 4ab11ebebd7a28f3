// SPDX-License-Identifier: Apache-2.0
// The same problem for Ceres, with analytic derivatives: what our optimiser is measured against.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <array>
#include <vector>

#include "majak/graph/pose_graph.hpp"

namespace majak::graph {

/// sqrt(Omega) * residual over two blocks (x, y, theta): `from` and `to`.
class CeresEdge : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit CeresEdge(const Edge& edge)
      : edge_(edge), root_(Eigen::LLT<Mat3>(edge.information).matrixU()) {}

  bool Evaluate(double const* const* p, double* error, double** jacobians) const override {
    const Pose2 from{p[0][0], p[0][1], p[0][2]}, to{p[1][0], p[1][1], p[1][2]};
    Eigen::Map<Vec3>(error, 3) = root_ * residual(from, to, edge_.T_from_to);
    if (!jacobians) return true;
    using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const ResidualJacobians j = residual_jacobians(from, to, edge_.T_from_to);
    if (jacobians[0]) Eigen::Map<RowMajor>(jacobians[0], 3, 3) = root_ * j.from;
    if (jacobians[1]) Eigen::Map<RowMajor>(jacobians[1], 3, 3) = root_ * j.to;
    return true;
  }

 private:
  Edge edge_;
  Mat3 root_;
};

/// Poses as Ceres wants them; headings need no manifold, as residual() wraps.
using CeresPoses = std::vector<std::array<double, 3>>;

inline CeresPoses ceres_poses(const PoseGraph& graph) {
  CeresPoses poses;
  for (const Pose2& p : graph.poses) poses.push_back({p.x, p.y, p.theta});
  return poses;
}

inline void add_to_ceres(const PoseGraph& graph, CeresPoses& poses, ceres::Problem& problem) {
  for (const Edge& e : graph.edges)
    problem.AddResidualBlock(new CeresEdge(e), nullptr,
                             poses[static_cast<std::size_t>(e.from)].data(),
                             poses[static_cast<std::size_t>(e.to)].data());
  for (const int a : anchors(graph)) {
    double* block = poses[static_cast<std::size_t>(a)].data();
    if (problem.HasParameterBlock(block)) problem.SetParameterBlockConstant(block);
  }
}

}  // namespace majak::graph
