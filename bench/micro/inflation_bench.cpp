// SPDX-License-Identifier: Apache-2.0
// Inflation of obstacles, and the distances to them, on 4000 x 4000 cells of 5 cm.
#include <benchmark/benchmark.h>

#include <vector>

#include "majak/core/random.hpp"
#include "majak/map/distance_transform.hpp"
#include "majak/map/inflation.hpp"

namespace {

using namespace majak;

constexpr int kSide = 4000;

/// Rooms of 10 m with doors, and clutter.
map::KnownMap rooms() {
  map::KnownMap map;
  map.width = map.height = kSide;
  map.cells.assign(map.index(0, kSide), map::CellState::free);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if ((x % 200 < 3 && y % 200 > 30) || (y % 200 < 3 && x % 200 > 30))
        map.cells[map.index(x, y)] = map::CellState::occupied;
  RandomStream random(1);
  for (int k = 0; k < 100'000; ++k)
    map.cells[random.below(map.cells.size())] = map::CellState::occupied;
  return map;
}

map::CellMask obstacles_of(const map::KnownMap& map) {
  map::CellMask mask{map.width, map.height, {}};
  for (const map::CellState state : map.cells)
    mask.cells.push_back(state == map::CellState::occupied);
  return mask;
}

/// Ranges: threads.
void distances(benchmark::State& state) {
  const map::CellMask mask = obstacles_of(rooms());
  const Threads threads{static_cast<int>(state.range(0))};
  for (auto _ : state) benchmark::DoNotOptimize(map::squared_distances(mask, threads));
}
BENCHMARK(distances)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

/// Ranges: threads; radius, cm; meaning.
void disc(benchmark::State& state) {
  const map::KnownMap map = rooms();
  const Threads threads{static_cast<int>(state.range(0))};
  const map::Disc robot{0.01 * static_cast<double>(state.range(1))};
  const auto meaning = static_cast<map::InflationMeaning>(state.range(2));
  for (auto _ : state)
    benchmark::DoNotOptimize(map::inflate(map, robot, {.meaning = meaning}, threads));
}
BENCHMARK(disc)
    ->ArgsProduct({{1, 2}, {30, 300}, {0, 1}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

/// A robot of 0.9 m x 0.6 m, askew. Ranges: threads; meaning.
void rectangle(benchmark::State& state) {
  const map::KnownMap map = rooms();
  const Threads threads{static_cast<int>(state.range(0))};
  const map::Polygon robot{{{0.6, 0.3}, {-0.3, 0.3}, {-0.3, -0.3}, {0.6, -0.3}}, 0.5};
  const auto meaning = static_cast<map::InflationMeaning>(state.range(1));
  for (auto _ : state)
    benchmark::DoNotOptimize(map::inflate(map, robot, {.meaning = meaning}, threads));
}
BENCHMARK(rectangle)->ArgsProduct({{1, 2}, {0, 1}})->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
