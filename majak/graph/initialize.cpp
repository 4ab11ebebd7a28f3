// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/initialize.hpp"

#include <deque>
#include <numeric>

namespace majak::graph {
namespace {

struct Incidence {
  std::vector<int> begin, edges;
};

Incidence incidence(const PoseGraph& graph) {
  Incidence in;
  in.begin.assign(graph.poses.size() + 1, 0);
  for (const Edge& e : graph.edges) ++in.begin[e.from + 1], ++in.begin[e.to + 1];
  std::partial_sum(in.begin.begin(), in.begin.end(), in.begin.begin());
  in.edges.resize(2 * graph.edges.size());
  std::vector<int> next(in.begin.begin(), in.begin.end() - 1);
  for (std::size_t k = 0; k < graph.edges.size(); ++k)
    for (const int i : {graph.edges[k].from, graph.edges[k].to})
      in.edges[next[i]++] = static_cast<int>(k);
  return in;
}

}  // namespace

std::vector<Pose2> spanning_tree(const PoseGraph& graph) {
  std::vector<Pose2> poses = graph.poses;
  std::vector<bool> reached(poses.size(), false);
  const Incidence in = incidence(graph);
  std::deque<int> trusted, doubted;  // poses to walk on from, over trusted edges first
  for (const int a : anchors(graph)) {
    reached[a] = true;
    trusted.push_back(a);
  }
  while (!trusted.empty() || !doubted.empty()) {
    const bool robust = trusted.empty();
    std::deque<int>& queue = robust ? doubted : trusted;
    const int i = queue.front();
    queue.pop_front();
    if (!robust) doubted.push_back(i);
    for (int k = in.begin[i]; k < in.begin[i + 1]; ++k) {
      const Edge& e = graph.edges[in.edges[k]];
      const int other = e.from == i ? e.to : e.from;
      if (e.robust != robust || reached[other]) continue;
      poses[other] = poses[i] * (e.from == i ? e.T_from_to : e.T_from_to.inverse());
      reached[other] = true;
      trusted.push_back(other);
    }
  }
  return poses;
}

std::vector<Pose2> initialize(const PoseGraph& graph, NormalEquations& equations,
                              std::span<const double> weights) {
  std::vector<Pose2> poses = graph.poses;
  std::vector<double> z;
  equations.build_rotations(poses, weights);
  if (!equations.solve(0, z)) return spanning_tree(graph);
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (!equations.is_anchor(static_cast<int>(i)))
      poses[i].theta = std::atan2(z[3 * i + 1], z[3 * i]);

  equations.linearize_positions(poses, weights);
  if (!equations.solve(0, z)) return spanning_tree(graph);
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i] = from_vector(poses[i].vector() + Vec3(z[3 * i], z[3 * i + 1], z[3 * i + 2]));
  return poses;
}

std::vector<Pose2> initialize(const PoseGraph& graph) {
  check(graph);
  NormalEquations equations;
  equations.set(graph);
  return initialize(graph, equations);
}

}  // namespace majak::graph
