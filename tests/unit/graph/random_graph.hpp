// SPDX-License-Identifier: Apache-2.0
// Graphs for tests: a chain that turns a lot, loops across it, information that is not diagonal.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "majak/core/random.hpp"
#include "majak/graph/pose_graph.hpp"
#include "tests/support/data_folder.hpp"

namespace majak::graph {

inline Pose2 random_pose(RandomStream& random, double size = 5) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-kPi, kPi)};
}

inline Mat3 random_information(RandomStream& random) {
  Mat3 a;
  for (int k = 0; k < 9; ++k) a(k / 3, k % 3) = random.normal();
  return 20 * (a * a.transpose()) + 10 * Mat3::Identity();
}

struct RandomGraph {
  PoseGraph graph;  ///< poses: the truth, disturbed
  std::vector<Pose2> truth;
};

/// `poses` in a chain, `loops` more edges; the measurements err by `noise` (m, rad).
inline RandomGraph random_graph(std::uint64_t seed, int poses, int loops, double noise) {
  RandomStream random(seed);
  RandomGraph r;
  const auto disturb = [&](const Pose2& p, double size) {
    return p * exp(size * Vec3(random.normal(), random.normal(), random.normal()));
  };
  Pose2 at = random_pose(random);
  for (int i = 0; i < poses; ++i) {
    r.truth.push_back(at);
    at = at * Pose2{1, 0, random.uniform(-1.5, 1.5)};
  }
  const auto join = [&](int a, int b) {
    const Pose2 measured = disturb(between(r.truth[a], r.truth[b]), noise);
    r.graph.edges.push_back({a, b, measured, random_information(random), false});
  };
  for (int i = 1; i < poses; ++i) i % 3 == 0 ? join(i, i - 1) : join(i - 1, i);
  for (int k = 0; k < loops && poses > 1; ++k) {
    const int a = static_cast<int>(random.below(poses));
    join(a, (a + 1 + static_cast<int>(random.below(poses - 1))) % poses);
  }
  for (const Pose2& p : r.truth) r.graph.poses.push_back(disturb(p, 0.1));
  return r;
}

/// A file of the data folder; empty if it is not there.
inline std::filesystem::path data_file(const std::string& name) {
  const std::filesystem::path path = data_folder() / name;
  return std::filesystem::exists(path) ? path : std::filesystem::path();
}

}  // namespace majak::graph
