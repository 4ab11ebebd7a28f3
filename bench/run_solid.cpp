// SPDX-License-Identifier: Apache-2.0
// Solids, measured.
//   run_solid RUN [-o PREFIX] [NAME=VALUE ...]      walls raised from a run
//   run_solid rooms|yard [-o PREFIX] [--look up|left|right|down] [--nod DEGREES] [--noise FACTOR]
//   [--seed N]
//                        [NAME=VALUE ...]
// The simulated places are mapped at the robot's true poses.
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
#include "majak/map/elevation.hpp"
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

/// A true surface, and the plane that most of what was seen of it went to.
struct Surface {
  const sim::Patch* patch;
  double seen;           // m^2
  std::int32_t plane;    // -1: none
  double offset, angle;  // m, at the middle of what was seen, and rad
};

std::vector<std::size_t> points_on(const sim::Patch& patch, const map::SolidCloud& cloud) {
  constexpr double kNear = 0.07;  // m; walls are 0.15 m thick
  std::vector<std::size_t> members;
  const Vec3 n = patch.normal();
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Vec3 off = cloud.points[i].mean - patch.corner;
    const double s = off.dot(patch.u) / patch.u.squaredNorm(),
                 r = off.dot(patch.v) / patch.v.squaredNorm();
    if (std::abs(off.dot(n)) < kNear && s >= 0 && s <= 1 && r >= 0 && r <= 1 &&
        cloud.points[i].towards.dot(n) > 0)
      members.push_back(i);
  }
  return members;
}

Surface surface_of(const sim::Patch& patch, const map::SolidCloud& cloud,
                   const map::PlaneMap& found) {
  const std::vector<std::size_t> members = points_on(patch, cloud);
  const double seen = static_cast<double>(members.size()) * cloud.voxel * cloud.voxel;
  Surface surface{&patch, std::min(seen, patch.area()), -1, 0, 0};
  std::vector<int> votes(found.planes.size() + 1);
  Vec3 middle = Vec3::Zero();
  for (const std::size_t i : members) {
    ++votes[static_cast<std::size_t>(found.plane_of[i] + 1)];
    middle += cloud.points[i].mean / static_cast<double>(members.size());
  }
  surface.plane =
      static_cast<std::int32_t>(std::max_element(votes.begin(), votes.end()) - votes.begin()) - 1;
  if (surface.plane < 0) return surface;
  const map::Plane& plane = found.planes[static_cast<std::size_t>(surface.plane)];
  middle -= (middle - patch.corner).dot(patch.normal()) * patch.normal();
  surface.offset = std::abs(plane.normal.dot(middle) - plane.offset);
  surface.angle = std::acos(std::min(1.0, std::abs(plane.normal.dot(patch.normal()))));
  return surface;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void compare(const sim::SolidScene& truth, const map::SolidCloud& cloud,
             const map::PlaneMap& found) {
  // Of what less was seen, or what is narrower (jambs of doors), is no surface to be found.
  constexpr double kLeast = 0.5, kNarrow = 0.3;  // m^2, m
  std::vector<double> offsets, angles;
  std::vector<bool> true_plane(found.planes.size());
  int surfaces = 0, close = 0;
  for (const sim::Patch& patch : truth.patches) {
    const Surface s = surface_of(patch, cloud, found);
    if (s.plane >= 0 && s.offset < 0.1 && s.angle < radians(10))
      true_plane[static_cast<std::size_t>(s.plane)] = true;
    if (s.seen < kLeast || std::min(patch.u.norm(), patch.v.norm()) < kNarrow) continue;
    ++surfaces;
    const bool good = s.plane >= 0 && s.offset < 0.01 && s.angle < radians(0.5);
    close += good;
    if (!good)
      fmt::print(
          "  missed            {} at {:.1f} {:.1f} {:.1f}, {:.1f} m^2 seen: {:.1f} cm, {:.2f} "
          "deg\n",
          patch.name, patch.corner.x(), patch.corner.y(), patch.corner.z(), s.seen,
          s.plane < 0 ? NAN : 100 * s.offset, degrees(s.angle));
    if (s.plane < 0) continue;
    offsets.push_back(s.offset), angles.push_back(s.angle);
  }
  fmt::print("true surfaces       {} of which 0.5 m^2 or more was seen\n", surfaces);
  fmt::print("  found             {}, within 1 cm and 0.5 deg {}\n", offsets.size(), close);
  fmt::print("  offset            {:.2f} cm in the middle, {:.2f} cm at most\n",
             100 * median(offsets),
             offsets.empty() ? 0 : 100 * *std::max_element(offsets.begin(), offsets.end()));
  fmt::print("  angle             {:.3f} deg in the middle, {:.3f} deg at most\n",
             degrees(median(angles)),
             angles.empty() ? 0 : degrees(*std::max_element(angles.begin(), angles.end())));
  fmt::print("planes of no patch  {}\n", std::count(true_plane.begin(), true_plane.end(), false));
}

/// Heights of the elevation map against the highest surface below a ray from above.
void measure_elevation(const sim::SolidScene& truth, const map::SolidCloud& cloud) {
  const double begin = cpu();
  const map::Elevation map = map::build_elevation(cloud);
  const double seconds = cpu() - begin;
  const sim::SolidWorld world(truth);
  int kinds[5] = {}, wrong = 0, flat = 0, ramp = 0;
  double square = 0;
  std::vector<double> slopes;
  std::size_t i = 0;
  for (int iy = map.box.y0; iy < map.box.y0 + map.box.height; ++iy)
    for (int ix = map.box.x0; ix < map.box.x0 + map.box.width; ++ix, ++i) {
      const map::ElevationCell& cell = map.cells[i];
      ++kinds[static_cast<int>(cell.ground)];
      if (cell.ground == map::Ground::unknown || cell.ground == map::Ground::obstacle) continue;
      const Vec3 above{(ix + 0.5) * map.resolution, (iy + 0.5) * map.resolution, 1.15};
      const double height = above.z() - world.cast(above, {0, 0, -1}, 10).range;
      if (!std::isfinite(height)) continue;
      ++flat;
      wrong += std::abs(cell.height - height) > 0.05;
      if (std::abs(cell.height - height) <= 0.05) square += std::pow(cell.height - height, 2);
      if (!cell.slope_known() ||
          !(above.x() > 12.5 && above.x() < 15.5 && above.y() > 3.5 && above.y() < 6.5))
        continue;
      ++ramp;
      slopes.push_back(std::abs(degrees(cell.slope()) - 10));
    }
  fmt::print("elevation           {} passable, {} steep, {} step, {} obstacle cells, {:.2f} s\n",
             kinds[1], kinds[2], kinds[3], kinds[4], seconds);
  fmt::print("  height            {:.2f} cm rms; {} of {} cells off by more than 5 cm\n",
             flat > wrong ? 100 * std::sqrt(square / (flat - wrong)) : 0, wrong, flat);
  if (ramp > 0)
    fmt::print("  slope of the ramp {} cells, off by {:.2f} deg in the middle, {:.2f} at most\n",
               ramp, median(slopes), *std::max_element(slopes.begin(), slopes.end()));
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
  compare(rooms.solid, cloud, found);
  if (wish.place == "yard") measure_elevation(rooms.solid, cloud);
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
