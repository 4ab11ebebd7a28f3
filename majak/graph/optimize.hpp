// SPDX-License-Identifier: Apache-2.0
// Optimising a pose graph: Gauss-Newton with a Levenberg-Marquardt fallback on SE(2).
//
//   Summary s = optimize(graph);                       // one call, from wherever the poses are
//
//   Optimizer optimizer({.start = Start::given});      // many calls, edges added in between
//   graph.edges.push_back(closure);
//   optimizer.optimize(graph);
#pragma once

#include <span>
#include <vector>

#include "majak/graph/kernel.hpp"
#include "majak/graph/normal_equations.hpp"
#include "majak/graph/pose_graph.hpp"

namespace majak::graph {

enum class Start {
  given,        ///< the poses as they are: right when they are nearly right
  initialized,  ///< from the edges alone, see initialize(); robust ones only if they must
  best,         ///< the better of the two; both are followed if the first ends implausibly high
};

struct OptimizeOptions {
  int max_iterations = 100;          ///< linear solves from one start, 0 ... 1000
  double relative_tolerance = 1e-7;  ///< stop when a step promises less of chi2 than this
  Start start = Start::best;
  Robust robust = Robust::dcs_truncated;  ///< for edges marked robust
  double robust_bound = 11.34;            ///< chi2 of an edge that is doubted (99 % at 3 dof)
};

struct Summary {
  int iterations = 0;        ///< linear solves
  double initial_chi2 = 0;   ///< of all edges at the poses given
  double final_chi2 = 0;     ///< sum of weight * e' Omega e
  double final_cost = 0;     ///< with the robust kernel's cost in place of chi2; what was minimised
  bool converged = false;    ///< else max_iterations was reached or no step helped
  bool initialized = false;  ///< the result came from initialize(), not from the poses given
  std::vector<double> edge_chi2;    ///< e' Omega e at the result
  std::vector<double> edge_weight;  ///< 1, or the robust kernel's weight
};

/// Reusable: while the edges join the same poses the structure and all buffers are kept.
class Optimizer {
 public:
  explicit Optimizer(OptimizeOptions options = {}) : options_(options) {}

  /// Moves the poses to a minimum of the cost. Anchors (see anchors()) stay. Throws Error where
  /// check() does. A graph without edges or with one pose is its own optimum.
  Summary optimize(PoseGraph& graph);

 private:
  struct Descent {
    std::vector<Pose2> poses;
    double cost = 0;
    bool converged = false;
  };
  Descent run(const PoseGraph& graph, std::vector<Pose2> poses, bool initial);
  Descent run_best(const PoseGraph& graph, Summary& summary);
  void descend(const PoseGraph& graph, const Kernel& kernel, double tolerance, Descent& d);
  void relax(const PoseGraph& graph, bool grow, Descent& d);
  void withhold(const PoseGraph& graph, int last);
  void graduate(const PoseGraph& graph, Descent& d);
  bool step(const PoseGraph& graph, const Kernel& kernel, double tolerance, Descent& d);
  double evaluate(const PoseGraph& graph, std::span<const Pose2> poses, const Kernel& kernel);
  std::vector<Pose2> initial_poses(const PoseGraph& graph);
  Kernel final_kernel() const;

  OptimizeOptions options_;
  NormalEquations equations_;
  std::vector<double> chi2_, weight_, dx_;
  std::vector<Pose2> trial_;
  int iterations_ = 0;  ///< of the present descent from one start
  double damping_ = 0;
  bool any_robust_ = false;
};

/// One call with its own buffers.
Summary optimize(PoseGraph& graph, const OptimizeOptions& options = {});

}  // namespace majak::graph
