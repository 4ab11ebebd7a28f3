// SPDX-License-Identifier: Apache-2.0
// Doors of a simulated building that open and close during a drive.
//   run_doors [--seeds N] [--first SEED] [--people N] [--period S] [--laps N] [--verbose]
//             [NAME=VALUE ...]
//   run_doors RUN                 a run's folder or site.majak: its cells by kind, its doors
// Each drive is mapped, doors are found in the map, and their states followed scan by scan at the
// mapped poses. A look begins when a door comes into sight or moves; what is stated at its third
// scan is right or not.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/png.hpp"
#include "majak/map/doors.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/slam/graph_slam.hpp"

namespace {

using namespace majak;

constexpr double kSame = 0.3;          // m, between a doorway that was found and the true one
constexpr double kNear = 8;            // m, from which a door must have been seen to be found ...
constexpr int kOften = 15;             // scans, in both states
constexpr Duration kUnseen = kSecond;  // a door that was out of sight so long is looked at anew

struct Case {
  int seeds = 20, first = 1, people = 0, laps = 1;
  double period = 60;
  bool verbose = false;
  map::DynamicsOptions dynamics;
  map::DoorOptions doors;
};

struct Outcome {
  int doors = 0, moved = 0, found = 0, found_moved = 0, false_doors = 0;
  int looks = 0, right = 0, unsure = 0, after_change = 0, right_after_change = 0;
  double seen = 0, seen_right = 0, seen_unsure = 0;  // scans
  double worst = 0;                                  // m, of the poses
  double dynamics_seconds = 0, watch_seconds = 0;
  std::size_t scans = 0, bytes = 0;
};

double cpu() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

map::DoorSpan true_doorway(const sim::Door& door) { return {door.closed.a, door.closed.b}; }

bool same(const map::DoorSpan& a, const map::DoorSpan& b) {
  const auto both = [](const Vec2& p, const Vec2& q, const Vec2& u, const Vec2& v) {
    return (p - u).norm() < kSame && (q - v).norm() < kSame;
  };
  return both(a.a, a.b, b.a, b.b) || both(a.a, a.b, b.b, b.a);
}

/// Times at which a door begins to move, as the watch may see them, and looks at it.
void score(const sim::Door& truth, const Site& site, Time begin, const map::DoorSpan& doorway,
           const Case& c, Outcome& o) {
  map::DoorWatch watch({doorway}, c.doors);
  Time last_seen = INT64_MIN / 2, moved_until = INT64_MIN / 2;
  int in_look = 0;
  bool changed = false, was_open = truth.open_at_first;
  for (const PosedScan& scan : site.scans) {
    const Duration now = scan.scan.time - begin;
    watch.add(scan);
    const bool open = truth.open_at(now);
    if (open != was_open) {
      was_open = open, in_look = 0, changed = true;
      moved_until = now + sim::Door::kMoves;
    }
    if (!watch.in_sight(0)) continue;
    if (now - last_seen > kUnseen) {
      if (in_look == 0 && now < moved_until) changed = true;
      in_look = 0;
      if (now >= moved_until) changed = false;
    }
    last_seen = now;
    if (now < moved_until) continue;  // ajar: neither is right
    ++in_look;
    const map::DoorState state = watch.state(0);
    const bool right = state == (open ? map::DoorState::open : map::DoorState::closed);
    const bool unsure = state == map::DoorState::unknown;
    if (in_look >= 3) o.seen += 1, o.seen_right += right, o.seen_unsure += unsure;
    if (in_look != 3) continue;
    ++o.looks, o.right += right, o.unsure += unsure;
    if (c.verbose && !right)
      fmt::print(
          "    {} at {:.2f} s: ({:.2f} {:.2f})-({:.2f} {:.2f}) is {}, from {:.1f} m, {:.2f}\n",
          unsure ? "unsure" : "wrong", to_seconds(now), doorway.a.x(), doorway.a.y(), doorway.b.x(),
          doorway.b.y(), open ? "open" : "closed",
          (scan.estimate.T_map_robot.translation() - doorway.a).norm(), watch.open_chance(0));
    if (changed) ++o.after_change, o.right_after_change += right;
    changed = false;
  }
}

/// White free, black occupied, blue passed, red switching, grey unknown.
io::Image picture(const map::DynamicsMap& map) {
  const map::CellBox box = map.bounds();
  constexpr std::uint8_t kColours[5][3] = {
      {200, 204, 208}, {255, 255, 255}, {31, 35, 40}, {84, 170, 222}, {200, 62, 32}};
  io::Image image(box.width, box.height, 3);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x)
      std::copy_n(kColours[static_cast<std::size_t>(map.kind(box.x0 + x, box.y0 + y))], 3,
                  image.row(box.height - 1 - y) + static_cast<std::ptrdiff_t>(3) * x);
  return image;
}

Outcome run(const Case& c, int seed) {
  const sim::World world(sim::building());
  const sim::Path path = sim::plan_tour(world, {.laps = c.laps, .short_tour = true});
  sim::SimulationOptions options;
  options.seed = seed;
  options.people = c.people;
  options.door_period = c.period;
  sim::Simulator simulator(world, path, options);
  slam::GraphSlam slam(slam::GraphSlamOptions{}, {});
  std::vector<Pose2> truth;
  while (const auto event = simulator.next()) {
    if (const auto* t = std::get_if<Truth>(&*event)) truth.push_back(t->T_world_robot);
    slam.add(*event);
  }
  Site site = slam.finish().site;
  const Pose2 T_world_map = truth.front() * site.scans.front().estimate.T_map_robot.inverse();
  Outcome o;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    Pose2& pose = site.scans[i].estimate.T_map_robot;
    pose = T_world_map * pose;
    o.worst = std::max(o.worst, (pose.translation() - truth[i].translation()).norm());
  }
  o.scans = site.scans.size();
  double begun = cpu();
  const map::DynamicsMap dynamics = map::build_dynamics(site, c.dynamics);
  o.dynamics_seconds = cpu() - begun;
  o.bytes = dynamics.bytes();
  std::vector<map::DoorSpan> found;
  begun = cpu();
  for (const auto& h : map::doors_that_moved(site, dynamics, c.doors)) found.push_back(h.where);
  o.watch_seconds = cpu() - begun;
  const Time begin = from_seconds(options.start_time);
  if (c.verbose) io::write_file_atomically("dynamics.png", io::encode_png(picture(dynamics)));
  for (const sim::Door& door : simulator.doors()) {
    ++o.doors;
    // Seen in both states, both for long enough?
    map::DoorWatch watch({true_doorway(door)}, c.doors);
    std::map<map::DoorState, int> seen;
    for (const PosedScan& scan : site.scans) {
      watch.add(scan);
      const Vec2 way =
          scan.estimate.T_map_robot.translation() - (door.closed.a + door.closed.b) / 2;
      if (watch.in_sight(0) && way.norm() < kNear)
        ++seen[door.open_at(scan.scan.time - begin) ? map::DoorState::open
                                                    : map::DoorState::closed];
    }
    const bool moved =
        seen[map::DoorState::open] >= kOften && seen[map::DoorState::closed] >= kOften;
    const auto at = std::find_if(found.begin(), found.end(), [&](const map::DoorSpan& d) {
      return same(d, true_doorway(door));
    });
    o.moved += moved;
    o.found += at != found.end();
    o.found_moved += moved && at != found.end();
    if (at != found.end()) score(door, site, begin, *at, c, o);
    if (c.verbose)
      fmt::print("  door ({:.2f} {:.2f})-({:.2f} {:.2f}) {}{} seen open {} closed {}\n",
                 door.closed.a.x(), door.closed.a.y(), door.closed.b.x(), door.closed.b.y(),
                 moved ? "moved " : "", at != found.end() ? "found" : "missed",
                 seen[map::DoorState::open], seen[map::DoorState::closed]);
  }
  for (const map::DoorSpan& d : found) {
    const bool real = std::any_of(simulator.doors().begin(), simulator.doors().end(),
                                  [&](const sim::Door& t) { return same(d, true_doorway(t)); });
    o.false_doors += !real;
    if (c.verbose && !real)
      fmt::print("  false ({:.2f} {:.2f})-({:.2f} {:.2f})\n", d.a.x(), d.a.y(), d.b.x(), d.b.y());
  }
  return o;
}

void print(const Case& c) {
  Outcome sum;
  double worst = 0;
  int broken = 0;
  for (int i = 0; i < c.seeds; ++i) {
    const Outcome o = run(c, c.first + i);
    if (c.verbose)
      fmt::print("seed {}: {} of {} found, looks {} right {}, worst pose {:.3f} m\n", c.first + i,
                 o.found, o.doors, o.looks, o.right, o.worst);
    sum.doors += o.doors, sum.moved += o.moved, sum.found += o.found;
    sum.found_moved += o.found_moved, sum.false_doors += o.false_doors;
    sum.looks += o.looks, sum.right += o.right, sum.unsure += o.unsure;
    sum.after_change += o.after_change, sum.right_after_change += o.right_after_change;
    sum.seen += o.seen, sum.seen_right += o.seen_right, sum.seen_unsure += o.seen_unsure;
    sum.dynamics_seconds += o.dynamics_seconds, sum.watch_seconds += o.watch_seconds;
    sum.scans += o.scans, sum.bytes += o.bytes;
    worst = std::max(worst, o.worst);
    broken += o.worst > 0.5;
  }
  const auto percent = [](double a, double b) { return b > 0 ? 100 * a / b : 0.0; };
  fmt::print("drives: {}, worst pose {:.3f} m, broken maps {}\n", c.seeds, worst, broken);
  fmt::print(
      "doors: {}, seen in both states {}, of these found {} ({:.1f} %), found in all {}, false "
      "{}\n",
      sum.doors, sum.moved, sum.found_moved, percent(sum.found_moved, sum.moved), sum.found,
      sum.false_doors);
  fmt::print(
      "third scan of a look: right {} of {} ({:.1f} %), unsure {}; after the door moved {} of {} "
      "({:.1f} %)\n",
      sum.right, sum.looks, percent(sum.right, sum.looks), sum.unsure, sum.right_after_change,
      sum.after_change, percent(sum.right_after_change, sum.after_change));
  fmt::print("all scans from the third on: right {:.1f} %, unsure {:.1f} %\n",
             percent(sum.seen_right, sum.seen), percent(sum.seen_unsure, sum.seen));
  fmt::print(
      "CPU time: dynamics {:.2f} ms a scan, finding and watching doors {:.3f} ms a scan; {:.1f} MB "
      "a map\n",
      1e3 * sum.dynamics_seconds / static_cast<double>(sum.scans),
      1e3 * sum.watch_seconds / static_cast<double>(sum.scans),
      1e-6 * static_cast<double>(sum.bytes) / c.seeds);
}

void print_run(const Case& c, const std::string& path) {
  const auto input = io::read_map(path);
  if (!input.site) throw Error(path + ": no run");
  const Site& site = *input.site;
  const double begun = cpu();
  const map::DynamicsMap dynamics = map::build_dynamics(site, c.dynamics);
  const double seconds = cpu() - begun;
  std::map<map::CellKind, int> count;
  const map::CellBox box = dynamics.bounds();
  for (int y = box.y0; y < box.y0 + box.height; ++y)
    for (int x = box.x0; x < box.x0 + box.width; ++x) ++count[dynamics.kind(x, y)];
  const double cell = dynamics.resolution() * dynamics.resolution();
  fmt::print("{} scans, {} drawn, {:.0f} s; {:.2f} s CPU, {:.1f} MB\n", site.scans.size(),
             dynamics.scans_drawn(), dynamics.duration(), seconds,
             1e-6 * static_cast<double>(dynamics.bytes()));
  fmt::print("m^2: free {:.1f}, occupied {:.2f}, passed {:.2f}, switching {:.2f}\n",
             cell * count[map::CellKind::free], cell * count[map::CellKind::occupied],
             cell * count[map::CellKind::passed], cell * count[map::CellKind::switching]);
  for (const auto& h : map::doors_that_moved(site, dynamics, c.doors)) {
    fmt::print("door ({:.2f} {:.2f})-({:.2f} {:.2f}):", h.where.a.x(), h.where.a.y(), h.where.b.x(),
               h.where.b.y());
    for (const auto& s : h.stays)
      fmt::print(" {:.0f} s {}", to_seconds(s.begin - dynamics.begin()),
                 s.state == map::DoorState::open     ? "open"
                 : s.state == map::DoorState::closed ? "closed"
                                                     : "unknown");
    fmt::print("\n");
  }
  io::write_file_atomically("dynamics.png", io::encode_png(picture(dynamics)));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Case c;
    std::string run_path;
    OptionFields fields;
    describe(fields, c.dynamics.grid);
    describe(fields, c.dynamics);
    describe(fields, c.doors);
    for (int i = 1; i < argc; ++i) {
      const std::string arg = argv[i];
      const auto value = [&] {
        if (i + 1 == argc) throw Error(arg + " needs a value");
        return std::stod(argv[++i]);
      };
      if (arg == "--seeds") {
        c.seeds = static_cast<int>(value());
      } else if (arg == "--first") {
        c.first = static_cast<int>(value());
      } else if (arg == "--people") {
        c.people = static_cast<int>(value());
      } else if (arg == "--laps") {
        c.laps = static_cast<int>(value());
      } else if (arg == "--period") {
        c.period = value();
      } else if (arg == "--verbose") {
        c.verbose = true;
      } else if (arg.find('=') != std::string::npos) {
        io::apply_option(fields, arg);
      } else {
        run_path = arg;
      }
    }
    if (run_path.empty())
      print(c);
    else
      print_run(c, run_path);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "run_doors: {}\n", e.what());
    return 1;
  }
}
