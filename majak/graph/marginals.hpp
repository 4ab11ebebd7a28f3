// SPDX-License-Identifier: Apache-2.0
// Marginals: how sure each pose of an optimised graph is.
#pragma once

#include <span>
#include <vector>

#include "majak/graph/normal_equations.hpp"
#include "majak/graph/pose_graph.hpp"

namespace majak::graph {

using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Covariances of (x, y, theta) in the map's axes, given that the anchors stand still (their own
/// are zero). All 3 x 3 diagonal blocks are made at once from the factor, without solves.
class Marginals {
 public:
  /// At the poses as they are; `edge_weight` as Summary::edge_weight, or empty. Throws Error where
  /// check() does, and if the edges leave a pose undetermined.
  explicit Marginals(const PoseGraph& graph, std::span<const double> edge_weight = {});

  const Mat3& covariance(int pose) const { return diagonal_[static_cast<std::size_t>(pose)]; }

  /// How the optimum moves, to first order, if the measurement of edge k is off by shifts[k], i.e.
  /// T_from_to * exp(shift); one solve. `graph`: the one that this was made from.
  std::vector<Vec3> response(const PoseGraph& graph, std::span<const Vec3> shifts) const {
    return response(graph, 0, shifts);
  }
  /// The same with shifts[k] of edge first + k, and none of all others.
  std::vector<Vec3> response(const PoseGraph& graph, std::size_t first,
                             std::span<const Vec3> shifts) const;

  /// Covariance of pose i with every pose j, [j](r, c) = cov(j's r, i's c); three solves.
  std::vector<Mat3> cross(int i) const;
  /// Covariance of both poses, i first; three solves.
  Mat6 joint(int i, int j) const;
  /// Covariance of residual(i, j, T_i_j), the relative pose in the axes of j; three solves.
  Mat3 relative(int i, int j) const;

 private:
  std::vector<Pose2> poses_;
  NormalEquations equations_;
  std::vector<Mat3> diagonal_;
};

/// Covariance of the relative pose T_i_j, in the axes of j, from the joint covariance of both.
Mat3 relative_covariance(const Pose2& T_map_i, const Pose2& T_map_j, const Mat6& joint);

}  // namespace majak::graph
