// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/split_maps.hpp"

#include <array>
#include <utility>

#include "majak/core/rigid_fit.hpp"

namespace majak::eval {
namespace {

struct Half {
  slam::LandmarkMap map;
  std::vector<int> place;  ///< by the whole map's number, where it is in this one; -1: it is not
};

Half half_of(const slam::LandmarkMap& whole, Duration block, int least, std::int64_t parity) {
  const auto& estimates = whole.localization.estimates;
  const Time begin = estimates[whole.observations.front().scan].time;
  const auto chosen = [&](const slam::LandmarkObservation& o) {
    return (estimates[o.scan].time - begin) / block % 2 == parity;
  };
  std::vector<int> count(whole.landmarks.size(), 0);
  for (const slam::LandmarkObservation& o : whole.observations)
    count[static_cast<std::size_t>(o.landmark)] += chosen(o);
  Half half{whole, std::vector<int>(whole.landmarks.size(), -1)};
  half.map.landmarks.clear(), half.map.observations.clear();
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] < least) continue;
    half.place[i] = static_cast<int>(half.map.landmarks.size());
    half.map.landmarks.push_back(whole.landmarks[i]);
  }
  for (slam::LandmarkObservation o : whole.observations) {
    const int place = half.place[static_cast<std::size_t>(o.landmark)];
    if (place < 0 || !chosen(o)) continue;
    o.landmark = place;
    half.map.observations.push_back(o);
  }
  return half;
}

}  // namespace

SplitHalf split_maps(const slam::LandmarkMap& map, const slam::EkfSlamOptions& ekf,
                     slam::LandmarkGraphOptions graph, const SplitHalfOptions& options) {
  SplitHalf split;
  if (map.observations.empty()) return split;
  graph.merge_distance = 0;  // or they would be numbered anew
  std::array<Half, 2> halves;
  for (const int parity : {0, 1}) {
    Half& half = halves[static_cast<std::size_t>(parity)];
    half = half_of(map, from_seconds(options.block), options.least, parity);
    half.map = slam::optimize_landmarks(std::move(half.map), ekf, graph);
  }
  std::vector<double> distances;
  const auto& [even, odd] = halves;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (even.place[i] < 0 || odd.place[i] < 0) continue;
    split.landmarks.push_back({static_cast<int>(i),
                               even.map.landmarks[static_cast<std::size_t>(even.place[i])].p_map,
                               odd.map.landmarks[static_cast<std::size_t>(odd.place[i])].p_map});
    distances.push_back(split.landmarks.back().distance());
  }
  split.error = error_stats(std::move(distances));
  return split;
}

SplitHalf aligned(SplitHalf split) {
  std::vector<Vec2> even, odd;
  for (const SplitHalf::Landmark& l : split.landmarks) even.push_back(l.even), odd.push_back(l.odd);
  if (even.empty()) return split;
  const Pose2 T_odd_even = rigid_fit(even, odd);
  std::vector<double> distances;
  for (SplitHalf::Landmark& l : split.landmarks) {
    l.even = T_odd_even * l.even;
    distances.push_back(l.distance());
  }
  split.error = error_stats(std::move(distances));
  return split;
}

}  // namespace majak::eval
