// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/revisits.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace majak::slam {
namespace {

constexpr std::size_t kSameVisit = 20;  // key scans; nearer ones made the local map anyway
constexpr std::size_t kSameStop = 5;    // key scans; so near to each other they tell the same

// Key scans by square of the ground.
class Ground {
 public:
  explicit Ground(double size) : size_(size) {}
  void add(const Pose2& pose, std::size_t key) {
    squares_[square(index(pose.x), index(pose.y))].push_back(key);
  }

  template <class Visit>
  void around(const Pose2& pose, const Visit& visit) const {
    for (std::int64_t dx = -1; dx <= 1; ++dx)
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto found = squares_.find(square(index(pose.x) + dx, index(pose.y) + dy));
        if (found == squares_.end()) continue;
        for (const std::size_t key : found->second) visit(key);
      }
  }

 private:
  std::int64_t index(double v) const { return static_cast<std::int64_t>(std::floor(v / size_)); }
  static std::int64_t square(std::int64_t x, std::int64_t y) { return x * 0x40000000 + y; }

  double size_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> squares_;
};

// The nearest first, one of each stop.
std::vector<std::size_t> choose(std::vector<std::pair<double, std::size_t>>& ranked, int count) {
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::size_t> chosen;
  for (const auto& [far, j] : ranked) {
    if (static_cast<int>(chosen.size()) == count) break;
    const auto same = [j = j](std::size_t c) { return c + kSameStop > j && j + kSameStop > c; };
    if (std::none_of(chosen.begin(), chosen.end(), same)) chosen.push_back(j);
  }
  return chosen;
}

}  // namespace

std::vector<std::vector<std::size_t>> revisits(const KeyScans& keys, const LoopCloser& loops,
                                               const RevisitOptions& options) {
  std::vector<std::vector<std::size_t>> result(keys.size());
  if (loops.ways().size() == 0) return result;
  Ground ground(options.reach);
  std::vector<double> ways;
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::size_t submap = loops.submap_of(i);
    if (i == 0 || submap != loops.submap_of(i - 1)) ways = loops.ways().from(submap);
    const Pose2& T_map_robot = keys[i].T_map_robot;
    ranked.clear();
    ground.around(T_map_robot, [&](std::size_t j) {
      if (i - j < kSameVisit || ways[loops.submap_of(j)] > options.known_way) return;
      const Pose2 d = between(keys[j].T_map_robot, T_map_robot);
      const double far = std::hypot(d.x, d.y);
      if (far <= options.reach) ranked.push_back({far + std::abs(d.theta), j});
    });
    result[i] = choose(ranked, options.count);
    ground.add(T_map_robot, i);
  }
  return result;
}

}  // namespace majak::slam
