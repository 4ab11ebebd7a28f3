// SPDX-License-Identifier: Apache-2.0
// Fixes by three beacons, each from another place of a 20 x 20 m field: items a second on a core.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <vector>

#include "majak/beacon/triangulation.hpp"
#include "majak/beacon/trilateration.hpp"
#include "majak/core/random.hpp"

namespace {

using namespace majak;

constexpr std::size_t kPlaces = 1024;
const std::array<Vec2, 3> kBeacons = {Vec2(0, 0), Vec2(20, 2), Vec2(8, 19)};

template <class Measurement, class Measure>
std::vector<std::array<Measurement, 3>> measurements(const Measure& measure) {
  RandomStream random(1);
  std::vector<std::array<Measurement, 3>> all(kPlaces);
  for (auto& fix : all) {
    const Vec2 p(random.uniform(0, 20), random.uniform(0, 20));
    for (std::size_t i = 0; i < 3; ++i) fix[i] = measure(kBeacons[i], p, random.normal());
  }
  return all;
}

void trilaterate_three(benchmark::State& state) {
  const auto all = measurements<beacon::RangeTo>([](const Vec2& b, const Vec2& p, double noise) {
    return beacon::RangeTo{b, std::abs((b - p).norm() + 0.05 * noise), 0.05};
  });
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(beacon::trilaterate(all[i++ % kPlaces]));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(trilaterate_three);

void triangulate_three(benchmark::State& state) {
  const auto all = measurements<beacon::BearingTo>([](const Vec2& b, const Vec2& p, double noise) {
    return beacon::BearingTo{b, std::atan2(b.y() - p.y(), b.x() - p.x()) - 1 + 0.005 * noise,
                             0.005};
  });
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(beacon::triangulate(all[i++ % kPlaces]));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(triangulate_three);

}  // namespace

BENCHMARK_MAIN();
