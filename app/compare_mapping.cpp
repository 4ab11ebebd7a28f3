// SPDX-License-Identifier: Apache-2.0
#include "app/compare_mapping.hpp"

#include <fmt/core.h>
#include <time.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>
#include <utility>

#include "app/input.hpp"
#include "app/log_options.hpp"
#include "app/progress.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/table2_page.hpp"
#include "majak/eval/mapping_comparison.hpp"
#include "majak/eval/table2.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/options_file.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSimulated =
    "Simulated places: rooms and corridors (100 m), a corridor there and back, a ring and nested "
    "rings of smooth walls seen up to 8 m off by a robot with worn wheels, a building of many "
    "rooms.";

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// ---- The simulated places ----------------------------------------------------------------------

const char* world_of(eval::Surroundings where) {
  switch (where) {
    case eval::Surroundings::usual:
      return "building";
    case eval::Surroundings::straight:
      return "corridor";
    case eval::Surroundings::ring:
      return "bare_ring";
    case eval::Surroundings::nested:
      return "nested_rings";
    case eval::Surroundings::large:
      return "office-3";
  }
  return "building";
}

sim::SimulationOptions simulation_of(const eval::TrialSetting& s) {
  sim::SimulationOptions o;
  o.seed = s.seed;
  o.people = s.people;
  if (s.where == eval::Surroundings::ring || s.where == eval::Surroundings::nested) {
    o.laser.max_range = 8;
    o.robot.left_scale = 1.02;
    o.robot.slip = 0.02;
  }
  for (double* error :
       {&o.robot.scale_sigma, &o.robot.unequal_sigma, &o.robot.track_sigma, &o.robot.slip})
    *error *= s.wheels > 0 ? s.wheels : 1;
  return o;
}

/// Worse than as simulated: as a log would be made so.
eval::TrialLog simulated_log(const eval::TrialSetting& s) {
  const sim::World world(sim::built_in(world_of(s.where)));
  const bool whole = s.where == eval::Surroundings::large;
  const std::vector<Event> events =
      sim::simulate(world, sim::plan_tour(world, {.short_tour = !whole}), simulation_of(s));
  eval::TrialLog log{events, {}, {}};
  std::vector<Truth> truth;
  for (const Event& event : events)
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
  log.truth = eval::truth_of(truth);
  return *eval::variations_of(log)(
      {s.group, eval::Surroundings::large, s.seed, s.wheels, s.part, s.stray, 0});
}

// ---- A log -------------------------------------------------------------------------------------

/// What stands in for truth: told, in the log, or majak's own map of it.
std::string find_truth(const MappingCompareCommand& o, const methods::MappingOptions& options,
                       Threads threads, eval::TrialLog& log) {
  Report report;
  if (!o.relations.empty()) log.relations = eval::read_relations(o.relations, report);
  if (!o.truth.empty()) {
    log.truth = eval::read_tum(o.truth, report);
    return "Truth: " + o.truth + ".";
  }
  std::vector<Truth> truth;
  for (const Event& event : log.events)
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
  log.truth = eval::truth_of(truth);
  if (!truth.empty()) return "Truth: the log's own.";
  slam::GraphSlam slam(options.graph_slam, threads);
  for (const Event& event : log.events) slam.add(event);
  for (const PosedScan& s : slam.finish().site.scans)
    log.truth.push_back({s.scan.time, s.estimate.T_map_robot});
  return "No truth is known: errors are those against graph SLAM's poses of the log as it is, so "
         "graph SLAM's own say only how far it comes back to them.";
}

std::vector<Event> read_log(const MappingCompareCommand& o, Progress& progress) {
  Input source(o.log, o.source, {}, "", progress);
  std::vector<Event> events;
  bool scans = false;
  while (auto event = source.next()) {
    scans = scans || std::holds_alternative<Scan>(*event);
    events.push_back(std::move(*event));
    progress.show("reading", static_cast<std::int64_t>(events.size()));
  }
  if (!scans)
    throw Error(fmt::format("{}: no scan in it; majak info tells what is in the log", o.log));
  return events;
}

// ---- The command -------------------------------------------------------------------------------

void choose(const std::string& list, eval::MappingComparisonInput& input) {
  const auto maps = eval::given_maps();
  if (list == "all") {
    for (const methods::MappingMethod& m : methods::mapping_methods())
      input.methods.emplace_back(m.name);
    for (const eval::GivenMap& m : maps) input.maps.emplace_back(m.name);
    return;
  }
  std::istringstream in(list);
  for (std::string name; std::getline(in, name, ',');)
    if (std::any_of(maps.begin(), maps.end(), [&](const auto& m) { return m.name == name; }))
      input.maps.push_back(name);
    else
      input.methods.emplace_back(methods::mapping_method(name).name);
  if (input.methods.empty() && input.maps.empty())
    throw Error("--methods: name some, as in hybrid,graph-slam");
}

void print_figures(const eval::Table2& table) {
  fmt::print("{}\n\n{:<16} {:>9} {:>8} {:>8} {:>9} {:>10} {:>6} {:>9} {:>8}\n", table.what,
             "method", "usable", "rms, m", "worst", "map error", "relations", "NEES", "ms a scan",
             "MB");
  for (const eval::Table2Figures& f : table.figures) {
    if (f.runs > 0)
      fmt::print("{:<16} {:>9} {:>8.3f} {:>8.3f} {:>9.3f} {:>10} {:>6} {:>9.2f} {:>8.1f}\n",
                 f.method, fmt::format("{} of {}", f.usable, f.runs), f.rms, f.worst, f.map_error,
                 f.relation ? fmt::format("{:.4f}", *f.relation) : "",
                 f.nees ? fmt::format("{:.2f}", *f.nees) : "", f.ms_a_scan, f.bytes / 1e6);
    for (const std::string& why : f.said) fmt::print("  {}: {}\n", f.method, why);
  }
}

}  // namespace

std::string mapping_methods_help() {
  std::string text;
  for (const methods::MappingMethod& m : methods::mapping_methods())
    text += fmt::format("  {:<16} {}\n", m.name, m.in_the_thesis);
  return text;
}

void run_compare_mapping(MappingCompareCommand& o) {
  eval::MappingComparisonInput input;
  OptionFields fields;
  methods::describe(fields, input.options);
  if (!o.options_file.empty()) io::apply_options_file(fields, o.options_file);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  input.threads = {thread_count(o.threads)};
  choose(o.methods, input);
  eval::MappingPlan plan;
  if (!o.log.empty()) plan.seeds = 5, plan.few = 2;  // a real log is long
  if (o.seeds > 0) plan.seeds = o.seeds, plan.few = std::min(plan.few, o.seeds);
  input.settings = eval::plan_trials(plan, o.only);
  Progress progress;
  eval::TrialLog log;
  std::string command = "majak compare";
  if (o.log.empty()) {
    input.what = kSimulated;
    input.log_of = [](const eval::TrialSetting& s) { return std::optional(simulated_log(s)); };
  } else {
    command += " " + o.log;
    log.events = read_log(o, progress);
    input.what = find_truth(o, input.options, input.threads, log);
    input.log_of = eval::variations_of(log);
  }
  if (!o.no_times) input.clock = thread_seconds;
  std::mutex one;
  input.progress = [&](std::size_t runs) {
    const std::lock_guard lock(one);
    progress.show("runs", runs, input.settings.size() * input.methods.size());
  };
  if (o.output.empty()) o.output = o.log.empty() ? "compare" : results_folder(o.log, "-compare");
  const fs::path folder = o.output;
  make_folder(folder);
  const eval::Table2 table = eval::table2_of(eval::compare_mappings(input), command);
  progress.clear();
  io::write_file_atomically(folder / "options.toml", io::options_toml(fields));
  io::write_file_atomically(folder / "table2.html", draw::table2_html(table));
  io::write_file_atomically(folder / "table2.md", draw::table2_markdown(table));
  io::write_file_atomically(folder / "table2.json", draw::table2_json(table));
  print_figures(table);
  fmt::print("\nthe table: {}\n", (folder / "table2.html").string());
}

}  // namespace majak::app
