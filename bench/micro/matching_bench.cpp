// SPDX-License-Identifier: Apache-2.0
// Matching: points and normals of a scan, merging them into a map, one alignment, one window
// search; and drawing the grid. On a simulated building.
#include <benchmark/benchmark.h>

#include <vector>

#include "majak/map/occupancy_grid.hpp"
#include "majak/match/correlative.hpp"
#include "majak/match/point_to_line.hpp"
#include "majak/match/scan_points.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"

namespace {

using namespace majak;

/// Forty neighbouring scans with their true poses.
const std::vector<PosedScan>& scans() {
  static const std::vector<PosedScan> result = [] {
    const sim::World world(sim::built_in("building"));
    std::vector<PosedScan> posed;
    for (Event& event : sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), {})) {
      if (auto* scan = std::get_if<Scan>(&event)) {
        posed.push_back({});
        posed.back().scan = std::move(*scan);
      } else if (const auto* truth = std::get_if<Truth>(&event)) {
        for (PosedScan& p : posed)
          if (p.scan.time == truth->time) p.estimate.T_map_robot = truth->T_world_robot;
      }
      if (posed.size() > 140) break;
    }
    return std::vector<PosedScan>(posed.begin() + 100, posed.begin() + 140);
  }();
  return result;
}

match::ScanPoints points_of(const PosedScan& posed, bool normals) {
  return match::scan_points(posed.scan, {}, normals);
}

map::SurfelMap local_map() {
  map::SurfelMap map;
  for (const PosedScan& p : scans()) match::add_to(map, points_of(p, true), p.estimate.T_map_robot);
  return map;
}

void points_with_normals(benchmark::State& state) {
  match::BeamDirections directions;
  for (auto _ : state)
    benchmark::DoNotOptimize(match::scan_points(scans()[0].scan, {}, true, directions));
}
BENCHMARK(points_with_normals);

void merge_into_map(benchmark::State& state) {
  map::SurfelMap map = local_map();
  const auto points = points_of(scans()[20], true);
  for (auto _ : state) match::add_to(map, points, scans()[20].estimate.T_map_robot);
}
BENCHMARK(merge_into_map);

void align_5cm_off(benchmark::State& state) {
  const map::SurfelMap map = local_map();
  const auto points = points_of(scans()[20], false);
  match::PosePrior prior{scans()[20].estimate.T_map_robot * Pose2{0.05, -0.02, 0.02}, Mat3::Zero()};
  prior.information.diagonal() << 100, 100, 100;
  for (auto _ : state) benchmark::DoNotOptimize(match::align(points, map, prior, {}));
}
BENCHMARK(align_5cm_off);

void search_window(benchmark::State& state) {
  const map::SurfelMap map = local_map();
  const auto points = points_of(scans()[20], false);
  const Pose2 guess = scans()[20].estimate.T_map_robot * Pose2{0.5, -0.4, 0.3};
  for (auto _ : state) {
    const match::LikelihoodPyramid pyramid(map, guess.translation(), {.max_translation = 1.0});
    benchmark::DoNotOptimize(match::search(points, pyramid, guess, {1.0, 0.5}, 0.5));
  }
}
BENCHMARK(search_window);

void draw_grid(benchmark::State& state) {
  Site site;
  site.scans = scans();
  for (auto _ : state) benchmark::DoNotOptimize(map::build_occupancy_grid(site, {}, {1}));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scans().size()) * 181);
}
BENCHMARK(draw_grid);

}  // namespace

BENCHMARK_MAIN();
