// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/joint_refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "majak/graph/optimize.hpp"
#include "majak/map/surfel_map.hpp"

namespace majak::slam {
namespace {

map::SurfelMapOptions target_options(double gate) {
  map::SurfelMapOptions o;
  o.cell = 0.10;  // pairs slide along the surface by less than this, which costs nothing
  o.reach = gate + 0.05;
  o.merge_radius = 0.04;
  return o;
}

// Partners of every key scan: the ones just before it, and the nearest of other visits.
std::vector<std::vector<std::size_t>> partners(const KeyScans& keys, const JointRefinementOptions& options) {
  std::vector<std::vector<std::size_t>> result(keys.size());
  std::unordered_map<long, std::vector<std::size_t>> cells;
  const auto cell = [&](double v) { return static_cast<long>(std::floor(v / options.reach)); };
  const auto hash = [](long x, long y) { return x * 1000003L + y; };
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Pose2& p = keys[i].T_map_robot;
    for (std::size_t step = 1, n = 0; static_cast<int>(n) < options.near_in_time && step <= i; step *= 2, ++n)
      result[i].push_back(i - step);
    std::vector<std::pair<double, std::size_t>> ranked;
    for (long dx = -1; dx <= 1; ++dx)
      for (long dy = -1; dy <= 1; ++dy) {
        const auto found = cells.find(hash(cell(p.x) + dx, cell(p.y) + dy));
        if (found == cells.end()) continue;
        for (const std::size_t j : found->second) {
          if (i - j < 12) continue;
          const Pose2 d = between(keys[j].T_map_robot, p);
          const double far = std::hypot(d.x, d.y);
          if (far > options.reach) continue;
          ranked.push_back({far + std::abs(d.theta), j});
        }
      }
    std::sort(ranked.begin(), ranked.end());
    std::vector<std::size_t> chosen;
    for (const auto& [cost, j] : ranked) {
      if (static_cast<int>(chosen.size()) == options.near_in_space) break;
      const auto same = [j = j](std::size_t c) { return c + 5 > j && j + 5 > c; };
      if (std::none_of(chosen.begin(), chosen.end(), same)) chosen.push_back(j);
    }
    result[i].insert(result[i].end(), chosen.begin(), chosen.end());
    cells[hash(cell(p.x), cell(p.y))].push_back(i);
  }
  return result;
}

struct PairSum {
  Mat3 h = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  double cost = 0, weight = 0;
  int inliers = 0;
};

// Returns of `source` on the surfaces of `target`; derivatives by the source's pose, right-handed:
// T_target_source * exp(delta).
PairSum pair_up(const match::ScanPoints& source, const map::SurfelMap& target, const Pose2& T, double gate, double cauchy) {
  PairSum sum;
  const auto c = static_cast<float>(std::cos(T.theta)), s = static_cast<float>(std::sin(T.theta));
  const auto px = static_cast<float>(T.x), py = static_cast<float>(T.y);
  const auto gate2 = static_cast<float>(gate * gate), inv = static_cast<float>(1.0 / (cauchy * cauchy));
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

}  // namespace

JointRefinement refine_jointly(KeyScans& keys, const JointRefinementOptions& options, Threads threads) {
  JointRefinement result;
  const double inv_sigma2 = 1.0 / (options.sigma * options.sigma);
  const auto pairs = partners(keys, options);
  std::vector<std::vector<std::size_t>> sources(keys.size());  // by target
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (const std::size_t j : pairs[i]) sources[j].push_back(i);
  for (int round = 0; round < options.rounds; ++round) {
    const double gate = round == 0 ? options.gate : 0.5 * options.gate;
    std::vector<std::vector<graph::Edge>> edges(keys.size());
    std::vector<PairSum> sums(keys.size());
    constexpr std::size_t kChunk = 32;
    parallel_for(threads, (keys.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
      map::SurfelMap target(target_options(options.gate));
      for (std::size_t j = chunk * kChunk; j < std::min(keys.size(), (chunk + 1) * kChunk); ++j) {
      if (sources[j].empty()) continue;
      target.clear();
      match::add_to(target, keys[j].points, {});
      for (const std::size_t i : sources[j]) {
        const Pose2 T = between(keys[j].T_map_robot, keys[i].T_map_robot);
        const PairSum sum = pair_up(keys[i].points, target, T, gate, options.cauchy);
        if (sum.inliers < 20) continue;
        const Mat3 h = inv_sigma2 * sum.h;
        const Vec3 step = -(h + 1e-1 * Mat3::Identity()).llt().solve(inv_sigma2 * sum.b);
        edges[j].push_back({static_cast<int>(j), static_cast<int>(i), T * exp(step), h, false});
        sums[j].cost += sum.cost, sums[j].weight += sum.weight;
      }
      }
    });
    graph::PoseGraph graph;
    result.edges.clear();
    double cost = 0, weight = 0;
    for (std::size_t k = 0; k < keys.size(); ++k) {
      graph.poses.push_back(keys[k].T_map_robot);
      graph.edges.insert(graph.edges.end(), edges[k].begin(), edges[k].end());
      if (k > 0)
        graph.edges.push_back({static_cast<int>(k) - 1, static_cast<int>(k), between(keys[k - 1].T_front_robot, keys[k].T_front_robot), options.prior * keys[k].step_information, false});
      cost += sums[k].cost, weight += sums[k].weight;
    }
    graph::optimize(graph, {.max_iterations = 3, .relative_tolerance = 1e-5, .start = graph::Start::given, .robust = graph::Robust::none});
    for (std::size_t k = 0; k < keys.size(); ++k) keys[k].T_map_robot = graph.poses[k];
    result.rms.push_back(weight > 0 ? std::sqrt(cost / weight) : 0);
    result.edges = std::move(graph.edges);
  }
  return result;
}

}  // namespace majak::slam
