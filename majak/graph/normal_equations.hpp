// SPDX-License-Identifier: Apache-2.0
// NormalEquations: H dx = b of a pose graph, linearised at given poses (MATH 2.4). Keeps structure,
// buffers and the order of elimination while the edges join the same poses.
#pragma once

#include <span>
#include <vector>

#include "majak/graph/block_cholesky.hpp"
#include "majak/graph/pose_graph.hpp"

namespace majak::graph {

class NormalEquations {
 public:
  /// Takes structure and measurements from the graph, which must pass check(). The structure is
  /// analysed only if it changed.
  void set(const PoseGraph& graph);

  /// Builds H and b at `poses` with edge k weighted by weights[k] (all 1 if empty) and returns the
  /// weighted chi2.
  double linearize(std::span<const Pose2> poses, std::span<const double> weights = {});

  /// As linearize(), but for edges whose error is linear in the positions: the turn enters as at
  /// residual 0. One step from poses with the right headings gives the right positions, wherever
  /// they were (MATH 2.7).
  double linearize_positions(std::span<const Pose2> poses, std::span<const double> weights = {});

  /// Equations of the relaxed rotations: minimise the sum of w |z_to - exp(i turn) z_from|^2 over
  /// complex numbers z; at the anchors z is the heading that `poses` give (MATH 2.6).
  void build_rotations(std::span<const Pose2> poses, std::span<const double> weights = {});

  /// dx = (H + damping diag H)^-1 b; three numbers a pose, 0 at the anchors. False where H is
  /// singular.
  bool solve(double damping, std::vector<double>& dx);

  /// What the linear model expects chi2 to fall by for a step dx found with that damping.
  double predicted_decrease(std::span<const double> dx, double damping) const;

  /// e' Omega e of every edge.
  void edge_chi2(std::span<const Pose2> poses, std::span<double> result);
  double weighted_chi2(std::span<const Pose2> poses, std::span<const double> weights = {});

  BlockCholesky& matrix() { return matrix_; }
  const BlockCholesky& matrix() const { return matrix_; }
  int variable(int pose) const { return variable_[pose]; }  ///< size() of the matrix at an anchor
  bool is_anchor(int pose) const { return variable_[pose] == matrix_.size(); }
  const std::vector<int>& anchors() const { return anchors_; }
  int degrees_of_freedom() const;

 private:
  struct Turn {
    double c = 1, s = 0;
  };
  /// An edge as the inner loop wants it.
  struct Term {
    int from, to;
    double x, y;                    ///< measured translation turned back by the measured angle
    double c, s, angle;             ///< measured angle
    double xx, xy, yy, xt, yt, tt;  ///< information
    BlockCholesky::Slot slot;
  };
  /// An edge's error and information in the map's axes.
  struct Local {
    double rx, ry, rt;              ///< error
    double xx, xy, yy, xt, yt, tt;  ///< information
    double dx, dy;                  ///< displacement from -> to as it is
  };
  Local local(const Term& term, std::span<const Pose2> poses) const;
  double linearize(std::span<const Pose2> poses, std::span<const double> weights, bool positions);
  void turn_poses(std::span<const Pose2> poses);
  void analyze(const PoseGraph& graph);

  std::size_t poses_ = 0;
  int fixed_ = -1;
  std::vector<int> variable_, anchors_;
  std::vector<Term> terms_;
  std::vector<Turn> turns_;  ///< cosine and sine of each pose's heading
  std::vector<double> b_;    ///< three numbers a variable, then three that are not read
  std::vector<double> solution_;
  BlockCholesky matrix_;
};

}  // namespace majak::graph
