// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/marginals.hpp"

#include "majak/core/error.hpp"

namespace majak::graph {

Marginals::Marginals(const PoseGraph& graph, std::span<const double> edge_weight)
    : poses_(graph.poses) {
  check(graph);
  equations_.set(graph);
  equations_.linearize(poses_, edge_weight);
  if (!equations_.matrix().factor())
    throw Error("pose graph: its edges leave a pose undetermined, so it has no covariance");
  const std::vector<Mat3> blocks = equations_.matrix().inverse_diagonal();
  diagonal_.assign(poses_.size(), Mat3::Zero());
  for (std::size_t i = 0; i < poses_.size(); ++i)
    if (!equations_.is_anchor(static_cast<int>(i)))
      diagonal_[i] = blocks[equations_.variable(static_cast<int>(i))];
}

std::vector<Vec3> Marginals::response(const PoseGraph& graph, std::size_t first,
                                      std::span<const Vec3> shifts) const {
  std::vector<double> column(3 * static_cast<std::size_t>(equations_.matrix().size()), 0.0);
  const auto add = [&](int pose, const Vec3& gradient) {
    if (equations_.is_anchor(pose)) return;
    Eigen::Map<Vec3>(&column[3 * static_cast<std::size_t>(equations_.variable(pose))]) += gradient;
  };
  for (std::size_t k = 0; k < shifts.size(); ++k) {
    if (shifts[k].isZero()) continue;
    const Edge& edge = graph.edges[first + k];
    const ResidualJacobians d =
        residual_jacobians(poses_[static_cast<std::size_t>(edge.from)],
                           poses_[static_cast<std::size_t>(edge.to)], edge.T_from_to);
    const Vec3 weighted = edge.information * shifts[k];
    add(edge.from, d.from.transpose() * weighted);
    add(edge.to, d.to.transpose() * weighted);
  }
  equations_.matrix().solve(column);
  std::vector<Vec3> result(poses_.size(), Vec3::Zero());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const int pose = static_cast<int>(i);
    if (!equations_.is_anchor(pose))
      result[i] =
          Eigen::Map<const Vec3>(&column[3 * static_cast<std::size_t>(equations_.variable(pose))]);
  }
  return result;
}

std::vector<Mat3> Marginals::cross(int i) const {
  std::vector<Mat3> result(poses_.size(), Mat3::Zero());
  if (equations_.is_anchor(i)) return result;
  std::vector<double> column(3 * static_cast<std::size_t>(equations_.matrix().size()));
  for (int c = 0; c < 3; ++c) {
    std::fill(column.begin(), column.end(), 0.0);
    column[3 * equations_.variable(i) + c] = 1;
    equations_.matrix().solve(column);
    for (std::size_t j = 0; j < result.size(); ++j) {
      if (equations_.is_anchor(static_cast<int>(j))) continue;
      const int v = equations_.variable(static_cast<int>(j));
      for (int r = 0; r < 3; ++r) result[j](r, c) = column[3 * v + r];
    }
  }
  return result;
}

Mat6 Marginals::joint(int i, int j) const {
  const Mat3 ji = cross(i)[static_cast<std::size_t>(j)];
  Mat6 m;
  m << covariance(i), ji.transpose(), ji, covariance(j);
  return m;
}

Mat3 Marginals::relative(int i, int j) const {
  return relative_covariance(poses_[static_cast<std::size_t>(i)],
                             poses_[static_cast<std::size_t>(j)], joint(i, j));
}

Mat3 relative_covariance(const Pose2& T_map_i, const Pose2& T_map_j, const Mat6& joint) {
  const ResidualJacobians d = residual_jacobians(T_map_i, T_map_j, between(T_map_i, T_map_j));
  Eigen::Matrix<double, 3, 6> j;
  j << d.from, d.to;
  return j * joint * j.transpose();
}

}  // namespace majak::graph
