// SPDX-License-Identifier: Apache-2.0
#include "app/localize.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/input.hpp"
#include "app/known_place.hpp"
#include "app/live.hpp"
#include "app/log_options.hpp"
#include "app/progress.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/trajectory_figure.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/beacon_map.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/source.hpp"
#include "majak/io/summary.hpp"
#include "majak/io/tum.hpp"
#include "majak/methods/methods.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kLocalizeHelp =
    "Where the robot was, by any one method of localization. On a known map it is found by "
    "itself,\n"
    "tracked, and found again when it was carried away.\n"
    "\n"
    "Examples:\n"
    "  majak localize my.log --map hall             on the map of a run (its folder)\n"
    "  majak localize my.log --map hall.yaml        on a map of others: PGM or PNG and its YAML\n"
    "  majak localize my.log --map plan.png --map-resolution 0.02     a picture, metres a pixel\n"
    "  majak localize --live /dev/ttyUSB0 --map hall                  a device, until Ctrl-C\n"
    "  majak localize my.log                        dead reckoning, writes the folder my-localize\n"
    "  majak localize my.log --method kalman        wheels, satellites, smoothed\n"
    "  majak localize my.log --method kalman --gps track.nmea     the fixes of another file\n"
    "  majak localize my.log --method kalman --beacons hall.txt   reflectors at known places\n"
    "  majak localize my.log --start \"2.5,1,90\"     from x, y (m) and heading (degrees)\n"
    "  majak localize my.log --options drive.toml   with options of a run or of a calibration\n"
    "\n"
    "The folder holds trajectory.png and .svg, trajectory.tum, covariance.csv (with the health of\n"
    "each pose), hypotheses.csv where a method keeps several, summary.json and options.toml.\n"
    "\n"
    "Methods:\n";

struct LocalizeCommand {
  std::string log, live, output, method, start, options_file, beacons, map, on = "grid";
  std::vector<std::string> set;
  bool json = false;
  double map_resolution = 0;  // m a pixel, of a bare picture
  Pose2 T_world_map;          // of a map file whose picture lies turned
  DeviceOptions device;
  io::SourceOptions source;
  methods::LocalizeOptions options;
};

/// A finished run and what the log knows besides.
struct LocalizedRun {
  localize::Localization result;
  std::vector<Truth> truth;
  std::vector<GpsFix> fixes;
};

/// What is said of a run.
struct Findings {
  double path_m = 0, end_sigma_m = 0, end_heading_sigma_rad = 0;
  Estimate end;
  struct Sensor {
    std::int64_t used = 0, rejected = 0;
    double nis = 0, dof = 0;  // sums over the used ones
  };
  std::map<std::string, Sensor> sensors;
  std::int64_t health[3] = {};    // ok, degraded, lost
  std::optional<double> found_s;  // from the first estimate to the first that is not lost
  std::optional<eval::AbsoluteError> error;  // against the truth, from a common start
};

std::string localize_help() {
  std::string text = kLocalizeHelp;
  for (const methods::Method& m : methods::methods())
    text += fmt::format("  {:<16} {}; needs {}; yields {}\n", m.name, m.in_the_thesis, m.needs,
                        m.yields);
  return text;
}

void read_place(LocalizeCommand& o) {
  const KnownPlace known = read_known_place(o.map, o.map_resolution, o.on);
  o.options.place = known.place;
  o.T_world_map = known.T_world_map;
}

/// Out of the map's own frame.
void to_world(const Pose2& T_world_map, localize::Localization& result) {
  if (T_world_map == Pose2{}) return;
  const double c = std::cos(T_world_map.theta), s = std::sin(T_world_map.theta);
  Mat3 turn = Mat3::Identity();
  turn.topLeftCorner<2, 2>() << c, -s, s, c;
  for (Estimate& e : result.estimates) {
    e.T_map_robot = T_world_map * e.T_map_robot;
    e.covariance = turn * e.covariance * turn.transpose();
    e.weak_direction = turn.topLeftCorner<2, 2>() * e.weak_direction;
  }
  for (auto& at : result.hypotheses)
    for (localize::Hypothesis& h : at.hypotheses) {
      h.T_map_robot = T_world_map * h.T_map_robot;
      h.covariance = turn * h.covariance * turn.transpose();
    }
}

void read_options(LocalizeCommand& o) {
  OptionFields fields;
  methods::describe(fields, o.options);
  if (!o.options_file.empty()) io::apply_options_file(fields, o.options_file);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  if (!o.map.empty()) read_place(o);
  if (!o.start.empty()) o.options.start = o.T_world_map.inverse() * start_pose(o.start);
  if (!o.beacons.empty()) o.options.beacons = io::read_beacon_map(o.beacons);
}

std::string effective_options(LocalizeCommand& o) {
  OptionFields fields;
  methods::describe(fields, o.options);
  return io::options_toml(fields);
}

/// One line a pose, for whoever reads along: time x y theta sigma health.
void say_live(const Estimate& e, const Pose2& T_world_map) {
  const Pose2 at = T_world_map * e.T_map_robot;
  fmt::print("{:.3f} {:.3f} {:.3f} {:.4f} {:.3f} {}\n", to_seconds(e.time), at.x, at.y, at.theta,
             least_known(e.covariance).sigma, name_of(e.health));
  std::fflush(stdout);
}

LocalizedRun run_method(const LocalizeCommand& o) {
  const methods::Method& method = methods::method(o.method);
  const localize::Localizer localizer = method.make(o.options);
  LocalizedRun run;
  Progress progress;
  Input source(o.log, o.source, o.device, "", progress);
  std::int64_t events = 0;
  motion::CorrectedDrive drive(o.options.drive);
  while (auto event = source.next()) {
    drive.apply(*event);
    if (const auto* truth = std::get_if<Truth>(&*event)) run.truth.push_back(*truth);
    if (const auto* fix = std::get_if<GpsFix>(&*event)) run.fixes.push_back(*fix);
    const auto newest = localizer.add(*event);
    if (!source.live())
      progress.show("localizing", ++events);
    else if (newest)
      say_live(*newest, o.T_world_map);
  }
  run.result = localizer.finish();
  for (const auto& [what, entry] : source.report().entries()) run.result.report.add(what, entry);
  to_world(o.T_world_map, run.result);
  if (run.result.estimates.empty())
    throw Error(fmt::format("{}: {} needs {}; majak info tells what is in the log", o.log, o.method,
                            method.needs));
  return run;
}

eval::Trajectory trajectory_of(const std::vector<Estimate>& estimates) {
  eval::Trajectory trajectory;
  for (const Estimate& e : estimates) trajectory.push_back({e.time, e.T_map_robot});
  return trajectory;
}

Findings findings_of(const LocalizedRun& run) {
  Findings f;
  const auto& estimates = run.result.estimates;
  for (std::size_t i = 1; i < estimates.size(); ++i)
    f.path_m +=
        (estimates[i].T_map_robot.translation() - estimates[i - 1].T_map_robot.translation())
            .norm();
  f.end = estimates.back();
  f.end_sigma_m = least_known(f.end.covariance).sigma;
  f.end_heading_sigma_rad = std::sqrt(std::max(0.0, f.end.covariance(2, 2)));
  for (const Estimate& e : estimates) {
    ++f.health[static_cast<int>(e.health)];
    if (!f.found_s && e.health != Health::lost)
      f.found_s = to_seconds(e.time - estimates.front().time);
  }
  for (const localize::Innovation& i : run.result.innovations) {
    Findings::Sensor& sensor = f.sensors[i.sensor];
    ++(i.used ? sensor.used : sensor.rejected);
    if (!i.used) continue;
    sensor.nis += i.nis;
    sensor.dof += i.dof;
  }
  const auto associated = eval::associate(trajectory_of(estimates), eval::truth_of(run.truth));
  if (!associated.pairs.empty())
    f.error = eval::absolute_error(associated.pairs, eval::Alignment::first_pose);
  return f;
}

Json summary_of(const LocalizeCommand& o, const LocalizedRun& run, const Findings& f) {
  const Pose2& end = f.end.T_map_robot;
  Json json = {{"log", fs::path(o.log).filename().string()},
               {"method", o.method},
               {"estimates", run.result.estimates.size()},
               {"path_m", f.path_m},
               {"end", {{"x_m", end.x}, {"y_m", end.y}, {"theta_rad", end.theta}}},
               {"end_sigma_m", f.end_sigma_m},
               {"end_heading_sigma_rad", f.end_heading_sigma_rad},
               {"ok", f.health[0]},
               {"degraded", f.health[1]},
               {"lost", f.health[2]},
               {"innovations", Json::object()},
               {"learnt", Json::object()},
               {"skipped", Json::object()}};
  if (f.found_s) json["found_after_s"] = *f.found_s;
  for (const localize::PhaseTime& p : run.result.phases) json["phases"][p.name] = p.seconds;
  for (const localize::LearntValue& v : run.result.learnt)
    json["learnt"][v.name] = {{"value", v.value}, {"sigma", v.sigma}, {"unit", v.unit}};
  for (const auto& [name, s] : f.sensors)
    json["innovations"][name] = {
        {"used", s.used},
        {"rejected", s.rejected},
        {"nis_mean", s.used > 0 ? s.nis / static_cast<double>(s.used) : 0},
        {"nis_expected", s.used > 0 ? s.dof / static_cast<double>(s.used) : 0}};
  for (const auto& [what, entry] : run.result.report.entries()) json["skipped"][what] = entry.count;
  if (f.error)
    json["error"] = {{"against", "the log's own truth, from a common start"},
                     {"count", f.error->translation.count},
                     {"translation_mean_m", f.error->translation.mean},
                     {"translation_rms_m", f.error->translation.rms},
                     {"translation_max_m", f.error->translation.max},
                     {"rotation_mean_deg", degrees(f.error->rotation.mean)}};
  return json;
}

/// The truth is laid onto the first estimate that has its like in it; fixes are drawn where the
/// method uses them, since only then are they in its frame.
draw::Figure picture_of(const LocalizeCommand& o, const LocalizedRun& run) {
  draw::PathPicture picture;
  if (o.options.place)
    for (const map::Surfel& s : o.options.place->surfaces.surfels())
      picture.walls.push_back(o.T_world_map * Vec2(s.x, s.y));
  picture.title = fs::path(o.log).filename().string() + ", " + o.method;
  picture.path_name = o.method;
  picture.estimates = run.result.estimates;
  const auto associated =
      eval::associate(trajectory_of(run.result.estimates), eval::truth_of(run.truth));
  if (!associated.pairs.empty()) {
    const eval::PosePair& first = associated.pairs.front();
    const Pose2 T_map_world = first.T_map_robot * first.T_reference_robot.inverse();
    for (const Truth& t : run.truth) picture.truth.push_back(T_map_world * t.T_world_robot);
  }
  const auto uses_gps = [](const localize::Innovation& i) {
    return std::string_view(i.sensor) == "gps";
  };
  if (std::any_of(run.result.innovations.begin(), run.result.innovations.end(), uses_gps))
    picture.fixes = run.fixes;
  return draw::path_picture(picture);
}

std::string hypotheses_csv(const std::vector<localize::HypothesesAt>& all) {
  std::string text = "time,probability,x,y,theta\n";
  for (const auto& at : all)
    for (const localize::Hypothesis& h : at.hypotheses)
      text += fmt::format("{:.6f},{:.6f},{:.4f},{:.4f},{:.5f}\n", to_seconds(at.time),
                          h.probability, h.T_map_robot.x, h.T_map_robot.y, h.T_map_robot.theta);
  return text;
}

void write_results(LocalizeCommand& o, const LocalizedRun& run, const Json& summary) {
  const fs::path folder = o.output;
  make_folder(folder);
  const auto& estimates = run.result.estimates;
  io::write_file_atomically(folder / "trajectory.tum", io::estimates_tum(estimates));
  io::write_file_atomically(folder / "covariance.csv", io::covariance_csv(estimates));
  if (!run.result.hypotheses.empty())
    io::write_file_atomically(folder / "hypotheses.csv", hypotheses_csv(run.result.hypotheses));
  io::write_file_atomically(folder / "options.toml", effective_options(o));
  io::write_file_atomically(folder / "summary.json", summary.dump(2) + "\n");
  write_figure(folder, "trajectory", picture_of(o, run));
}

/// In how far the map told where the robot was; where it did not, what could be.
void print_health(const LocalizedRun& run, const Findings& f) {
  if (!f.found_s) {
    fmt::print(
        "  never sure where on the map the robot is: is it this place, and is the scale right?\n");
  } else {
    fmt::print("  found after {:.1f} s; {} poses ok, {} degraded, {} lost\n", *f.found_s,
               f.health[0], f.health[1], f.health[2]);
  }
  if (f.end.health == Health::lost && !run.result.hypotheses.empty()) {
    const auto& last = run.result.hypotheses.back().hypotheses;
    for (std::size_t k = 0; k < std::min<std::size_t>(last.size(), 3); ++k)
      fmt::print("  {} with {:.0f} %: x {:.2f} m, y {:.2f} m, {:.0f} degrees\n",
                 k == 0 ? "at the end it could be" : "                    or",
                 100 * last[k].probability, last[k].T_map_robot.x, last[k].T_map_robot.y,
                 degrees(last[k].T_map_robot.theta));
    if (last.size() > 1 && last[1].probability > 0.2 * last[0].probability)
      fmt::print("  these places look alike; drive on, or say --start\n");
  }
  if (run.result.phases.empty()) return;
  double whole = 0;
  for (const localize::PhaseTime& p : run.result.phases) whole += p.seconds;
  fmt::print("  {:.3f} ms a scan:", 1e3 * whole / static_cast<double>(run.result.estimates.size()));
  for (const localize::PhaseTime& p : run.result.phases)
    fmt::print(" {} {:.3f}", p.name,
               1e3 * p.seconds / static_cast<double>(run.result.estimates.size()));
  fmt::print("\n");
}

void print_result(const LocalizeCommand& o, const LocalizedRun& run, const Findings& f) {
  const Pose2& end = f.end.T_map_robot;
  fmt::print("{}: {} estimates along {:.1f} m\n", o.method, run.result.estimates.size(), f.path_m);
  fmt::print(
      "  ends at x {:.3f} m, y {:.3f} m, {:.2f} degrees; sigma {:.3f} m (the larger axis), "
      "{:.2f} degrees\n",
      end.x, end.y, degrees(end.theta), f.end_sigma_m, degrees(f.end_heading_sigma_rad));
  if (o.options.place) print_health(run, f);
  for (const auto& [name, s] : f.sensors) {
    fmt::print("  {}: {} used, {} beyond the gate", name, s.used, s.rejected);
    if (s.used > 0)
      fmt::print(", NIS {:.2f} ({:.2f} expected)", s.nis / static_cast<double>(s.used),
                 s.dof / static_cast<double>(s.used));
    fmt::print("\n");
  }
  for (const localize::LearntValue& v : run.result.learnt)
    fmt::print("  {}: {:.4g} +- {:.2g} {}\n", v.name, v.value, v.sigma,
               v.unit == "1" ? "" : v.unit);
  if (f.error)
    fmt::print(
        "  against the truth in the log, from a common start: mean {:.3f} m and {:.2f} "
        "degrees, at most {:.3f} m\n",
        f.error->translation.mean, degrees(f.error->rotation.mean), f.error->translation.max);
  for (const auto& [what, entry] : run.result.report.entries())
    fmt::print("  {} x {}{}\n", entry.count, what,
               entry.first_line > 0 ? fmt::format(" (first: line {})", entry.first_line) : "");
  fmt::print("results: {}\n", o.output);
}

void run_localize(LocalizeCommand& o) {
  if (!o.live.empty()) o.log = o.live;
  if (o.log.empty()) throw Error("localize: name a LOG, or a device with --live PORT");
  if (o.method.empty()) o.method = o.map.empty() ? "dead-reckoning" : "global";
  o.options.clock = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  read_options(o);
  if (o.output.empty()) o.output = results_folder(o.log, "-localize");
  const LocalizedRun run = run_method(o);
  const Findings findings = findings_of(run);
  const Json summary = summary_of(o, run, findings);
  write_results(o, run, summary);
  if (o.json)
    fmt::print("{}\n", summary.dump(2));
  else
    print_result(o, run, findings);
}

}  // namespace

void add_localize(CLI::App& app) {
  auto o = std::make_shared<LocalizeCommand>();
  CLI::App* command = app.add_subcommand("localize", localize_help());
  command->add_option("LOG", o->log, "a log or recording of any kind");
  command->add_option("--map", o->map,
                      "a known map: folder of a run, site.majak, YAML with PGM or PNG, picture");
  command->add_option("--map-resolution", o->map_resolution, "m a pixel, of a bare picture");
  command->add_option("--on", o->on, "grid, or segments: what of a run's map to localize on")
      ->check(CLI::IsMember({"grid", "segments"}));
  command->add_option("--live", o->live, "a device instead of a log: serial port or tcp://HOST");
  add_device_options(*command, o->device);
  add_log_options(*command, o->source);
  command->add_option("--method", o->method,
                      "one of those above (default: global with --map, else dead-reckoning)");
  command->add_option("-o,--output", o->output,
                      "folder for the results (default: the log's name + -localize)");
  command->add_option("--start", o->start, "first pose: x,y in m and degrees (default: 0,0,0)");
  command->add_option("--beacons", o->beacons, "where beacons stand: lines `number x y [name]`, m");
  command->add_option("--options", o->options_file, "options.toml of a run");
  command->add_option("--set", o->set, "one option: name=value");
  command->add_flag("--json", o->json, "print summary.json");
  command->callback([o] { run_localize(*o); });
}

}  // namespace majak::app
