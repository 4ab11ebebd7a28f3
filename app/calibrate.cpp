// SPDX-License-Identifier: Apache-2.0
#include "app/calibrate.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "app/log_options.hpp"
#include "app/progress.hpp"
#include "app/square.hpp"
#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/source.hpp"
#include "majak/motion/drive_log.hpp"
#include "majak/motion/slip.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCalibrateHelp =
    "What is wrong with a robot's wheels, its laser's place and its clock, from an ordinary log.\n"
    "\n"
    "Examples:\n"
    "  majak calibrate my.log                       a table: value, sigma, what the log tells not\n"
    "  majak calibrate my.log -o robot.toml         and an options file for map and localize\n"
    "  majak map other.log --options robot.toml     another log of the same robot\n"
    "  majak calibrate my.log --track 0.38          wheel difference in per cent, and the track\n"
    "  majak calibrate park --wheelbase 2.83        a car: speed and steering\n"
    "  majak calibrate ends.txt --square 4          the square-path test: lines `left x y` and\n"
    "                                               `right x y`, where squares of 4 m truly ended\n"
    "                                               less where the odometry says so\n"
    "\n"
    "The log is mapped first; the poses of the finished map are what the wheels are held against.\n"
    "Drive straight on, turn to both sides, drive off and brake: what was not driven is not "
    "told.\n";

struct CalibrateOptions {
  std::string log, output;
  bool json = false;
  int threads = 0;
  double square = 0;  ///< m, side; 0: the log is an ordinary one
  io::SourceOptions source;
  motion::LogCalibrationOptions calibration;
};

struct Name {
  const char *key, *words, *unit;
  double factor;  ///< from SI
  int digits;
};
constexpr std::array<Name, motion::kUnknowns> kNames{
    {{"scale", "way per way of the wheels", "", 1, 4},
     {"turn_scale", "turn per turn of the wheels", "", 1, 4},
     {"turn_per_metre", "turn per metre, unequal wheels", "degrees/m", 180 / kPi, 3},
     {"laser_x", "laser ahead of the robot's point", "m", 1, 4},
     {"laser_y", "laser to the left of it", "m", 1, 4},
     {"laser_theta", "laser's heading", "degrees", 180 / kPi, 3},
     {"lag", "odometry later than the laser", "s", 1, 4}}};

Name name_of(std::size_t k, motion::WheelSource source) {
  if (k == 2 && source == motion::WheelSource::wheels)
    return {"steering_offset", "to be added to the steering", "degrees", 180 / kPi, 3};
  return kNames[k];
}

void print_value(const Name& name, const Learnt& learnt) {
  fmt::print("  {:<34}", name.words);
  if (!learnt.used) {
    fmt::print("not determined by this log (+- {:.{}f} {})\n", name.factor * learnt.sigma,
               name.digits, name.unit);
    return;
  }
  fmt::print("{:>10.{}f} +- {:.{}f} {}\n", name.factor * learnt.value, name.digits,
             name.factor * learnt.sigma, name.digits, name.unit);
}

void print_table(const motion::LogCalibration& found) {
  const motion::Calibration& c = found.calibration;
  fmt::print("{:.0f} m and {:.0f} full turns by {}, against the laser's poses in the map: {} steps",
             c.way, c.turned / (2 * kPi), motion::name_of(found.source), c.steps);
  if (c.left_out > 0) fmt::print(", {} of them left out", c.left_out);
  fmt::print("\n");
  if (c.correction.reversed)
    fmt::print("  the log counts backing as a way ahead; this is turned round\n");
  for (std::size_t k = 0; k < motion::kUnknowns; ++k)
    print_value(name_of(k, found.source), c.values[k]);
  const bool car = found.source == motion::WheelSource::wheels;
  if (c.length.value > 0) print_value({"", car ? "wheelbase" : "track", "m", 1, 4}, c.length);
  if (c.length.value > 0 && !car)
    print_value({"", "right wheel larger than left by", "%", 100, 3}, c.wheel_difference);
  fmt::print("  so mended, the wheels err by {:.1f} cm and {:.2f} degrees after a metre\n",
             100 * c.noise.ahead, degrees(c.noise.turn_of_way));
  for (const std::string& text : c.not_told) fmt::print("not told: {}\n", text);
}

struct Found {
  motion::LogCalibration drive;
  std::vector<motion::SlipEvent> slips;
  Time start = 0;
};

void print_slips(const Found& found) {
  for (const motion::SlipEvent& e : found.slips)
    fmt::print("{:9.2f} s: {} for {:.1f} s, {:.2f} m and {:+.1f} degrees\n",
               to_seconds(e.begin - found.start), name_of(e.kind), to_seconds(e.end - e.begin),
               e.way, degrees(e.turn));
}

Json learnt_json(const Learnt& l) {
  return {{"value", l.value}, {"sigma", l.sigma}, {"determined", l.used}};
}

Json to_json(const CalibrateOptions& o, const Found& all) {
  const motion::LogCalibration& found = all.drive;
  const motion::Calibration& c = found.calibration;
  Json json{{"log", o.log},           {"source", motion::name_of(found.source)},
            {"way_m", c.way},         {"turned_rad", c.turned},
            {"steps", c.steps},       {"left_out", c.left_out},
            {"mean_nis", c.mean_nis}, {"reversed", c.correction.reversed}};
  for (std::size_t k = 0; k < motion::kUnknowns; ++k)
    json[name_of(k, found.source).key] = learnt_json(c.values[k]);
  if (c.length.value > 0) {
    json[found.source == motion::WheelSource::wheels ? "wheelbase" : "track"] =
        learnt_json(c.length);
    if (found.source != motion::WheelSource::wheels)
      json["wheel_difference"] = learnt_json(c.wheel_difference);
  }
  const motion::StepNoise& n = c.noise;
  json["noise"] = {{"laser_m", n.laser_translation},
                   {"laser_rad", n.laser_rotation},
                   {"ahead_m_per_sqrt_m", n.ahead},
                   {"aside_m_per_sqrt_m", n.aside},
                   {"turn_rad_per_sqrt_m", n.turn_of_way},
                   {"turn_rad_per_sqrt_rad", n.turn_of_turn},
                   {"jitter_s", n.jitter}};
  json["not_told"] = c.not_told;
  json["slips"] = Json::array();
  for (const motion::SlipEvent& e : all.slips)
    json["slips"].push_back({{"kind", name_of(e.kind)},
                             {"begin_s", to_seconds(e.begin)},
                             {"end_s", to_seconds(e.end)},
                             {"way_m", e.way},
                             {"turn_deg", degrees(e.turn)}});
  return json;
}

Found calibrate(const CalibrateOptions& o) {
  slam::GraphSlamOptions options;
  options.chain.drive.wheelbase = o.calibration.wheelbase;
  slam::GraphSlam slam(options, {thread_count(o.threads)});
  motion::DriveLog drive;
  const auto source = io::open_log(o.log, o.source);
  Progress progress;
  std::int64_t scans = 0;
  while (auto event = source->next()) {
    scans += std::holds_alternative<Scan>(*event);
    drive.add(*event);
    slam.add(std::move(*event));
    progress.show("reading and matching", scans);
  }
  progress.show("closing loops and refining", scans);
  try {
    const Site site = slam.finish().site;
    Found found{motion::calibrate_log(drive, site, o.calibration), {}, site.scans[0].scan.time};
    found.slips = motion::find_slips(drive, site, found.drive, o.calibration.wheelbase);
    return found;
  } catch (const Error& e) {  // it does not know whose wheels these are
    throw Error(fmt::format("{}: {}", o.log, e.what()));
  }
}

void run_calibrate(const CalibrateOptions& o) {
  if (o.square > 0) return run_square({o.log, o.square, o.calibration.track, o.output, o.json});
  const Found found = calibrate(o);
  if (!o.output.empty()) {
    OptionFields fields;
    motion::DriveCorrection correction = found.drive.calibration.correction;
    motion::describe(fields, correction);
    io::write_file_atomically(o.output, io::options_toml(fields));
  }
  if (o.json) {
    fmt::print("{}\n", to_json(o, found).dump(2));
    return;
  }
  print_table(found.drive);
  print_slips(found);
  if (!o.output.empty()) fmt::print("options: {}\n", o.output);
}

}  // namespace

void add_calibrate(CLI::App& app) {
  auto o = std::make_shared<CalibrateOptions>();
  CLI::App* command = app.add_subcommand("calibrate", kCalibrateHelp);
  command->add_option("LOG", o->log, "a log or recording with odometry, or with speed and steering")
      ->required();
  add_log_options(*command, o->source);
  command->add_option("-o,--output", o->output, "options file for majak map and majak localize");
  command
      ->add_option("--track", o->calibration.track,
                   "m between the wheels, as the robot's odometry believes")
      ->check(CLI::PositiveNumber.description(""));
  command->add_option("--wheelbase", o->calibration.wheelbase, "m, of a car: speed and steering")
      ->check(CLI::PositiveNumber.description(""));
  command->add_option("--square", o->square, "m, side of the squares: LOG lists where they ended")
      ->check(CLI::PositiveNumber.description(""));
  command->add_option("--threads", o->threads, "threads to use (default: all)")
      ->check(CLI::Range(1, 1024));
  command->add_flag("--json", o->json, "print JSON");
  command->callback([o] { run_calibrate(*o); });
}

}  // namespace majak::app
