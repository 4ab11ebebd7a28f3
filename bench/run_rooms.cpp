// SPDX-License-Identifier: Apache-2.0
// Rooms and doors of generated buildings against the truth.
//   run_rooms [--slam] [--pictures FOLDER] [SEED | FIRST-LAST]...     default 1-10
// --slam: the whole way from the simulated log on; else scans are drawn where they truly were
// taken.
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/picture.hpp"
#include "majak/core/rigid_fit.hpp"
#include "majak/draw/topology_figure.hpp"
#include "majak/eval/rooms.hpp"
#include "majak/map/occupancy_grid.hpp"
#include "majak/sim/surveyed_site.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak {
namespace {

struct Run {
  bool slam = false;
  std::string pictures;
  std::vector<std::uint64_t> seeds;
};

Run parse(int argc, char** argv) {
  Run run;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    if (a == "--slam") {
      run.slam = true;
    } else if (a == "--pictures" && i + 1 < argc) {
      run.pictures = argv[++i];
    } else {
      const auto dash = a.find('-');
      const std::uint64_t first = std::stoull(a);
      const std::uint64_t last =
          dash == std::string::npos ? first : std::stoull(a.substr(dash + 1));
      for (auto seed = first; seed <= last; ++seed) run.seeds.push_back(seed);
    }
  }
  if (run.seeds.empty())
    for (std::uint64_t seed = 1; seed <= 10; ++seed) run.seeds.push_back(seed);
  return run;
}

Site mapped(const sim::World& world, const sim::Path& path) {
  slam::GraphSlam slam({}, {.count = 2});
  for (const Event& event : sim::simulate(world, path, {})) slam.add(event);
  return slam.finish().site;
}

/// Whole paths laid upon each other.
Pose2 world_from_map(const Site& site) {
  std::map<Time, Pose2> truth;
  for (const Truth& t : site.truth) truth[t.time] = t.T_world_robot;
  std::vector<Vec2> map, world;
  for (const PosedScan& s : site.scans) {
    map.push_back(s.estimate.T_map_robot.translation());
    world.push_back(truth.at(s.scan.time).translation());
  }
  return rigid_fit(map, world);
}

struct Sums {
  double overlap = 0, worst = 1;
  int buildings = 0, places = 0, doors = 0, found = 0, claimed = 0, invented = 0;
};

void score(std::uint64_t seed, const Run& run, Sums& sums) {
  const sim::GeneratedBuilding office = sim::generated_building(seed);
  const sim::World world(office.scene);
  const sim::Path path = sim::plan_tour(world);
  const Site site = run.slam ? mapped(world, path) : sim::surveyed_site(world, path);
  const map::KnownMap known = map::known_map(map::build_occupancy_grid(site, {}, {.count = 2}));
  const map::Topology topology = map::build_topology(known, {}, {.count = 2});
  const eval::RoomScore s = eval::score_rooms(topology, world_from_map(site), office);
  fmt::print("{:5} {:6} {:6}   {:.3f} {:.3f}   {:3} of {:3}   {:3} of {:3}", seed,
             office.places.size(), s.rooms, s.mean_overlap(),
             *std::min_element(s.overlap.begin(), s.overlap.end()), s.doors_found, s.true_doors,
             s.false_doors, s.doors);
  for (const Vec2& p : s.missed) fmt::print("  -({:.1f},{:.1f})", p.x(), p.y());
  for (const Vec2& p : s.invented) fmt::print("  +({:.1f},{:.1f})", p.x(), p.y());
  fmt::print("\n");
  std::fflush(stdout);
  sums.overlap += s.mean_overlap();
  sums.worst = std::min(sums.worst, s.mean_overlap());
  ++sums.buildings;
  sums.doors += s.true_doors, sums.found += s.doors_found;
  sums.claimed += s.doors, sums.invented += s.false_doors;
  if (!run.pictures.empty()) std::filesystem::create_directories(run.pictures);
  if (!run.pictures.empty())
    bench::write_picture(fmt::format("{}/office-{}", run.pictures, seed),
                         draw::topology_figure(known, topology, map::room_names(topology)));
}

void run_all(const Run& run) {
  fmt::print("{}\n seed places  rooms  IoU mean worst   doors found   false doors\n",
             run.slam ? "mapped by SLAM" : "drawn at the true poses");
  Sums sums;
  for (const std::uint64_t seed : run.seeds) score(seed, run, sums);
  fmt::print(
      "all: mean IoU {:.3f} (worst building {:.3f}), doors found {:.1f} % of {}, false {:.1f} % of "
      "{}\n",
      sums.overlap / sums.buildings, sums.worst, 100.0 * sums.found / std::max(1, sums.doors),
      sums.doors, 100.0 * sums.invented / std::max(1, sums.claimed), sums.claimed);
}

}  // namespace
}  // namespace majak

int main(int argc, char** argv) {
  try {
    majak::run_all(majak::parse(argc, argv));
  } catch (const std::exception& e) {
    fmt::print(stderr, "run_rooms: {}\n", e.what());
    return EXIT_FAILURE;
  }
}
