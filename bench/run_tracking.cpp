// SPDX-License-Identifier: Apache-2.0
// Tracking, or another method, on a known map in simulation: how far off the truth, against what
// the scan could tell at best (Cramer-Rao), and whether the covariance is honest. The map's frame
// is the world's.
//   run_tracking [--method NAME] [--runs N] [--first SEED] [--only CASE] [--set OPTION=VALUE]...
// Monte Carlo begins anywhere, unless told otherwise: --set monte_carlo.start_sigma=0.3
#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/methods/methods.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::bench {
namespace {

enum class MapKind { exact, of_a_run };

struct Case {
  const char* name;
  MapKind map = MapKind::of_a_run;
  bool systematic = true;  ///< the laser's systematic error, drawn anew for map and drive
  bool odometry = true;
  bool doors = false;  ///< half of them differ between map and drive
  double blocked = 0;  ///< share of beams that people stand in
  // Sources of error that can be left out, one at a time.
  bool moving = true;   ///< while the mirror turns
  bool quantum = true;  ///< ranges in steps of 1 cm
  bool spot = true;     ///< a beam is as wide as it is: mixed pixels
  int beams = 181;
};

constexpr Case kCases[] = {
    {"exact map, random errors only", MapKind::exact, false},
    {"map of a run, random errors only", MapKind::of_a_run, false},
    {"exact map, laser as it is", MapKind::exact, true},
    {"map of a run, laser as it is", MapKind::of_a_run, true},
    {"the same without odometry", MapKind::of_a_run, true, false},
    {"doors", MapKind::of_a_run, true, true, true, 0},
    {"doors and people", MapKind::of_a_run, true, true, true, 0.3},
    {"source: standing while the mirror turns", MapKind::exact, false, true, false, 0, false},
    {"source: no steps of 1 cm", MapKind::exact, false, true, false, 0, true, false},
    {"source: beams without width", MapKind::exact, false, true, false, 0, true, true, false},
    {"source: none of the three", MapKind::exact, false, true, false, 0, false, false, false},
};

// ---- The building and its doors --------------------------------------------------------------

struct Door {
  double x, y;
  bool along_x;
};
constexpr Door kDoors[] = {
    {8.5, 6, true},     {14, 6, true},       {20.5, 6, true},     {29, 6, true},
    {9.5, 19.2, true},  {15, 19.2, true},    {25.5, 19.2, true},  {31, 19.2, true},
    {30, 17, true},     {5, 7.2, false},     {5, 11, false},      {5, 17.8, false},
    {35.2, 7.1, false}, {35.2, 12.5, false}, {35.2, 18.1, false}, {17, 3, false},
    {29, 22, false},    {7.2, 13, false},    {19, 11, false},     {21, 14, false},
    {33, 11.5, false},  {27, 12.5, false}};

sim::Segment leaf(const Door& door) {
  const Vec2 half = door.along_x ? Vec2(0.5, 0) : Vec2(0, 0.5);
  return {Vec2(door.x, door.y) - half, Vec2(door.x, door.y) + half, 0.5};
}

/// The doors that the way does not lead through.
std::vector<Door> beside(const sim::Path& path) {
  std::vector<Door> doors;
  for (const Door& door : kDoors)
    if (std::none_of(path.points.begin(), path.points.end(),
                     [&](const Vec2& p) { return sim::distance_to(leaf(door), p) < 0.35; }))
      doors.push_back(door);
  return doors;
}

struct Worlds {
  sim::World map, drive;
};

/// Each door is open or closed while mapping; half of them are not as they were in the drive.
Worlds worlds(const sim::Path& path, bool toggled, std::uint64_t seed) {
  sim::Scene map = sim::building(), drive = sim::building();
  std::vector<Door> doors = beside(path);
  RandomStream random(seed, 77);
  for (std::size_t i = doors.size(); i > 1; --i) std::swap(doors[i - 1], doors[random.below(i)]);
  for (std::size_t i = 0; toggled && i < doors.size(); ++i) {
    const bool closed = random.uniform() < 0.5, change = i < doors.size() / 2;
    if (closed) map.segments.push_back(leaf(doors[i]));
    if (closed != change) drive.segments.push_back(leaf(doors[i]));
  }
  return {sim::World(std::move(map)), sim::World(std::move(drive))};
}

// ---- Maps ------------------------------------------------------------------------------------

sim::SimulationOptions simulation(const Case& c, std::uint64_t seed) {
  sim::SimulationOptions options;
  options.seed = static_cast<int>(seed);
  if (!c.systematic) options.laser.systematic_error = 0;
  if (!c.quantum) options.laser.quantum = 0;
  if (!c.spot) options.laser.beam_width = 0;
  options.beams = c.beams;
  return options;
}

/// A run whose poses are the truth: what the map errs by are the laser's own errors.
Site mapped(const sim::World& world, const sim::Path& path, const sim::SimulationOptions& options) {
  Site site;
  for (Event& event : sim::simulate(world, path, options)) {
    if (auto* scan = std::get_if<Scan>(&event)) {
      site.scans.push_back({std::move(*scan), {}, {}, {}, false, 1});
    } else if (const auto* truth = std::get_if<Truth>(&event)) {
      site.scans.back().estimate.T_map_robot = truth->T_world_robot;
    }
  }
  for (std::size_t i = 0; i + 1 < site.scans.size(); ++i) {
    Pose2& at = site.scans[i].estimate.T_map_robot;
    const double period = to_seconds(site.scans[i + 1].scan.time - site.scans[i].scan.time);
    at = at * exp((0.25 / 75 / period) * log(between(at, site.scans[i + 1].estimate.T_map_robot)));
  }
  for (std::size_t i = 0; i < site.scans.size(); i += 4) site.scans[i].key = true;
  return site;
}

/// The world as it is: a laser without errors looks around wherever the way leads.
Site surveyed(const sim::World& world, const sim::Path& path) {
  Site site;
  for (const Vec2& p : path.points) {
    Scan scan;
    scan.start_angle = -kPi, scan.angle_step = 2 * kPi / 1440, scan.max_range = 80;
    for (std::size_t i = 0; i < 1440; ++i)
      scan.ranges.push_back(static_cast<float>(world.cast(p, scan.angle(i), 80).range));
    PosedScan posed;
    posed.scan = std::move(scan);
    posed.estimate.T_map_robot = {p.x(), p.y(), 0};
    site.scans.push_back(std::move(posed));
  }
  return site;
}

// ---- The bound -------------------------------------------------------------------------------

/// Information of a scan of the pose (Censi 2007): J' J / sigma^2 over its beams, J = dr/d(pose).
Mat3 information(const sim::World& world, const Pose2& T_world_robot, const Scan& scan,
                 const sensor::RangeNoiseOptions& laser) {
  const Pose2 T_world_laser = T_world_robot * scan.T_robot_laser;
  const Vec2 arm = T_world_laser.translation() - T_world_robot.translation();
  const auto& scene = world.scene();
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!std::isfinite(scan.ranges[i])) continue;
    const double angle = T_world_laser.theta + scan.angle(i);
    const Vec2 u(std::cos(angle), std::sin(angle));
    const sim::Hit hit = world.cast(T_world_laser.translation(), angle, laser.max_range);
    if (hit.object < 0) continue;
    const auto object = static_cast<std::size_t>(hit.object);
    Vec2 n;
    if (object < scene.segments.size()) {
      const Vec2 along = scene.segments[object].b - scene.segments[object].a;
      n = {-along.y(), along.x()};
    } else {
      n = T_world_laser.translation() + hit.range * u -
          scene.discs[object - scene.segments.size()].centre;
    }
    // n' (laser + r u) stays on the surface.
    const Vec2 swing = Vec2(-arm.y(), arm.x()) + hit.range * Vec2(-u.y(), u.x());
    const double across = n.dot(u);
    if (std::abs(across) < 0.05 * n.norm()) continue;  // grazing: its spot covers metres
    const Vec3 j = Vec3(n.x(), n.y(), n.dot(swing)) / -across;
    sum += j * j.transpose();
  }
  return sum / (laser.statistical_error * laser.statistical_error);
}

// ---- Runs ------------------------------------------------------------------------------------

/// People who walk along with the robot hide part of the view: each stands in the same beams for
/// two seconds.
void block(Scan& scan, std::size_t number, double share, std::uint64_t seed) {
  constexpr std::size_t kScans = 15;
  constexpr double kWidth = 0.45;  // m
  RandomStream random(seed, 78, number / kScans);
  RandomStream noise(seed, 79, number);
  std::vector<char> hidden(scan.ranges.size(), 0);
  std::size_t count = 0;
  while (static_cast<double>(count) < share * static_cast<double>(hidden.size())) {
    const double range = random.uniform(0.6, 4);
    const auto half = static_cast<std::size_t>(0.5 * kWidth / range / scan.angle_step);
    const std::size_t middle = random.below(hidden.size());
    for (std::size_t i = middle - std::min(middle, half);
         i < std::min(hidden.size(), middle + half + 1); ++i) {
      count += !hidden[i];
      hidden[i] = 1;
      if (!(scan.ranges[i] < range))
        scan.ranges[i] = static_cast<float>(range + 0.01 * noise.normal());
    }
  }
}

/// The ranges as the robot would have read them had it stood at T_world_robot; no mixed pixels.
void stand(Scan& scan, const sim::World& world, const Pose2& T_world_robot,
           const sim::SimulationOptions& options, std::size_t number) {
  const sensor::RangeNoise noise(options.laser, RandomStream(options.seed, 80));
  const Pose2 T_world_laser = T_world_robot * scan.T_robot_laser;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    RandomStream random(static_cast<std::uint64_t>(options.seed), 81 + number, i);
    const sim::Hit hit = world.cast(T_world_laser.translation(),
                                    T_world_laser.theta + scan.angle(i), options.laser.max_range);
    scan.ranges[i] = noise.simulate_range(hit.range, hit.incidence, hit.reflectivity, random);
  }
}

struct Outcome {
  double square = 0, square_turn = 0;  // m^2, rad^2, means over the scans
  double bound = 0, bound_turn = 0;    // of the bound's covariance
  double against_bound = 0;            // e' F e / 3
  double nees = 0, last_nees = 0, nis = 0;
  double farthest = 0;  // m
  double not_ok = 0;    // share
};

constexpr std::size_t kSkipped = 10;  // scans at the beginning, when the start is still told

/// A method of localization and what it is told.
struct Tried {
  const char* method = "tracking";
  methods::LocalizeOptions options;
};

Outcome run(const Case& c, const Tried& tried, std::uint64_t seed) {
  const sim::World plain(sim::building());
  const sim::Path path = sim::plan_tour(plain, {.short_tour = true});
  const Worlds w = worlds(path, c.doors, seed);
  const auto drive = simulation(c, seed);
  methods::LocalizeOptions options = tried.options;
  options.place = localize::place_of(c.map == MapKind::exact
                                         ? surveyed(w.map, path)
                                         : mapped(w.map, path, simulation(c, seed + 500000)));
  std::vector<Scan> scans;
  std::vector<Pose2> truth;
  std::vector<Event> events;
  std::vector<Event> simulated = sim::simulate(w.drive, path, drive);
  for (std::size_t i = 0; i < simulated.size(); ++i) {
    Event& event = simulated[i];
    if (auto* scan = std::get_if<Scan>(&event)) {
      if (!c.moving)
        for (const Event& other : simulated)
          if (const auto* t = std::get_if<Truth>(&other); t && t->time == scan->time)
            stand(*scan, w.drive, t->T_world_robot, drive, scans.size());
      if (c.blocked > 0) block(*scan, scans.size(), c.blocked, seed);
      if (!c.odometry) scan->T_odom_robot.reset();
      scans.push_back(*scan);
    }
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(t->T_world_robot);
    if (std::holds_alternative<Odometry>(event) && !c.odometry) continue;
    events.push_back(std::move(event));
  }
  options.start = truth.front();
  if (!c.moving) options.tracking.mirror_turn = 0;
  const auto localizer = methods::method(tried.method).make(options);
  for (const Event& event : events) localizer.add(event);
  const auto result = localizer.finish();
  Outcome o;
  double n = 0;
  for (std::size_t i = kSkipped; i < result.estimates.size(); ++i) {
    const Estimate& e = result.estimates[i];
    const Vec3 off(e.T_map_robot.x - truth[i].x, e.T_map_robot.y - truth[i].y,
                   angle_diff(e.T_map_robot.theta, truth[i].theta));
    o.farthest = std::max(o.farthest, off.head<2>().norm());
    o.not_ok += e.health != Health::ok;
    if (!result.innovations.empty()) o.nis += result.innovations[i].nis;
    o.last_nees = eval::nees(e.T_map_robot, e.covariance, truth[i]).value_or(0);
    o.nees += o.last_nees;
    o.square += off.head<2>().squaredNorm();
    o.square_turn += off.z() * off.z();
    const Mat3 f = information(w.drive, truth[i], scans[i], drive.laser);
    const Mat3 best = f.inverse();
    o.bound += best(0, 0) + best(1, 1);
    o.bound_turn += best(2, 2);
    o.against_bound += off.dot(f * off) / 3;
    n += 1;
  }
  for (double* v : {&o.square, &o.square_turn, &o.bound, &o.bound_turn, &o.against_bound, &o.nees,
                    &o.nis, &o.not_ok})
    *v /= n;
  return o;
}

void print_case(const Case& c, const Tried& tried, int runs, int first) {
  Outcome sum;
  int within = 0;
  double worst_nees = 0;
  for (int i = 0; i < runs; ++i) {
    const Outcome o = run(c, tried, static_cast<std::uint64_t>(first + i));
    sum.square += o.square / runs, sum.square_turn += o.square_turn / runs;
    sum.bound += o.bound / runs, sum.bound_turn += o.bound_turn / runs;
    sum.against_bound += o.against_bound / runs;
    sum.nees += o.nees / runs, sum.last_nees += o.last_nees / runs, sum.nis += o.nis / runs;
    sum.not_ok += o.not_ok / runs;
    sum.farthest = std::max(sum.farthest, o.farthest);
    within += o.farthest < 0.10;
    worst_nees = std::max(worst_nees, o.nees);
  }
  fmt::print(
      "| {} | {:.1f} mm, {:.3f}° | {:.2f}, {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.2f} | {:.2f} | "
      "{:.0f} mm | {:.0f} % | {:.1f} % |\n",
      c.name, 1e3 * std::sqrt(sum.square), degrees(std::sqrt(sum.square_turn)),
      std::sqrt(sum.square / sum.bound), std::sqrt(sum.square_turn / sum.bound_turn),
      std::sqrt(sum.against_bound), sum.nees, worst_nees, sum.last_nees, sum.nis,
      1e3 * sum.farthest, 100.0 * within / runs, 100 * sum.not_ok);
}

void set(methods::LocalizeOptions& options, const std::string& text) {
  OptionFields fields;
  describe(fields, options);
  const std::size_t equal = text.find('=');
  for (const OptionField& f : fields.list)
    if (f.name == text.substr(0, equal) && equal != std::string::npos) {
      const double value = std::stod(text.substr(equal + 1));
      if (auto* const* d = std::get_if<double*>(&f.value)) **d = value;
      if (auto* const* k = std::get_if<int*>(&f.value)) **k = static_cast<int>(value);
      if (auto* const* b = std::get_if<bool*>(&f.value)) **b = value != 0;
      return;
    }
  throw Error("no such option: " + text);
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  using namespace majak;
  int runs = 50, first = 1001;
  std::string only;
  bench::Tried tried;
  try {
    for (int i = 1; i + 1 < argc; i += 2) {
      const std::string name = argv[i];
      if (name == "--runs") runs = std::stoi(argv[i + 1]);
      if (name == "--first") first = std::stoi(argv[i + 1]);
      if (name == "--only") only = argv[i + 1];
      if (name == "--set") bench::set(tried.options, argv[i + 1]);
      if (name == "--method") tried.method = argv[i + 1];
    }
    const double n = 3.0 * runs;
    fmt::print(
        "{} runs a row; NEES 3 expected, 95 % band over that many independent poses {:.2f} ... "
        "{:.2f}\n\n| case | rms error | times the bound | whitened | NEES | worst run | last pose "
        "| NIS | farthest | runs "
        "within 10 cm | not ok |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
        runs, eval::chi_square_quantile(0.025, n) / runs,
        eval::chi_square_quantile(0.975, n) / runs);
    for (const bench::Case& c : bench::kCases)
      if (only.empty() || std::string(c.name).find(only) != std::string::npos) {
        bench::print_case(c, tried, runs, first);
        std::fflush(stdout);
      }
  } catch (const Error& error) {
    fmt::print(stderr, "run_tracking: {}\n", error.what());
    return 1;
  }
}
