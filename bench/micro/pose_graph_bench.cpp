// SPDX-License-Identifier: Apache-2.0
// The pose graph against Ceres with analytic derivatives, on the same graph from the same start.
//
//   cmake -S . -B build-bench -G Ninja -DMAJAK_BENCHMARKS=ON && ninja -C build-bench
//   bench_pose_graph MAJAK_DATA=... build-bench/bench_pose_graph
//
// Counters: chi2 reached, linear solves. Both stop at a relative change of 1e-7.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "majak/core/error.hpp"
#include "majak/graph/initialize.hpp"
#include "majak/graph/marginals.hpp"
#include "majak/graph/optimize.hpp"
#include "majak/io/g2o.hpp"
#include "tests/support/data_folder.hpp"
#ifdef MAJAK_HAVE_CERES
#include "../../tests/unit/graph/ceres_twin.hpp"
#endif

namespace {

using namespace majak;
using graph::PoseGraph;

/// A known graph, read once; empty if the data folder does not hold it.
const PoseGraph& known_graph(const std::string& name) {
  static std::map<std::string, PoseGraph> graphs;
  const auto [it, is_new] = graphs.try_emplace(name);
  if (is_new) {
    Report report;
    try {
      it->second = io::read_g2o(data_folder() / "posegraph" / (name + ".g2o.gz"), report).graph;
    } catch (const Error&) {
    }
  }
  return it->second;
}

const PoseGraph* graph_or_skip(benchmark::State& state, const std::string& name) {
  const PoseGraph& g = known_graph(name);
  if (!g.poses.empty()) return &g;
  state.SkipWithError("the graph is not in the data folder (set MAJAK_DATA)");
  return nullptr;
}

void ours(benchmark::State& state, const std::string& name, graph::Start start) {
  const PoseGraph* g = graph_or_skip(state, name);
  graph::Summary summary;
  for (auto _ : state) {
    if (!g) break;
    PoseGraph copy = *g;
    summary = graph::optimize(copy, {.start = start});
  }
  state.counters["chi2"] = summary.final_chi2;
  state.counters["solves"] = summary.iterations;
}

#ifdef MAJAK_HAVE_CERES
/// Ceres at the best of what was tried: both sparse libraries, LM and dogleg, one and two threads.
/// A trust region that starts wide lets it take Gauss-Newton steps from the first on.
void theirs(benchmark::State& state, const std::string& name,
            ceres::SparseLinearAlgebraLibraryType library,
            ceres::TrustRegionStrategyType strategy) {
  const PoseGraph* g = graph_or_skip(state, name);
  ceres::Solver::Summary summary;
  for (auto _ : state) {
    if (!g) break;
    graph::CeresPoses poses = graph::ceres_poses(*g);
    ceres::Problem::Options problem_options;
    problem_options.disable_all_safety_checks = true;
    ceres::Problem problem(problem_options);
    graph::add_to_ceres(*g, poses, problem);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.sparse_linear_algebra_library_type = library;
    options.trust_region_strategy_type = strategy;
    options.initial_trust_region_radius = 1e16;
    options.max_trust_region_radius = 1e32;
    options.jacobi_scaling = false;
    options.function_tolerance = 1e-7;
    options.max_num_iterations = 100;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solve(options, &problem, &summary);
  }
  state.counters["chi2"] = 2 * summary.final_cost;
  state.counters["solves"] = summary.num_linear_solves;
}
#endif

/// A front end's use: the graph grows, every `stride` closures it is optimised again.
void incremental(benchmark::State& state, const std::string& name, int stride) {
  const PoseGraph* g = graph_or_skip(state, name);
  std::vector<graph::Edge> edges = g ? g->edges : std::vector<graph::Edge>();
  std::stable_sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) {
    return std::max(a.from, a.to) < std::max(b.from, b.to);
  });
  int calls = 0;
  double chi2 = 0;
  for (auto _ : state) {
    if (!g) break;
    calls = 0;
    int closures = 0;
    graph::Optimizer optimizer({.start = graph::Start::given});
    PoseGraph growing{.poses = {g->poses[0]}, .edges = {}};
    for (const graph::Edge& e : edges) {
      growing.edges.push_back(e);
      if (std::max(e.from, e.to) == static_cast<int>(growing.poses.size())) {
        growing.poses.push_back(growing.poses[e.from] * e.T_from_to);
      } else if (++closures % stride == 0) {
        chi2 = optimizer.optimize(growing).final_chi2;
        ++calls;
      }
    }
  }
  state.counters["chi2"] = chi2;
  state.counters["calls"] = calls;
}

void marginals(benchmark::State& state, const std::string& name) {
  const PoseGraph* g = graph_or_skip(state, name);
  PoseGraph best = g ? *g : PoseGraph();
  if (g) graph::optimize(best);
  for (auto _ : state) {
    if (!g) break;
    benchmark::DoNotOptimize(graph::Marginals(best).covariance(1));
  }
}

const auto kMs = benchmark::kMillisecond;

BENCHMARK_CAPTURE(ours, city10000_default, "city10000", graph::Start::best)->Unit(kMs);
BENCHMARK_CAPTURE(ours, city10000_from_file, "city10000", graph::Start::given)->Unit(kMs);
#ifdef MAJAK_HAVE_CERES
BENCHMARK_CAPTURE(theirs, city10000_suitesparse_lm, "city10000", ceres::SUITE_SPARSE,
                  ceres::LEVENBERG_MARQUARDT)
    ->Unit(kMs);
BENCHMARK_CAPTURE(theirs, city10000_suitesparse_dogleg, "city10000", ceres::SUITE_SPARSE,
                  ceres::DOGLEG)
    ->Unit(kMs);
BENCHMARK_CAPTURE(theirs, city10000_eigen_lm, "city10000", ceres::EIGEN_SPARSE,
                  ceres::LEVENBERG_MARQUARDT)
    ->Unit(kMs);
BENCHMARK_CAPTURE(theirs, city10000_eigen_dogleg, "city10000", ceres::EIGEN_SPARSE, ceres::DOGLEG)
    ->Unit(kMs);
#endif
BENCHMARK_CAPTURE(ours, intel_default, "intel", graph::Start::best)->Unit(kMs);
BENCHMARK_CAPTURE(ours, MIT_default, "MIT", graph::Start::best)->Unit(kMs);
BENCHMARK_CAPTURE(ours, manhattan_default, "manhattan", graph::Start::best)->Unit(kMs);
#ifdef MAJAK_HAVE_CERES
BENCHMARK_CAPTURE(theirs, intel_suitesparse_lm, "intel", ceres::SUITE_SPARSE,
                  ceres::LEVENBERG_MARQUARDT)
    ->Unit(kMs);
#endif
BENCHMARK_CAPTURE(incremental, intel_every_5th_closure, "intel", 5)->Unit(kMs);
BENCHMARK_CAPTURE(marginals, intel, "intel")->Unit(kMs);
BENCHMARK_CAPTURE(marginals, city10000, "city10000")->Unit(kMs);

}  // namespace

BENCHMARK_MAIN();
