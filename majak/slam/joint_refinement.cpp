// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/joint_refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "majak/graph/optimize.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/slam/chain.hpp"
#include "majak/slam/range_bias.hpp"

namespace majak::slam {
namespace {

constexpr int kLeastInliers = 20;
// All pairs share the laser's systematic error, so that a hundred of them tell of a direction which
// it shifts no more than one. Counted as if each had an error of its own, they bent corridors that
// were driven both ways.
constexpr double kAsOne = 100;

map::SurfelMapOptions target_options(double gate) {
  map::SurfelMapOptions o;
  o.cell = 0.10;  // pairs slide along the surface by less than this, which costs nothing
  o.reach = gate + 0.05;
  o.merge_radius = 0.04;
  return o;
}

struct PairSum {
  Mat3 h = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double cost = 0, weight = 0;
  int inliers = 0;
};

// Returns of `source` on the surfaces of `target`; derivatives by the source's pose, right-handed:
// T_target_source * exp(delta).
PairSum pair_up(const match::ScanPoints& source, const map::SurfelMap& target, const Pose2& T,
                double gate, double cauchy) {
  PairSum sum;
  const auto c = static_cast<float>(std::cos(T.theta)), s = static_cast<float>(std::sin(T.theta));
  const auto px = static_cast<float>(T.x), py = static_cast<float>(T.y);
  const auto gate2 = static_cast<float>(gate * gate),
             inv = static_cast<float>(1.0 / (cauchy * cauchy));
  for (std::size_t i = 0; i < source.size(); ++i) {
    const float x = source.x[i], y = source.y[i];
    const float mx = c * x - s * y + px, my = s * x + c * y + py;
    const std::uint32_t found = target.nearest(mx, my);
    if (found == map::SurfelMap::kNone) continue;
    const map::Surfel& f = target.surfel(found);
    const float dx = mx - f.x, dy = my - f.y, d2 = dx * dx + dy * dy;
    if (d2 > gate2) continue;
    if (f.nx == 0 && f.ny == 0) continue;
    // the source's own normal must agree
    const float sx = c * source.nx[i] - s * source.ny[i], sy = s * source.nx[i] + c * source.ny[i];
    if (sx * f.nx + sy * f.ny < 0.7F) continue;
    const float r = f.nx * dx + f.ny * dy;
    const float w = 1.0F / (1.0F + r * r * inv);
    const float nx = c * f.nx + s * f.ny, ny = -s * f.nx + c * f.ny;  // normal in the source's axes
    const Vec3 j(nx, ny, ny * x - nx * y);
    sum.h += w * j * j.transpose();
    sum.b += w * r * j;
    sum.cost += w * r * r;
    sum.weight += w;
    ++sum.inliers;
  }
  return sum;
}

// The edge that all paired returns of two key scans make together: one Gauss-Newton step from where
// they stand. Nothing where too few meet.
std::optional<graph::Edge> pair_edge(std::size_t j, std::size_t i, const PairSum& sum,
                                     const Pose2& T_j_i, double sigma) {
  if (sum.inliers < kLeastInliers) return std::nullopt;
  const Mat3 s = match::without_normal_noise(sum.h);
  const Mat3 h = s * sum.h * s / (sigma * sigma);
  const Vec3 step = -(h + 1e-1 * Mat3::Identity()).llt().solve(s * (s * sum.b) / (sigma * sigma));
  return graph::Edge{static_cast<int>(j), static_cast<int>(i), T_j_i * exp(step),
                     0.5 * (h + h.transpose()), false};
}

Mat3 with_common_error(const Mat3& information, const RangeBias::Columns& shift) {
  const Mat3 covariance = kAsOne * shift * shift.transpose();
  const Mat3 left = (Mat3::Identity() + information * covariance).inverse() * information;
  return 0.5 * (left + left.transpose());
}

// Edges of one round, by target, and what they met.
struct Round {
  std::vector<std::vector<graph::Edge>> edges;
  std::vector<double> cost, weight;

  double rms() const {
    const double w = std::accumulate(weight.begin(), weight.end(), 0.0);
    return w > 0 ? std::sqrt(std::accumulate(cost.begin(), cost.end(), 0.0) / w) : 0;
  }
};

Round pair_all(const KeyScans& keys, const std::vector<std::vector<std::size_t>>& sources,
               double gate, const JointRefinementOptions& options, Threads threads) {
  Round round{std::vector<std::vector<graph::Edge>>(keys.size()),
              std::vector<double>(keys.size(), 0), std::vector<double>(keys.size(), 0)};
  std::vector<LaserView> views;
  for (const KeyScan& key : keys) views.push_back(laser_view(key));
  constexpr std::size_t kChunk = 32;
  parallel_for(threads, (keys.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    map::SurfelMap target(target_options(options.gate));
    for (std::size_t j = chunk * kChunk; j < std::min(keys.size(), (chunk + 1) * kChunk); ++j) {
      if (sources[j].empty()) continue;
      target.clear();
      match::add_to(target, keys[j].points, {});
      for (const std::size_t i : sources[j]) {
        const Pose2 T_j_i = between(keys[j].T_map_robot, keys[i].T_map_robot);
        const PairSum sum = pair_up(keys[i].points, target, T_j_i, gate, options.cauchy);
        auto edge = pair_edge(j, i, sum, T_j_i, options.sigma);
        if (!edge) continue;
        edge->information = with_common_error(edge->information,
                                              RangeBias::shift(keys[j], views[j], keys[i], gate));
        round.edges[j].push_back(*edge);
        round.cost[j] += sum.cost, round.weight[j] += sum.weight;
      }
    }
  });
  return round;
}

}  // namespace

JointRefinement refine_jointly(KeyScans& keys,
                               const std::vector<std::vector<std::size_t>>& partners,
                               const std::vector<graph::Edge>& closures,
                               const JointRefinementOptions& options, Threads threads) {
  JointRefinement result;
  std::vector<std::vector<std::size_t>> sources(
      keys.size());  // by target, so that its map is made once
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (const std::size_t j : partners[i]) sources[j].push_back(i);
  for (int n = 0; n < options.rounds; ++n) {
    const Round round =
        pair_all(keys, sources, n == 0 ? options.gate : 0.5 * options.gate, options, threads);
    result.chain = chain_graph(keys);
    graph::PoseGraph& graph = result.chain.graph;
    result.pairs.clear();
    for (const auto& edges : round.edges)
      result.pairs.insert(result.pairs.end(), edges.begin(), edges.end());
    graph.edges.insert(graph.edges.end(), result.pairs.begin(), result.pairs.end());
    graph.edges.insert(graph.edges.end(), closures.begin(), closures.end());
    graph::optimize(graph, {.max_iterations = 3,
                            .relative_tolerance = 1e-5,
                            .start = graph::Start::given,
                            .robust = graph::Robust::cauchy});
    for (std::size_t k = 0; k < keys.size(); ++k) keys[k].T_map_robot = graph.poses[k];
    result.rms.push_back(round.rms());
  }
  return result;
}

}  // namespace majak::slam
