// SPDX-License-Identifier: Apache-2.0
#include "app/demo.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/input.hpp"
#include "app/known_place.hpp"
#include "app/log_options.hpp"
#include "app/progress.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/demonstration_figures.hpp"
#include "majak/draw/demonstration_report.hpp"
#include "majak/eval/demonstration.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/landmark_file.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/tum.hpp"
#include "majak/sim/park.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;
using eval::Against;
using eval::Feed;

constexpr const char* kDemoHelp =
    "The demonstration of the thesis: EKF-SLAM and the landmark graph on a car's laser, wheels "
    "and\n"
    "satellites; without the satellites, with them, and with them cut off for minutes.\n"
    "\n"
    "Examples:\n"
    "  majak demo thesis                  in a simulated park, where the truth is known exactly\n"
    "  majak demo thesis victoria_park    on real data: folder with LASER.txt, DRS.txt, GPS.txt\n"
    "  majak demo thesis my.mcap --antenna 0.5,0 --heading 90     on any log with scans, wheels, "
    "fixes\n"
    "  majak demo thesis park.mcap --landmarks trunks.txt         as majak simulate park "
    "--satellites --landmarks trunks.txt made it\n"
    "\n"
    "Writes report.html (errors over time and range, landmarks with ellipses, NEES and NIS, what\n"
    "happened), demonstration.png and .svg, trajectory.tum, landmarks.csv, options.toml.\n";

struct DemoCommand {
  std::string name, log, output, antenna, landmarks, options_file;
  double heading = 36, cut_off = 300;
  int seed = 1;
  std::vector<std::string> set;
  io::SourceOptions source;
  slam::EkfSlamOptions ekf;
  slam::LandmarkGraphOptions graph;
};

void describe(OptionFields& fields, DemoCommand& o) {
  slam::describe(fields, o.ekf);
  slam::describe(fields, o.graph);
}

std::vector<Event> read_events(const DemoCommand& o, Progress& progress) {
  Input source(o.log, o.source, {}, "", progress);
  std::vector<Event> events;
  while (auto event = source.next()) {
    events.push_back(std::move(*event));
    progress.show("reading", static_cast<std::int64_t>(events.size()));
  }
  return events;
}

std::vector<Event> simulated(DemoCommand& o, std::vector<Vec2>& trunks) {
  sim::SimulationOptions options;
  sim::make_car(options);
  options.seed = o.seed;
  options.beams = 361, options.scan_rate = 5;
  options.robot.reports_steering = true;
  options.satellites.on = true;
  o.ekf.wheelbase = options.robot.wheelbase;
  const sim::World world(sim::park());
  for (const sim::Disc& disc : world.scene().discs) trunks.push_back(disc.centre);
  return sim::simulate(world, sim::plan_tour(world), options);
}

Vec2 antenna_of(const std::string& text) {
  const Pose2 at = start_pose(text + ",0");
  return at.translation();
}

std::string landmarks_csv(const std::vector<slam::MappedLandmark>& landmarks) {
  std::string text = "x,y,var_x,cov_xy,var_y,diameter,sightings,gone\n";
  for (const slam::MappedLandmark& l : landmarks)
    text += fmt::format("{:.4f},{:.4f},{:.3e},{:.3e},{:.3e},{:.3f},{},{}\n", l.p_map.x(),
                        l.p_map.y(), l.covariance(0, 0), l.covariance(0, 1), l.covariance(1, 1),
                        l.diameter, l.sightings, l.gone ? 1 : 0);
  return text;
}

void print_line(const char* what, bool graph, const eval::Headline& h) {
  if (h.stats.count == 0) return;
  fmt::print("  {:<52} {:<6} {:.2f} m ({:.2f} to {:.2f}), median {:.2f}, max {:.1f}\n", what,
             graph ? "graph" : "EKF", h.mean.mean, h.mean.low, h.mean.high, h.stats.median,
             h.stats.max);
}

void print_result(const DemoCommand& o, const eval::Demonstration& d) {
  fmt::print("{}: {} fixes in {} bursts, {} landmarks\n", o.log.empty() ? "simulated park" : o.log,
             d.fixes.fixes.size(), d.fixes.bursts, d.with_all().graph.map.landmarks.size());
  fmt::print("mean error of the place (95 % of the mean)\n");
  constexpr std::pair<Feed, Against> kScores[] = {
      {Feed::none, Against::aligned},  {Feed::none, Against::first_pose},
      {Feed::fold, Against::held_out}, {Feed::cut_off, Against::held_out},
      {Feed::all, Against::held_out},  {Feed::all, Against::fed}};
  for (const auto& [feed, against] : kScores)
    for (const bool graph : {false, true})
      print_line(fmt::format("{}, {}", eval::name_of(feed), eval::name_of(against)).c_str(), graph,
                 eval::headline(eval::pooled(d, feed, against, graph)));
  fmt::print("mean error of the obstacles\n");
  for (const bool graph : {false, true}) {
    const auto& obstacles = (graph ? d.with_all().graph : d.with_all().ekf).obstacles;
    if (obstacles.match)
      print_line("against the true trunks", graph, eval::headline(*obstacles.match, d.trunks));
    if (obstacles.maps)
      print_line("between maps of even and odd minutes", graph, eval::headline(*obstacles.maps));
  }
  fmt::print("CPU: EKF {:.2f} s, graph {:.2f} s\n", d.alone().ekf.cpu, d.alone().graph.cpu);
  fmt::print("open: {}\n      {}\n", (fs::path(o.output) / "report.html").string(),
             (fs::path(o.output) / "demonstration.png").string());
}

void write_results(DemoCommand& o, const eval::Demonstration& d) {
  const fs::path folder = o.output;
  OptionFields fields;
  describe(fields, o);
  const auto& map = d.with_all().graph.map;
  const std::string name = o.log.empty() ? "A simulated park" : fs::path(o.log).filename().string();
  io::write_file_atomically(folder / "options.toml", io::options_toml(fields));
  io::write_file_atomically(folder / "trajectory.tum",
                            io::estimates_tum(map.localization.estimates));
  io::write_file_atomically(folder / "landmarks.csv", landmarks_csv(map.landmarks));
  write_figure(folder, "demonstration", draw::demonstration_picture(d));
  io::write_file_atomically(folder / "report.html", draw::demonstration_html(d, {name, ""}));
}

void run_demo(DemoCommand& o) {
  if (o.name != "thesis") throw Error("demo " + o.name + ": there is only thesis");
  if (o.output.empty()) o.output = o.log.empty() ? "thesis-demo" : results_folder(o.log, "-demo");
  OptionFields fields;
  describe(fields, o);
  if (!o.options_file.empty()) io::apply_options_file(fields, o.options_file);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  make_folder(o.output);
  Progress progress;
  std::vector<Vec2> trunks;
  const auto events = o.log.empty() ? simulated(o, trunks) : read_events(o, progress);
  if (!o.landmarks.empty()) trunks = io::read_landmarks(o.landmarks);
  eval::DemonstrationOptions options;
  options.ekf = o.ekf, options.graph = o.graph;
  if (!o.antenna.empty()) options.antenna = antenna_of(o.antenna);
  options.heading = radians(o.heading);
  options.cut_off = o.cut_off;
  options.trunks = trunks;
  options.clock = cpu_seconds;
  options.progress = [&](const char* run, std::int64_t scans) { progress.show(run, scans); };
  const eval::Demonstration d = eval::demonstrate(events, options);
  progress.clear();
  write_results(o, d);
  print_result(o, d);
}

}  // namespace

void add_demo(CLI::App& app) {
  auto o = std::make_shared<DemoCommand>();
  CLI::App* command = app.add_subcommand("demo", kDemoHelp);
  command->add_option("NAME", o->name, "thesis")->required();
  command->add_option("LOG", o->log, "a log or folder; none: a simulated park");
  command->add_option("-o,--output", o->output, "folder for the results (default: thesis-demo...)");
  command->add_option("--antenna", o->antenna,
                      "where it is on the robot, x,y in m (default: 3.6,0.6, Victoria Park's)");
  command
      ->add_option("--heading", o->heading,
                   "degrees from east at the start, where satellites are not used")
      ->capture_default_str();
  command->add_option("--landmarks", o->landmarks,
                      "where the obstacles truly are: lines `x y radius`, m, in the truth's frame");
  command
      ->add_option("--cut-off", o->cut_off,
                   "s without satellites, in the middle of the log; at most a third of it")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--seed", o->seed, "of the simulated park")->capture_default_str();
  add_log_options(*command, o->source);
  command->add_option("--options", o->options_file, "options.toml of a run");
  command->add_option("--set", o->set, "one option: name=value");
  command->callback([o] { run_demo(*o); });
}

}  // namespace majak::app
