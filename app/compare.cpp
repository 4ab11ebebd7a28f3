// SPDX-License-Identifier: Apache-2.0
#include "app/compare.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "app/compare_mapping.hpp"
#include "app/input.hpp"
#include "app/known_place.hpp"
#include "app/log_options.hpp"
#include "app/progress.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/comparison_figure.hpp"
#include "majak/eval/compare.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/options_file.hpp"
#include "majak/methods/methods.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr double kInFrame = 0.5;  // share of returns on the map from which on truth is believed

constexpr const char* kCompareHelp =
    "Methods side by side. Without --map those that make a map: table 2 of the thesis, each word "
    "with a\n"
    "measurement. With --map those that localize on it: error, time, memory, health, and how soon "
    "they\n"
    "know that they were carried away.\n"
    "\n"
    "Examples:\n"
    "  majak compare                                 in simulated places with truth; open "
    "compare/table2.html\n"
    "  majak compare my.log                          variations of a log; also --truth, "
    "--relations\n"
    "  majak compare --methods hybrid --only ring    one method, one group of runs\n"
    "  majak compare my.log --map hall              hall: a run of this very log; its poses are "
    "the "
    "truth\n"
    "  majak compare my.log --map hall.yaml --truth truth.tum     truth in the map's frame, TUM "
    "lines\n"
    "  majak compare my.log --map hall --methods monte-carlo,markov\n"
    "  majak compare my.log --map hall.yaml --start \"2.5,1,90\"     for those that must be told "
    "where\n"
    "\n"
    "Without --map: writes table2.html, table2.md, table2.json, options.toml. Groups of runs: "
    "seeds,\n"
    "wheels, no-wheels, straight, ring, nested, stray, crowd, size; of a log those that it can be "
    "made to.\n"
    "\n"
    "With --map: writes compare.csv, compare.png and .svg, options.toml. Without --truth, the "
    "poses of a run "
    "of "
    "the\n"
    "same log are the truth, else what the log itself tells; none: columns of errors stay empty.\n"
    "\n"
    "Carried away: the log jumps from a third to two thirds of its scans while the wheels go on as "
    "if\n"
    "nothing had been. An update is a scan after 0.2 m or 0.2 rad; right is within 0.5 m and 10 "
    "degrees.\n"
    "\n"
    "Methods with --map (all is those on a map, and dead-reckoning as the floor):\n";

struct CompareCommand {
  std::string log, output, map, truth, start, options_file, methods = "all";
  std::vector<std::string> set;
  double map_resolution = 0;  // m a pixel, of a bare picture
  io::SourceOptions source;
  methods::LocalizeOptions options;
  MappingCompareCommand mapping;
};

/// The log and all that is known of where the robot was.
struct Inputs {
  std::vector<Event> events;
  KnownPlace known;
  eval::Trajectory truth;  // map frame
  std::string truth_is;    // for people
};

std::string help() {
  std::string text = kCompareHelp;
  for (const methods::Method& m : methods::methods())
    if (m.on_map || std::string_view(m.name) == "dead-reckoning")
      text += fmt::format("  {:<16} {}\n", m.name, m.in_the_thesis);
  return text + "Methods without --map:\n" + mapping_methods_help();
}

std::vector<std::string> chosen_methods(const std::string& list) {
  std::vector<std::string> names;
  if (list == "all") {
    for (const methods::Method& m : methods::methods())
      if (m.on_map) names.emplace_back(m.name);
    names.emplace_back("dead-reckoning");
    return names;
  }
  std::istringstream in(list);
  for (std::string name; std::getline(in, name, ',');)
    names.emplace_back(methods::method(name).name);
  if (names.empty()) throw Error("--methods: name some, as in global,markov");
  return names;
}

std::vector<Event> read_events(const CompareCommand& o, Progress& progress) {
  Input source(o.log, o.source, {}, "", progress);
  motion::CorrectedDrive drive(o.options.drive);
  std::vector<Event> events;
  bool scans = false;
  while (auto event = source.next()) {
    drive.apply(*event);
    scans = scans || std::holds_alternative<Scan>(*event);
    events.push_back(std::move(*event));
    progress.show("reading", static_cast<std::int64_t>(events.size()));
  }
  if (!scans)
    throw Error(fmt::format("{}: no scan in it; majak info tells what is in the log", o.log));
  return events;
}

/// In the frame that it comes in.
eval::Trajectory told_truth(const CompareCommand& o, Inputs& in) {
  if (!o.truth.empty()) {
    Report report;
    in.truth_is = o.truth;
    return eval::read_tum(o.truth, report);
  }
  if (in.known.site)
    if (auto path = eval::path_of_same_log(*in.known.site, in.events)) {
      in.truth_is = "the map's own run of this log: in how far they come back to its poses";
      return *path;
    }
  std::vector<Truth> truth;
  for (const Event& event : in.events)
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
  in.truth_is = truth.empty() ? "none at hand, so no errors" : "the log's own";
  return eval::truth_of(truth);
}

void find_truth(const CompareCommand& o, Inputs& in) {
  eval::Trajectory truth = told_truth(o, in);
  for (eval::StampedPose& p : truth) p.pose = in.known.T_world_map.inverse() * p.pose;
  const double share = eval::share_on_map(*in.known.place, in.events, truth);
  if (share >= kInFrame) {
    in.truth = std::move(truth);
  } else if (!truth.empty()) {
    in.truth_is += fmt::format(
        ", not used: {:.0f} % of what is seen from there lies on the map; is it in its frame?",
        100 * share);
  }
}

Inputs read_inputs(CompareCommand& o, Progress& progress) {
  OptionFields fields;
  methods::describe(fields, o.options);
  if (!o.options_file.empty()) io::apply_options_file(fields, o.options_file);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  Inputs in;
  in.known = read_known_place(o.map, o.map_resolution);
  o.options.place = in.known.place;
  in.events = read_events(o, progress);
  find_truth(o, in);
  if (!o.start.empty())
    o.options.start = in.known.T_world_map.inverse() * start_pose(o.start);
  else if (!in.truth.empty())
    o.options.start = in.truth.front().pose;
  return in;
}

/// Those that must be told the start are left out where it is not known.
std::vector<std::string> leave_out(const CompareCommand& o, const Inputs& in,
                                   const std::vector<std::string>& names) {
  std::vector<std::string> kept;
  for (const std::string& name : names)
    if (methods::method(name).told && o.start.empty() && in.truth.empty())
      fmt::print("{} left out: it must be told where it starts, by --start or --truth\n", name);
    else
      kept.push_back(name);
  if (kept.empty()) throw Error("compare: no method is left");
  return kept;
}

std::string bytes_text(std::size_t bytes) {
  const auto b = static_cast<double>(bytes);
  return b < 1e4   ? fmt::format("{:.0f} B", b)
         : b < 1e6 ? fmt::format("{:.0f} kB", b / 1e3)
                   : fmt::format("{:.1f} MB", b / 1e6);
}

std::string spread_text(const std::optional<eval::Spread>& s, double scale, int digits) {
  return s ? fmt::format("{:.{}f} {:.{}f}", scale * s->median, digits, scale * s->p95, digits) : "";
}

std::string count_text(const std::optional<int>& count) {
  return count ? fmt::format("{}", *count) : "never";
}

void print_row(const eval::Comparison& c, const eval::MethodResult& r) {
  const auto n = static_cast<double>(r.estimates.size());
  const auto percent = [&](int k) { return 100.0 * static_cast<double>(r.health[k]) / n; };
  const double whole = r.cpu_mean * static_cast<double>(c.scans);
  fmt::print("{:<15} {:>13} {:>12} {:>6} {:>9} {:>8} {:>8} {:>8} {:>15} {:>6}", r.method,
             spread_text(r.translation, 1, 3), spread_text(r.rotation, degrees(1), 2),
             r.wrong ? fmt::format("{:.1f}", 100 * *r.wrong) : "",
             fmt::format("{:.3f}", 1e3 * r.cpu_mean),
             fmt::format("{:.0f}", static_cast<double>(r.updates) / whole),
             bytes_text(r.belief_median), bytes_text(r.belief_most),
             fmt::format("{:.1f} {:.1f} {:.1f}", percent(0), percent(1), percent(2)),
             r.told ? "told" : count_text(r.found));
  if (r.recovery && r.recovery->knew)
    fmt::print(" {:>6} {:>6}", count_text(r.recovery->told_lost),
               count_text(r.recovery->right_again));
  fmt::print("\n");
}

void print_table(const CompareCommand& o, const Inputs& in, const eval::Comparison& c) {
  fmt::print("{} scans, {} updates; truth: {}\n\n", c.scans, c.updates, in.truth_is);
  fmt::print("{:<15} {:>13} {:>12} {:>6} {:>9} {:>8} {:>17} {:>15} {:>6} {:>6} {:>6}\n", "",
             "error, m", "degrees", "wrong", "CPU, ms", "updates", "belief", "ok degr. lost",
             "found", "lost", "right");
  fmt::print("{:<15} {:>13} {:>12} {:>6} {:>9} {:>8} {:>8} {:>8} {:>15} {:>6} {:>13}\n", "method",
             "median 95 %", "median 95 %", "ok, %", "a scan", "a second", "median", "at most",
             "% of scans", "after", "after a jump");
  for (const eval::MethodResult& r : c.methods) print_row(c, r);
  for (const std::string& why : c.left_out) fmt::print("left out: {}\n", why);
  fmt::print(
      "\nErrors are of poses not said to be lost. Belief: pose and covariance, hypotheses, ");
  fmt::print("particles with weights, or cells;\nnot the map. Found, lost and right: in updates. ");
  if (!c.splice) fmt::print("No jump: the log is too short for one, or goes nowhere else.");
  fmt::print("\nresults: {}\n", o.output);
}

void write_results(CompareCommand& o, const Inputs& in, const eval::Comparison& c) {
  const fs::path folder = o.output;
  make_folder(folder);
  OptionFields fields;
  methods::describe(fields, o.options);
  io::write_file_atomically(folder / "options.toml", io::options_toml(fields));
  io::write_file_atomically(folder / "compare.csv", eval::comparison_csv(c));
  draw::ComparisonPicture picture{fs::path(o.log).filename().string(), c, in.truth, {}};
  for (const map::Surfel& s : in.known.place->surfaces.surfels())
    picture.walls.emplace_back(s.x, s.y);
  write_figure(folder, "compare", draw::comparison_picture(picture));
}

void run_compare(CompareCommand& o) {
  if (o.map.empty()) {
    MappingCompareCommand& m = o.mapping;
    m.log = o.log, m.output = o.output, m.truth = o.truth, m.methods = o.methods;
    m.options_file = o.options_file, m.set = o.set, m.source = o.source;
    return run_compare_mapping(m);
  }
  if (o.log.empty()) throw Error("compare --map MAP: name a log, too");
  if (o.output.empty()) o.output = results_folder(o.log, "-compare");
  auto names = chosen_methods(o.methods);
  Progress progress;
  const Inputs in = read_inputs(o, progress);
  names = leave_out(o, in, names);
  make_folder(o.output);
  const auto show = [&](const char* what, std::int64_t count) { progress.show(what, count); };
  const eval::Comparison c =
      eval::compare({in.events, in.truth, o.options, {}, cpu_seconds, show}, names);
  progress.clear();
  write_results(o, in, c);
  print_table(o, in, c);
}

}  // namespace

void add_compare(CLI::App& app) {
  auto o = std::make_shared<CompareCommand>();
  CLI::App* command = app.add_subcommand("compare", help());
  command->add_option("LOG", o->log, "a log or recording of any kind");
  command->add_option("--map", o->map,
                      "a known map: folder of a run, site.majak, YAML with PGM or PNG, picture");
  command->add_option("--map-resolution", o->map_resolution, "m a pixel, of a bare picture");
  command->add_option("--methods", o->methods, "all, or some of those above: a,b,c");
  command->add_option("--truth", o->truth, "where the robot was: TUM lines in the map's frame");
  command->add_option("--start", o->start,
                      "first pose: x,y in m and degrees (default: the truth's first)");
  command->add_option("--relations", o->mapping.relations, "relations to measure maps by");
  command->add_option("--only", o->mapping.only, "groups of runs: a,b,c (default: all)")
      ->delimiter(',');
  command->add_flag("--no-times", o->mapping.no_times,
                    "leave them out: equal logs, options and seeds then give equal bytes");
  command
      ->add_option("--seeds", o->mapping.seeds, "runs of the usual drive (default: 20; of a log 5)")
      ->check(CLI::Range(1, 1000));
  command
      ->add_option("--threads", o->mapping.threads,
                   "threads to use (default: all); the results do not depend on it")
      ->check(CLI::Range(1, 1024));
  add_log_options(*command, o->source);
  command->add_option("-o,--output", o->output,
                      "folder for the results (default: the log's name + -compare)");
  command->add_option("--options", o->options_file, "options.toml of a run");
  command->add_option("--set", o->set, "one option: name=value");
  command->callback([o] { run_compare(*o); });
}

}  // namespace majak::app
