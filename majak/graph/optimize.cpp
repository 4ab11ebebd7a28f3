// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/optimize.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "majak/graph/initialize.hpp"

namespace majak::graph {
namespace {

constexpr double kFirstDamping = 1e-4, kDampingFactor = 10, kMaxDamping = 1e8;
constexpr double kCoarseTolerance = 1e-6;  // change of cost that ends relax()
constexpr double kDoubted = 1e-9;          // weight of a robust edge that holds the start together
constexpr double kLastMu = 1e3;
constexpr int kStages = 20;  // in which relax() lets the robust edges in

void add(std::span<const double> dx, std::span<const Pose2> from, std::vector<Pose2>& to) {
  to.resize(from.size());
  for (std::size_t i = 0; i < from.size(); ++i)
    to[i] = {from[i].x + dx[3 * i], from[i].y + dx[3 * i + 1],
             wrap_angle(from[i].theta + dx[3 * i + 2])};
}

/// A step below what any measurement in metres and radians can tell.
bool nothing(std::span<const double> dx) {
  return std::all_of(dx.begin(), dx.end(), [](double d) { return std::abs(d) < 1e-10; });
}

}  // namespace

/// What is minimised in the end.
Kernel Optimizer::final_kernel() const {
  const double bound = options_.robust_bound;
  switch (any_robust_ ? options_.robust : Robust::none) {
    case Robust::none:
      return {Kernel::quadratic, bound};
    case Robust::cauchy:
      return {Kernel::cauchy, bound};
    case Robust::dcs:
      return {Kernel::dcs, bound};
    case Robust::dcs_truncated:
    case Robust::gnc_truncated:
      return {Kernel::truncated, bound};
  }
  return {};
}

/// Cost at the poses; leaves chi2_ and weight_ of every edge behind.
double Optimizer::evaluate(const PoseGraph& graph, std::span<const Pose2> poses,
                           const Kernel& kernel) {
  equations_.edge_chi2(poses, chi2_);
  double sum = 0;
  for (std::size_t k = 0; k < chi2_.size(); ++k) {
    const bool judged = any_robust_ && graph.edges[k].robust;
    weight_[k] = judged ? kernel.weight(chi2_[k]) : 1.0;
    sum += judged ? kernel.cost(chi2_[k]) : chi2_[k];
  }
  return sum;
}

/// One accepted step: undamped first, then with more and more damping. False where the minimum is
/// reached as far as the tolerance asks, or no step helps (d.converged tells which).
bool Optimizer::step(const PoseGraph& graph, const Kernel& kernel, double tolerance, Descent& d) {
  equations_.linearize(d.poses,
                       any_robust_ ? std::span<const double>(weight_) : std::span<const double>());
  while (iterations_ < options_.max_iterations && damping_ <= kMaxDamping) {
    ++iterations_;
    if (equations_.solve(damping_, dx_)) {
      const double promised = equations_.predicted_decrease(dx_, damping_);
      const bool last = promised <= tolerance * d.cost || nothing(dx_);
      add(dx_, d.poses, trial_);
      const double cost = evaluate(graph, trial_, kernel);
      if (cost <= d.cost) {
        // Close to the minimum the linear model's error bounds what another step could still gain.
        const double surprise = std::abs(d.cost - cost - promised);
        const bool exact =
            !any_robust_ && promised <= 1e-2 * d.cost && surprise <= tolerance * d.cost;
        std::swap(d.poses, trial_);
        d.cost = cost;
        damping_ = damping_ > kFirstDamping ? damping_ / kDampingFactor : 0;
        d.converged = last || exact;
        return !d.converged;
      }
      if (last) {  // rounding is all that is left
        d.converged = true;
        return false;
      }
    }
    damping_ = damping_ > 0 ? damping_ * kDampingFactor : kFirstDamping;
  }
  return false;
}

void Optimizer::descend(const PoseGraph& graph, const Kernel& kernel, double tolerance,
                        Descent& d) {
  d.cost = evaluate(graph, d.poses, kernel);
  d.converged = false;
  damping_ = 0;
  while (step(graph, kernel, tolerance, d)) {
  }
}

/// Dynamic covariance scaling by bare Gauss-Newton steps. The cost may rise on the way: a descent
/// would shrink its steps and stay in the first of the many hollows that false edges make.
/// With `grow` the robust edges come in by the time of their later pose, a step at each stage: the
/// drift that a true closure meets then is only what has gathered since the ones before it.
void Optimizer::relax(const PoseGraph& graph, bool grow, Descent& d) {
  const Kernel kernel{Kernel::dcs, options_.robust_bound};
  double change = std::numeric_limits<double>::infinity();
  d.cost = evaluate(graph, d.poses, kernel);
  for (int stage = grow ? 1 : kStages; change > kCoarseTolerance * d.cost; ++stage) {
    if (stage < kStages) withhold(graph, static_cast<int>(graph.poses.size()) / kStages * stage);
    equations_.linearize(d.poses, weight_);
    if (++iterations_ > options_.max_iterations || !equations_.solve(0, dx_)) return;
    add(dx_, d.poses, trial_);
    std::swap(d.poses, trial_);
    const double cost = evaluate(graph, d.poses, kernel);
    if (stage >= kStages) change = std::abs(d.cost - cost);
    d.cost = cost;
  }
}

/// Takes the robust edges that reach past a pose out of this step.
void Optimizer::withhold(const PoseGraph& graph, int last) {
  for (std::size_t k = 0; k < weight_.size(); ++k) {
    const Edge& e = graph.edges[k];
    if (e.robust && std::max(e.from, e.to) > last) weight_[k] = 0;
  }
}

/// From a nearly convex cost to the truncated one, one step at each stage (Yang et al. 2020).
void Optimizer::graduate(const PoseGraph& graph, Descent& d) {
  Kernel kernel = final_kernel();
  evaluate(graph, d.poses, kernel);
  double worst = 0;
  for (std::size_t k = 0; k < chi2_.size(); ++k)
    if (graph.edges[k].robust) worst = std::max(worst, chi2_[k]);
  if (worst <= kernel.bound) return;
  for (kernel.mu = kernel.bound / (2 * worst - kernel.bound); kernel.mu < kLastMu; kernel.mu *= 2) {
    d.cost = evaluate(graph, d.poses, kernel);
    damping_ = 0;
    step(graph, kernel, 0, d);
  }
}

Optimizer::Descent Optimizer::run(const PoseGraph& graph, std::vector<Pose2> poses, bool initial) {
  Descent d{std::move(poses), 0, false};
  iterations_ = 0;
  if (any_robust_ && options_.robust == Robust::gnc_truncated) graduate(graph, d);
  if (any_robust_ && (options_.robust == Robust::dcs || options_.robust == Robust::dcs_truncated))
    relax(graph, initial && trusted_edges_connect(graph), d);
  descend(graph, final_kernel(), options_.relative_tolerance, d);
  return d;
}

/// Edges that may be false have no say in where to start, unless nothing else holds the graph
/// together.
std::vector<Pose2> Optimizer::initial_poses(const PoseGraph& graph) {
  if (!any_robust_) return initialize(graph, equations_);
  const double doubted = trusted_edges_connect(graph) ? 0.0 : kDoubted;
  std::vector<double> weights;
  for (const Edge& e : graph.edges) weights.push_back(e.robust ? doubted : 1.0);
  return initialize(graph, equations_, weights);
}

Optimizer::Descent Optimizer::run_best(const PoseGraph& graph, Summary& summary) {
  std::vector<Pose2> initial = initial_poses(graph);
  const double initial_chi2 = equations_.weighted_chi2(initial);
  const bool first_is_initial = any_robust_ || initial_chi2 < summary.initial_chi2;
  const auto follow = [&](bool from_initial) {
    Descent d = run(graph, from_initial ? initial : graph.poses, from_initial);
    summary.iterations += iterations_;
    return d;
  };
  Descent first = follow(first_is_initial);
  summary.initialized = first_is_initial;
  // A right minimum has a cost near the degrees of freedom; one far above may be a wrong one.
  if (first.converged && first.cost <= 2.0 * equations_.degrees_of_freedom()) return first;
  Descent second = follow(!first_is_initial);
  if (!(second.cost < first.cost)) return first;
  summary.initialized = !first_is_initial;
  return second;
}

Summary Optimizer::optimize(PoseGraph& graph) {
  check(graph);
  equations_.set(graph);
  const std::size_t edges = graph.edges.size();
  chi2_.assign(edges, 0.0);
  weight_.assign(edges, 1.0);
  any_robust_ =
      options_.robust != Robust::none &&
      std::any_of(graph.edges.begin(), graph.edges.end(), [](auto& e) { return e.robust; });

  Summary summary;
  summary.initial_chi2 = equations_.weighted_chi2(graph.poses);
  Descent d;
  if (options_.start == Start::best) {
    d = run_best(graph, summary);
  } else {
    summary.initialized = options_.start == Start::initialized;
    d = run(graph, summary.initialized ? initial_poses(graph) : graph.poses, summary.initialized);
    summary.iterations = iterations_;
  }
  graph.poses = std::move(d.poses);
  summary.converged = d.converged;
  summary.final_cost = evaluate(graph, graph.poses, final_kernel());
  for (std::size_t k = 0; k < edges; ++k) summary.final_chi2 += weight_[k] * chi2_[k];
  summary.edge_chi2 = chi2_;
  summary.edge_weight = weight_;
  return summary;
}

Summary optimize(PoseGraph& graph, const OptimizeOptions& options) {
  return Optimizer(options).optimize(graph);
}

}  // namespace majak::graph
