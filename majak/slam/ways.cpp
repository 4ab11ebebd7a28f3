// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/ways.hpp"

#include <functional>
#include <limits>
#include <queue>

namespace majak::slam {

void Ways::add_place(double way) {
  const std::size_t place = driven_.size();
  driven_.push_back(place == 0 ? 0 : driven_.back() + way);
  neighbours_.emplace_back();
  if (place > 0) add_short_cut(place - 1, place, way);
}

void Ways::add_short_cut(std::size_t a, std::size_t b, double way) {
  neighbours_[a].push_back({b, way});
  neighbours_[b].push_back({a, way});
}

std::vector<double> Ways::from(std::size_t place) const {
  std::vector<double> ways(size(), std::numeric_limits<double>::infinity());
  using Item = std::pair<double, std::size_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  queue.push({0.0, place});
  ways[place] = 0;
  while (!queue.empty()) {
    const auto [way, at] = queue.top();
    queue.pop();
    if (way > ways[at]) continue;
    for (const auto& [to, length] : neighbours_[at])
      if (way + length < ways[to]) queue.push({ways[to] = way + length, to});
  }
  return ways;
}

}  // namespace majak::slam
