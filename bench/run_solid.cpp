// SPDX-License-Identifier: Apache-2.0
// Solids, measured.
//   run_solid RUN [-o PREFIX] [NAME=VALUE ...]      walls raised from a run
//   run_solid rooms|yard [-o PREFIX] [--look up|left|right|down] [--nod DEGREES] [--noise FACTOR]
//   [--seed N]
//                        [--poses] [NAME=VALUE ...]
// The simulated places are mapped at the robot's true poses; --poses: at those of graph SLAM.
// PREFIX.wrl, PREFIX.glb and PREFIX.ply are written with -o. Times are of one thread.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/solid_files.hpp"
#include "majak/map/planes.hpp"
#include "majak/map/raised_walls.hpp"
#include "majak/map/solid_map.hpp"
#include "majak/sim/solid_simulator.hpp"

namespace {

using namespace majak;

struct Wish {
  std::string place, output, look = "up";
  double nod = 0, noise = 1;
  int seed = 1;
  map::RaiseOptions raise;
  map::SegmentMapOptions segments;
  map::SolidPointsOptions points;
  map::PlaneOptions planes;
  map::SolidOptions solid;
  map::LaserMounting mounting;
};

double cpu() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void tell(const Wish& wish, const map::Solid& solid) {
  const map::SolidCount n = map::count(solid);
  const std::string vrml = io::solid_vrml(solid), gltf = io::solid_gltf(solid),
                    ply = io::solid_ply(solid);
  fmt::print("solid               {} parts, {} quads, {} triangles, {} vertices\n", n.parts,
             n.quads, n.triangles, n.vertices);
  fmt::print("bytes               {} VRML, {} glTF, {} PLY\n", vrml.size(), gltf.size(),
             ply.size());
  if (wish.output.empty()) return;
  io::write_file_atomically(wish.output + ".wrl", vrml);
  io::write_file_atomically(wish.output + ".glb", gltf);
  io::write_file_atomically(wish.output + ".ply", ply);
}

void raise_run(const Wish& wish) {
  const auto input = io::read_map(wish.place);
  if (!input.site) throw Error(wish.place + ": not a run");
  const double begin = cpu();
  const map::Solid solid = map::raise_walls(*input.site, wish.raise, wish.segments);
  fmt::print("seconds             {:.2f} for {} scans\n", cpu() - begin, input.site->scans.size());
  tell(wish, solid);
}

/// The drive as a site of its true poses, and the second laser's scans.
struct Drive {
  Site site;
  std::vector<Scan> scans;
  map::TiltTrack tilt;
};

Drive drive(const Wish& wish, const sim::SolidRooms& rooms, const map::LaserMounting& mounting) {
  const sim::World world(rooms.plan);
  const sim::SolidWorld solid(rooms.solid);
  sim::SimulationOptions options;
  options.seed = wish.seed;
  options.intensities = true;
  sim::scale_noise(options, wish.noise);
  sim::SecondLaserOptions second{.mounting = mounting};
  second.nod = radians(wish.nod);
  sim::SolidSimulator simulator(world, solid, sim::plan_tour(world), options, second);
  Drive out;
  out.tilt = simulator.tilt();
  while (auto event = simulator.next()) {
    if (const auto* scan = std::get_if<Scan>(&*event)) {
      if (scan->laser == mounting.laser)
        out.scans.push_back(*scan);
      else
        out.site.scans.emplace_back().scan = *scan;
    } else if (const auto* truth = std::get_if<Truth>(&*event)) {
      out.site.scans.back().estimate.T_map_robot = truth->T_world_robot;
    }
  }
  return out;
}

void measure_place(const Wish& wish) {
  const sim::SolidRooms rooms = wish.place == "rooms" ? sim::solid_rooms() : sim::solid_yard();
  const map::LaserMounting mounting = map::looking(wish.look, wish.mounting);
  const Drive driven = drive(wish, rooms, mounting);
  double begin = cpu();
  map::SolidPoints points(driven.site, mounting, wish.points, driven.tilt);
  for (const Scan& scan : driven.scans) points.add(scan);
  const map::SolidCloud cloud = points.cloud();
  fmt::print("scans               {}, {} beams\n", driven.scans.size(), points.beams());
  for (const auto& [what, entry] : points.report().entries())
    fmt::print("                    {} {}\n", entry.count, what);
  fmt::print("cubes               {}, {} triangles, {:.2f} s\n", cloud.points.size(),
             cloud.triangles.size(), cpu() - begin);
  begin = cpu();
  const map::PlaneMap found = map::find_planes(cloud, wish.planes);
  const auto flat = std::count_if(found.plane_of.begin(), found.plane_of.end(),
                                  [](std::int32_t p) { return p >= 0; });
  fmt::print("planes              {}, {} of all cubes, {} rounds, {:.2f} s\n", found.planes.size(),
             flat, found.rounds, cpu() - begin);
  tell(wish, map::build_solid(cloud, found, wish.solid));
  for (const map::Plane& p : found.planes)
    fmt::print("  n {:6.3f} {:6.3f} {:6.3f} d {:7.3f} support {:7.1f} rms {:.4f}\n", p.normal.x(),
               p.normal.y(), p.normal.z(), p.offset, p.support, p.rms);
}

Wish wish_of(int argc, char** argv) {
  Wish wish;
  OptionFields fields;
  describe(fields, wish.raise);
  describe(fields, wish.segments);
  describe(fields, wish.points);
  describe(fields, wish.planes);
  describe(fields, wish.solid);
  describe(fields, wish.mounting);
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    const auto next = [&] {
      if (i + 1 == argc) throw Error(std::string(word) + " needs a value");
      return std::string(argv[++i]);
    };
    if (word == "-o")
      wish.output = next();
    else if (word == "--look")
      wish.look = next();
    else if (word == "--nod")
      wish.nod = std::stod(next());
    else if (word == "--noise")
      wish.noise = std::stod(next());
    else if (word == "--seed")
      wish.seed = std::stoi(next());
    else if (word.find('=') != word.npos)
      io::apply_option(fields, argv[i]);
    else
      wish.place = word;
  }
  if (wish.place.empty())
    throw Error("usage: run_solid RUN|rooms|yard [-o PREFIX] [NAME=VALUE ...]");
  return wish;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Wish wish = wish_of(argc, argv);
    if (wish.place == "rooms" || wish.place == "yard")
      measure_place(wish);
    else
      raise_run(wish);
    return 0;
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
