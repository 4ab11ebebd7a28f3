// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/optimize.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/graph/initialize.hpp"

namespace majak::graph {
namespace {

constexpr double kFirstDamping = 1e-4, kDampingFactor = 10, kMaxDamping = 1e8;

void add(std::span<const double> dx, std::span<const Pose2> from, std::vector<Pose2>& to) {
  to.resize(from.size());
  for (std::size_t i = 0; i < from.size(); ++i)
    to[i] = {from[i].x + dx[3 * i], from[i].y + dx[3 * i + 1],
             wrap_angle(from[i].theta + dx[3 * i + 2])};
}

}  // namespace

/// Cost at the poses; leaves chi2_ and weight_ of every edge behind.
double Optimizer::evaluate(const PoseGraph& graph, std::span<const Pose2> poses,
                           const Kernel& kernel) {
  equations_.edge_chi2(poses, chi2_);
  double sum = 0;
  for (std::size_t k = 0; k < chi2_.size(); ++k) {
    const bool judged = graph.edges[k].robust;
    weight_[k] = judged ? kernel.weight(chi2_[k]) : 1.0;
    sum += judged ? kernel.cost(chi2_[k]) : chi2_[k];
  }
  return sum;
}

/// One accepted step: undamped first, then with more and more damping. False where the minimum is
/// reached as far as the tolerance asks, or no step helps (d.converged tells which).
bool Optimizer::step(const Kernel& kernel, const PoseGraph& graph, Descent& d, double& damping) {
  equations_.linearize(d.poses, any_robust_ ? std::span<const double>(weight_)
                                            : std::span<const double>());
  while (iterations_ < options_.max_iterations) {
    ++iterations_;
    const bool solved = equations_.solve(damping, dx_);
    if (solved) {
      const double promised = equations_.predicted_decrease(dx_, damping);
      const bool last = promised <= options_.relative_tolerance * d.cost;
      add(dx_, d.poses, trial_);
      const double cost = evaluate(graph, trial_, kernel);
      if (cost <= d.cost) {
        // Close to the minimum the linear model's error bounds what another step could still gain.
        const double surprise = std::abs(d.cost - cost - promised);
        const bool exact = promised <= 1e-2 * d.cost &&
                           surprise <= options_.relative_tolerance * d.cost && !any_robust_;
        std::swap(d.poses, trial_);
        d.cost = cost;
        damping = damping > kFirstDamping ? damping / kDampingFactor : 0;
        d.converged = last || exact;
        return !d.converged;
      }
      if (last) {  // rounding is all that is left
        d.converged = true;
        return false;
      }
    }
    damping = damping > 0 ? damping * kDampingFactor : kFirstDamping;
    if (damping > kMaxDamping) return false;
  }
  return false;
}

Optimizer::Descent Optimizer::descend(const PoseGraph& graph, std::vector<Pose2> poses,
                                      Kernel kernel) {
  Descent d{std::move(poses), 0, false};
  d.cost = evaluate(graph, d.poses, kernel);
  for (double damping = 0; step(kernel, graph, d, damping);) {
  }
  d.cost = evaluate(graph, d.poses, kernel);
  return d;
}

Optimizer::Descent Optimizer::run(const PoseGraph& graph, std::vector<Pose2> poses) {
  return descend(graph, std::move(poses),
                 {any_robust_ ? options_.robust : Robust::none, options_.robust_bound, 1});
}

Optimizer::Descent Optimizer::run_best(const PoseGraph& graph, Summary& summary) {
  std::vector<Pose2> initial = initialize(graph, equations_);
  const bool better = equations_.weighted_chi2(initial) < summary.initial_chi2;
  std::vector<Pose2> other = better ? graph.poses : initial;
  Descent first = run(graph, better ? std::move(initial) : graph.poses);
  summary.initialized = better;
  // A cost near the degrees of freedom is what a right minimum has; one far above may be a wrong one.
  if (first.converged && first.cost <= 2.0 * equations_.degrees_of_freedom()) return first;
  const int used = std::exchange(iterations_, 0);
  Descent second = run(graph, std::move(other));
  iterations_ += used;
  if (!(second.cost < first.cost)) return first;
  summary.initialized = !better;
  return second;
}

Summary Optimizer::optimize(PoseGraph& graph) {
  check(graph);
  equations_.set(graph);
  const std::size_t edges = graph.edges.size();
  chi2_.assign(edges, 0.0);
  weight_.assign(edges, 1.0);
  any_robust_ = options_.robust != Robust::none &&
                std::any_of(graph.edges.begin(), graph.edges.end(), [](auto& e) { return e.robust; });
  iterations_ = 0;

  Summary summary;
  summary.initial_chi2 = equations_.weighted_chi2(graph.poses);
  Descent d;
  if (options_.start == Start::best) {
    d = run_best(graph, summary);
  } else {
    summary.initialized = options_.start == Start::initialized;
    d = run(graph, summary.initialized ? initialize(graph, equations_) : graph.poses);
  }
  graph.poses = std::move(d.poses);
  summary.iterations = iterations_;
  summary.converged = d.converged;
  summary.final_cost = d.cost;
  const Kernel kernel{any_robust_ ? options_.robust : Robust::none, options_.robust_bound, 1};
  evaluate(graph, graph.poses, kernel);
  for (std::size_t k = 0; k < edges; ++k) summary.final_chi2 += weight_[k] * chi2_[k];
  summary.edge_chi2 = chi2_;
  summary.edge_weight = weight_;
  return summary;
}

Summary optimize(PoseGraph& graph, const OptimizeOptions& options) {
  return Optimizer(options).optimize(graph);
}

}  // namespace majak::graph
