// SPDX-License-Identifier: Apache-2.0
#include "app/simulate.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/beacon_map.hpp"
#include "majak/io/carmen_writer.hpp"
#include "majak/io/mcap_log_writer.hpp"
#include "majak/io/options_file.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/plan.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/solid_simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

struct SimulateOptions {
  std::string world = "building";
  std::string output;
  std::string drive;  // empty: what suits the world
  std::string reflectors;
  std::string landmarks;
  std::string doors;
  double cell = 0;  // m, of a plan
  double noise = 1;
  std::vector<std::string> set;
  bool json = false;
  std::string second;  // where a second laser looks; empty: there is none
  std::string tilt;    // its tilts go to that file
  double nod = 0;      // degrees
  map::LaserMounting mounting;
  sim::TourOptions tour;
  sim::SimulationOptions simulation;
};

sim::DriveKind drive_of(const std::string& name) {
  if (name == "differential") return sim::DriveKind::differential;
  if (name == "ackermann" || name == "car") return sim::DriveKind::ackermann;
  if (name == "omnidirectional") return sim::DriveKind::omnidirectional;
  throw Error("--drive " + name + ": choose differential, ackermann, car or omnidirectional");
}

constexpr const char* kSimulateHelp =
    "A robot with an LMS-291 drives through a world; out comes an ordinary log, with the truth in "
    "it.\n"
    "\n"
    "Examples:\n"
    "  majak simulate                               a building, writes building.log\n"
    "  majak simulate ring -o ring.log --seed 7     a corridor that closes on itself\n"
    "  majak simulate office-7                      an office building made up from the number 7\n"
    "  majak simulate plan.txt --drive ackermann    your own plan: '#' wall, '.' floor, '>' start\n"
    "  majak simulate floor.png --cell 0.02         a picture, dark is wall, 2 cm a pixel\n"
    "  majak simulate yard --drive car -o car.mcap  a car reports speed and steering, no poses\n"
    "  majak simulate park --satellites             1.8 km among 200 trunks by car, fixes now and "
    "then\n"
    "  majak simulate --reflectors r.txt            with reflectors, and how bright each echo is\n"
    "  majak simulate solid_rooms --second up       with a second, upright laser\n"
    "  majak simulate solid_yard --second down --nod 15 --tilt tilt.txt    that nods\n"
    "  majak simulate --lag 0.1 --wrong-direction   a log as bad as some old ones\n"
    "\n"
    "The log is in CARMEN's format, the true poses are its TRUEPOS lines; or, if its name ends in\n"
    ".mcap, a recording of ROS 2 with the true poses on /ground_truth. There a drive with "
    "steering\n"
    "reports its speed and steering on /drive, and satellites are on /fix. Equal options and seed\n"
    "give equal bytes.\n";

bool is_mcap(const fs::path& log) { return log.extension() == ".mcap"; }

sim::Scene find_scene(const SimulateOptions& o) {
  const auto names = sim::built_in_names();
  const bool known = std::find(names.begin(), names.end(), o.world) != names.end();
  if (known || !fs::exists(o.world)) return sim::built_in(o.world);
  return sim::read_plan(o.world, o.cell);
}

/// Of a place without heights: its walls raised, under a ceiling.
sim::SolidRooms find_place(const SimulateOptions& o) {
  if (o.world == "solid_rooms") return sim::solid_rooms();
  if (o.world == "solid_yard") return sim::solid_yard();
  sim::SolidRooms place{find_scene(o), {}};
  if (!o.second.empty()) place.solid = sim::raised(place.plan);
  return place;
}

struct Summary {
  std::int64_t scans = 0, odometry = 0, fixes = 0, beams = 0, returns = 0;

  void add(const Event& event) {
    odometry +=
        std::holds_alternative<Odometry>(event) || std::holds_alternative<WheelMotion>(event);
    fixes += std::holds_alternative<GpsFix>(event);
    const auto* scan = std::get_if<Scan>(&event);
    if (scan == nullptr) return;
    ++scans;
    beams += static_cast<std::int64_t>(scan->ranges.size());
    returns += std::count_if(scan->ranges.begin(), scan->ranges.end(),
                             [](float range) { return std::isfinite(range); });
  }
};

void print_summary(const SimulateOptions& o, const Summary& s, const sim::RobotRun& run) {
  const sim::RobotState& last = run.states().back();
  const Pose2 T_world_odom = run.states().front().T_world_robot;
  const Pose2 end = T_world_odom * last.T_odom_robot;
  const double error = (end.translation() - last.T_world_robot.translation()).norm();
  const double turn = std::abs(angle_diff(end.theta, last.T_world_robot.theta));
  const double seconds = to_seconds(run.duration());
  const double no_return =
      s.beams > 0 ? 1 - static_cast<double>(s.returns) / static_cast<double>(s.beams) : 0;
  if (o.json) {
    nlohmann::ordered_json json = {{"log", o.output},
                                   {"world", o.world},
                                   {"seed", o.simulation.seed},
                                   {"scans", s.scans},
                                   {"beams", o.simulation.beams},
                                   {"odometry_records", s.odometry},
                                   {"fixes", s.fixes},
                                   {"path_m", run.path_length()},
                                   {"duration_s", seconds},
                                   {"no_return_share", no_return},
                                   {"odometry_error_m", error},
                                   {"odometry_error_deg", degrees(turn)}};
    json["disturbances"] = nlohmann::ordered_json::array();
    for (const sim::Disturbance& d : run.disturbances())
      json["disturbances"].push_back({{"kind", d.bump ? "push" : "slip"},
                                      {"begin_s", o.simulation.start_time + to_seconds(d.begin)},
                                      {"end_s", o.simulation.start_time + to_seconds(d.end)},
                                      {"way_m", d.twist.head<2>().norm()},
                                      {"turn_deg", degrees(d.bump ? d.twist.z() : -d.twist.z())}});
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}: {} scans of {} beams and {} odometry records; {:.1f} m in {:.0f} s\n", o.output,
             s.scans, o.simulation.beams, s.odometry, run.path_length(), seconds);
  if (o.simulation.satellites.on) fmt::print("  {} fixes of satellites\n", s.fixes);
  fmt::print(
      "  {:.1f} % of the beams without return; the odometry ends {:.2f} m and {:.1f} degrees off\n",
      100 * no_return, error, degrees(turn));
}

template <class Simulator>
Summary write_log(Simulator& simulator, const SimulateOptions& o) {
  Summary summary;
  const auto write = [&](auto& log) {
    while (const auto event = simulator.next()) {
      summary.add(*event);
      log.write(*event);
    }
  };
  if (is_mcap(o.output)) {
    const fs::path unfinished = o.output + ".part";
    io::McapLogWriter log(unfinished.string());
    write(log);
    log.close();
    fs::rename(unfinished, o.output);
    return summary;
  }
  io::CarmenWriter log(o.output,
                       fmt::format("simulated by majak: world {}, seed {}",
                                   fs::path(o.world).filename().string(), o.simulation.seed));
  write(log);
  log.commit();
  return summary;
}

/// Every round thing, where it truly is; those that are felled say when.
void write_landmarks(const sim::Simulator& simulator, const sim::World& world,
                     const SimulateOptions& o) {
  std::string text = "# x y radius, m, frame of the true poses and of the fixes\n";
  const auto& felled = simulator.felled();
  const auto& discs = world.scene().discs;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const sim::Disc& d = discs[i];
    text += fmt::format("{:.6f} {:.6f} {:.6f}", d.centre.x(), d.centre.y(), d.radius);
    if (std::binary_search(felled.begin(), felled.end(), i))
      text += fmt::format(" # gone from {} s of the run on", o.simulation.felled_at);
    text += '\n';
  }
  io::write_file_atomically(o.landmarks, text);
}

/// Every door that moves: hinge, latch, and when it opened or closed.
void write_doors(const sim::Simulator& simulator, const SimulateOptions& o) {
  std::string text =
      "# hinge x y, latch x y (m, frame of the true poses); state, then stamps (s) of changes\n";
  for (const sim::Door& door : simulator.doors()) {
    const sim::Segment& leaf = door.closed;
    text += fmt::format("{:.3f} {:.3f} {:.3f} {:.3f} {}", leaf.a.x(), leaf.a.y(), leaf.b.x(),
                        leaf.b.y(), door.open_at_first ? "open" : "closed");
    for (const Duration change : door.changes)
      text += fmt::format(" {:.3f}", o.simulation.start_time + to_seconds(change));
    text += '\n';
  }
  io::write_file_atomically(o.doors, text);
}

/// What world, log and robot settle for each other where the user says nothing.
void settle(SimulateOptions& o) {
  const bool park = o.world == "park", recorded = park || o.simulation.satellites.on;
  if (o.output.empty())
    o.output = fs::path(o.world).stem().string() + (recorded ? ".mcap" : ".log");
  if (o.drive.empty()) o.drive = park ? "car" : "differential";
  o.simulation.robot.drive = drive_of(o.drive);
  o.simulation.robot.reports_steering =
      is_mcap(o.output) && o.simulation.robot.drive == sim::DriveKind::ackermann;
  if (o.drive == "car") sim::make_car(o.simulation);  // --set may change it
}

void finish(const SimulateOptions& o, const Summary& summary, const sim::Simulator& simulator,
            const sim::World& world) {
  if (!o.landmarks.empty()) write_landmarks(simulator, world, o);
  if (!o.doors.empty()) write_doors(simulator, o);
  print_summary(o, summary, simulator.run());
}

void simulate_with_second(const sim::World& world, const sim::SolidScene& scene,
                          const sim::Path& path, const SimulateOptions& o) {
  const sim::SolidWorld solid(scene);
  sim::SecondLaserOptions second;
  second.mounting = map::looking(o.second, o.mounting);
  second.beams = o.simulation.beams;
  second.nod = radians(o.nod);
  sim::SolidSimulator simulator(world, solid, path, o.simulation, second);
  finish(o, write_log(simulator, o), simulator.first(), world);
  if (o.tilt.empty()) return;
  std::string text;
  for (const auto& [time, tilt] : simulator.tilt().samples())
    text += fmt::format("{:.6f} {:.6f}\n", to_seconds(time), tilt);
  io::write_file_atomically(o.tilt, text);
}

void run_simulate(SimulateOptions& o) {
  settle(o);
  OptionFields fields;
  sim::describe(fields, o.simulation);
  map::describe(fields, o.mounting);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  if (o.noise != 1) sim::scale_noise(o.simulation, o.noise);
  if (o.simulation.satellites.on && !is_mcap(o.output))
    throw Error(o.output +
                ": CARMEN's format has no record for fixes in the world's frame: write a "
                "recording (-o NAME.mcap)");
  sim::SolidRooms place = find_place(o);
  if (!o.reflectors.empty()) {
    for (const beacon::Beacon& b : io::read_beacon_map(o.reflectors).beacons)
      place.plan.discs.push_back(sim::reflector(b.p_map));
    o.simulation.intensities = true;
  }
  const sim::World world(std::move(place.plan));
  const sim::Path path = sim::plan_tour(world, o.tour);
  if (!o.second.empty()) return simulate_with_second(world, place.solid, path, o);
  sim::Simulator simulator(world, path, o.simulation);
  finish(o, write_log(simulator, o), simulator, world);
}

}  // namespace

void add_simulate(CLI::App& app) {
  auto o = std::make_shared<SimulateOptions>();
  CLI::App* command = app.add_subcommand("simulate", kSimulateHelp);
  command
      ->add_option(
          "world", o->world,
          "building, ring, large_ring, bare_ring, nested_rings, corridor, yard, park, "
          "solid_rooms, solid_yard, office-N (made up from the number N), or a plan (text or PNG)")
      ->capture_default_str();
  command->add_option(
      "-o,--output", o->output,
      "the log, .log or .mcap; default: the world's name with .log, in the park and with "
      "--satellites .mcap");
  command->add_option("--seed", o->simulation.seed, "another number, another run")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--drive", o->drive,
                   "differential, ackermann, car (one of full size) or omnidirectional; default: "
                   "differential, in the park car")
      ->type_name("NAME");
  command->add_option("--beams", o->simulation.beams, "of a scan: 181, 361, 101, 201 or 401")
      ->check(CLI::IsMember({181, 361, 101, 201, 401}).description(""))
      ->capture_default_str();
  command->add_option("--laps", o->tour.laps, "how often the tour is driven")
      ->check(CLI::Range(1, 1000).description(""))
      ->capture_default_str();
  command->add_flag("--short", o->tour.short_tour,
                    "the shorter tour: about 100 m, of the large ring 235 m");
  command
      ->add_option("--noise", o->noise,
                   "times the usual noise of laser, wheels and satellites; 0 for none")
      ->check(CLI::Range(0.0, 100.0).description(""))
      ->capture_default_str();
  command->add_option("--max-range", o->simulation.laser.max_range, "m; 8 is the millimetre mode")
      ->check(CLI::Range(1.0, 80.0).description(""))
      ->capture_default_str();
  command
      ->add_option("--cell", o->cell,
                   "m a character (default 0.5) or pixel (default 0.05) of a plan")
      ->check(CLI::PositiveNumber.description(""));
  command->add_option("--reflectors", o->reflectors,
                      "a file of lines `number x y [name]`: round reflectors of 10 cm, and scans "
                      "with intensities");
  command->add_option("--people", o->simulation.people, "who walk along the same ways")
      ->check(CLI::Range(0, 1000).description(""))
      ->capture_default_str();
  command
      ->add_option("--door-period", o->simulation.door_period,
                   "s, doors of the building open and close so often; 0: doorways are empty")
      ->check(CLI::Range(0, 1000000).description(""))
      ->capture_default_str();
  command->add_option("--doors", o->doors,
                      "a file to write: the true doors and when they opened and closed");
  command->add_option("--vehicles", o->simulation.vehicles, "that drive along the same ways")
      ->check(CLI::Range(0, 1000).description(""))
      ->capture_default_str();
  command->add_flag("--satellites", o->simulation.satellites.on,
                    "fixes in bursts with outages between them; needs an .mcap");
  command->add_option("--landmarks", o->landmarks,
                      "a file of lines `x y radius` to write: where all round things truly are");
  command->add_option("--lag", o->simulation.odometry_lag, "s, odometry behind the laser")
      ->check(CLI::Range(-1.0, 1.0).description(""))
      ->capture_default_str();
  command->add_option("--bursts", o->simulation.stamp_bursts, "share of scans: stamps in bursts")
      ->check(CLI::Range(0.0, 1.0).description(""))
      ->capture_default_str();
  command->add_flag("--wrong-direction", o->simulation.robot.wrong_direction,
                    "odometry counts backing as a way ahead");
  command->add_option("--second", o->second,
                      "a second laser that looks up (upright), left, right, down or level");
  command->add_option("--nod", o->nod, "degrees, the second laser nods by that to either side")
      ->check(CLI::Range(0.0, 80.0).description(""))
      ->capture_default_str();
  command->add_option("--tilt", o->tilt, "a file of lines `seconds radians` to write: how it nods");
  command->add_option("--set", o->set,
                      "any other option: robot.slip=0.01, laser.no_return=0, satellites.jump=5, "
                      "robot.steering_stuck_for=3, simulate.felled=0.2 ...");
  command->add_flag("--json", o->json, "the summary for machines");
  command->callback([o] { run_simulate(*o); });
}

}  // namespace majak::app
