// SPDX-License-Identifier: Apache-2.0
// A whole update of Monte Carlo localization: beams of the scan, motion, weights, clusters and
// resampling of 5000 particles by 180 beams in a simulated building.
#include <benchmark/benchmark.h>

#include <variant>
#include <vector>

#include "majak/core/normal_table.hpp"
#include "majak/localize/monte_carlo.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/known_map.hpp"
#include "majak/sim/simulator.hpp"

namespace {

using namespace majak;

void update(benchmark::State& state) {
  const sim::World world(sim::built_in("building"));
  const auto place = localize::place_of(sim::known_map(world, 0.05));
  const sim::Path path = sim::plan_tour(world, {.short_tour = true});
  std::vector<localize::FedScan> scans;
  localize::ScanFeed feed;
  for (const Event& event : sim::simulate(world, path, {})) {
    feed.add(event);
    while (auto scan = feed.next()) scans.push_back(std::move(*scan));
  }
  // Every scan is an update, and all particles stay.
  localize::MonteCarlo filter(
      place, {.least = 5000, .step = 0, .start_sigma = 0.3, .doubt = 10, .lost = 10}, path.start);
  std::size_t i = 0;
  for (auto _ : state) {
    if (i == scans.size()) {
      state.SkipWithError("the log has ended");
      break;
    }
    benchmark::DoNotOptimize(filter.add(scans[i++]));
  }
}
BENCHMARK(update)->Unit(benchmark::kMillisecond)->Iterations(400);

void normal(benchmark::State& state) {
  const NormalTable table;
  RandomStream random(1);
  for (auto _ : state) benchmark::DoNotOptimize(table(random));
}
BENCHMARK(normal);

void normal_by_box_and_muller(benchmark::State& state) {
  RandomStream random(1);
  for (auto _ : state) benchmark::DoNotOptimize(random.normal());
}
BENCHMARK(normal_by_box_and_muller);

}  // namespace

BENCHMARK_MAIN();
