// SPDX-License-Identifier: Apache-2.0
// The weights of 5000 particles by 180 beams on the likelihood field of a simulated building.
#include <benchmark/benchmark.h>

#include <numeric>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/match/likelihood_field.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"

namespace {

using namespace majak;

map::KnownMap hall(int side, double resolution) {
  map::KnownMap map;
  map.resolution = resolution;
  map.width = map.height = side;
  map.cells.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side),
                   map::CellState::free);
  RandomStream random(1);
  for (int k = 0; k < side * side / 50; ++k)
    map.cells[random.below(map.cells.size())] = map::CellState::occupied;
  return map;
}

/// Range: side of the map in cells of 5 cm.
void likelihood_of_particles(benchmark::State& state) {
  const map::KnownMap map = hall(static_cast<int>(state.range(0)), 0.05);
  const match::LikelihoodField field(map, map::DistanceField(map), {});
  RandomStream random(2);
  const double width = map.width * map.resolution;
  match::Beams beams;
  for (int i = 0; i < 180; ++i) {
    const double angle = radians(i - 90), range = random.uniform(1, 12);
    beams.x.push_back(static_cast<float>(range * std::cos(angle)));
    beams.y.push_back(static_cast<float>(range * std::sin(angle)));
  }
  beams.returns = 180;
  match::PoseArrays poses;
  poses.resize(5000);
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses.set(i, {random.uniform(0, width), random.uniform(0, width), random.uniform(-kPi, kPi)});
  std::vector<std::uint32_t> costs(poses.size());
  for (auto _ : state) {
    field.costs(beams, poses, 0, poses.size(), costs.data());
    benchmark::DoNotOptimize(costs.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * 180 * 5000);
}
BENCHMARK(likelihood_of_particles)
    ->Arg(40)
    ->Arg(400)
    ->Arg(800)
    ->Arg(2000)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
