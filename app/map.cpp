// SPDX-License-Identifier: Apache-2.0
#include "app/map.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/compare_mapping.hpp"
#include "app/input.hpp"
#include "app/live.hpp"
#include "app/log_options.hpp"
#include "app/progress.hpp"
#include "app/results.hpp"
#include "app/run_view.hpp"
#include "app/scan_pair.hpp"
#include "app/viewer.hpp"
#include "app/work_view.hpp"
#include "app/write_figure.hpp"
#include "majak/core/error.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/source.hpp"
#include "majak/map/edits.hpp"
#include "majak/methods/mappers.hpp"
#include "majak/motion/slip.hpp"

namespace majak::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMapHelp =
    "From a laser log to a map, a trajectory and a report.\n"
    "\n"
    "Examples:\n"
    "  majak map intel.clf.bz2                  writes the folder intel-map\n"
    "  majak map my.log -o office               writes the folder office\n"
    "  majak map my.log --no-odometry           trusts the laser alone\n"
    "  majak map my.log --options office/options.toml   again with the options of a run\n"
    "  majak map my.log --without-loop 151-945  without a closure that the report lists\n"
    "  majak map my.log --method particles      by another method\n"
    "  majak map /dev/ttyUSB0 -o hall           live from the laser, until Ctrl-C\n"
    "  majak map my.log --view                  watched in the browser, then corrected there\n"
    "\n"
    "The folder holds report.html (open this first), map.png, map.pgm + map.yaml, trajectory.tum,\n"
    "graph.g2o, summary.json, options.toml and site.majak, from which other commands start.\n"
    "\n"
    "Methods (the first is for maps that you need, the others are for comparing):\n";

struct MapOptions {
  std::string log, output, options_file;
  std::vector<std::string> set, without_loops;
  bool no_odometry = false, no_loops = false, json = false;
  int threads = 0;
  io::SourceOptions source;
  DeviceOptions device;
  std::string record;  // also keep what the device sends
  std::string method = "graph-slam";
  RunOptions options;
  bool view = false;  // show it on a page, and stay
  bool files = true;  // leave a folder
  ViewerOptions viewer;
};

std::string map_help() { return kMapHelp + mapping_methods_help(); }

void read_options(MapOptions& o) {
  OptionFields fields;
  describe(fields, o.options);
  if (!o.options_file.empty()) io::apply_options_file(fields, o.options_file);
  for (const std::string& assignment : o.set) io::apply_option(fields, assignment);
  if (o.no_odometry) o.options.mapping.graph_slam.chain.use_odometry = false;
  if (o.no_loops) o.options.mapping.graph_slam.close_loops = false;
  for (const std::string& pair : o.without_loops)
    o.options.mapping.graph_slam.loops.switched_off.push_back(scan_pair("--without-loop", pair));
}

std::string effective_options(MapOptions& o) {
  OptionFields fields;
  describe(fields, o.options);
  return io::options_toml(fields);
}

slam::Mapping finish(const slam::Mapper& mapper, const std::string& log) {
  try {
    return mapper.finish();
  } catch (const Error& e) {  // it does not know whose scans these are
    throw Error(fmt::format("{}: {}", log, e.what()));
  }
}

slam::Mapping map_log(const MapOptions& o, Threads threads, Stopwatch& stopwatch, Viewer* viewer) {
  Progress progress;
  std::optional<WorkView> view;
  if (viewer != nullptr)
    view.emplace(*viewer, fs::path(o.log).filename().string(), "mapping", o.options.grid);
  Input source(o.log, o.source, o.device, o.record, progress);
  const slam::Mapper mapper = methods::mapping_method(o.method).make(o.options.mapping, threads);
  std::int64_t scans = 0;
  while (auto event = source.next()) {
    scans += std::holds_alternative<Scan>(*event);
    const Time begin = live_clock();
    mapper.add(std::move(*event));
    if (view) view->look(mapper.chain(), 1e3 * to_seconds(live_clock() - begin));
    if (!source.live()) progress.show("reading and matching", scans);
  }
  stopwatch.lap("read_and_match");
  progress.show("all scans together", scans);
  if (view) view->status("all scans together");
  if (scans == 0)
    throw Error(fmt::format("{}: {}", o.log,
                            source.live()
                                ? "no scan came; docs/SENSOR.md tells what to look at"
                                : "no laser scans in this log; majak info tells what is in it"));
  slam::Mapping mapping = finish(mapper, o.log);
  for (const auto& [what, entry] : source.report().entries()) mapping.site.report.add(what, entry);
  mapping.site.source_name = fs::path(o.log).filename().string();
  stopwatch.lap("refine");
  return mapping;
}

slam::Mapping make_map(const MapOptions& o, Threads threads, Stopwatch& stopwatch, Viewer* viewer) {
  try {
    return map_log(o, threads, stopwatch, viewer);
  } catch (const std::bad_alloc&) {
    throw Error(fmt::format(
        "{}: the map of this log does not fit into the memory; where odometry jumps, --no-odometry "
        "maps with the laser alone",
        o.log));
  }
}

// Closures left out are a correction like any other: with the run's edits they can be undone.
void keep_switched_off(const MapOptions& o, Site& site) {
  const auto& off = o.options.mapping.graph_slam.loops.switched_off;
  for (const Constraint& c : site.constraints)
    if (c.kind == ConstraintKind::closure &&
        std::find(off.begin(), off.end(), std::pair{c.from, c.to}) != off.end())
      map::switch_closure(site, c.from, c.to, false);
}

void print_result(const MapOptions& o, const Site& site,
                  const std::vector<motion::SlipEvent>& slips) {
  const auto count = [&](Health h) {
    return std::count_if(site.scans.begin(), site.scans.end(),
                         [&](const PosedScan& s) { return s.estimate.health == h; });
  };
  const auto closures = std::count_if(
      site.constraints.begin(), site.constraints.end(),
      [](const Constraint& c) { return c.kind == ConstraintKind::closure && c.enabled; });
  fmt::print("{} scans placed, {} loop closures", site.scans.size(), closures);
  if (const auto n = count(Health::degraded); n > 0) fmt::print(", {} scans degraded", n);
  if (const auto n = count(Health::lost); n > 0) fmt::print(", {} scans lost", n);
  fmt::print("\n");
  if (!slips.empty())
    fmt::print(
        "  {} slips and bumps, the biggest {:.1f} s after the start: {:.2f} m, {:+.1f} degrees\n",
        slips.size(), to_seconds(slips[0].begin - site.scans[0].scan.time), slips[0].way,
        degrees(slips[0].turn));
  for (const auto& [what, entry] : site.report.entries())
    fmt::print("  {} x {}{}\n", entry.count, what,
               entry.first_line > 0 ? fmt::format(" (first: line {})", entry.first_line) : "");
  fmt::print("report:  {}\n", (fs::path(o.output) / "report.html").string());
  fmt::print("picture: {}\n", (fs::path(o.output) / "map.png").string());
}

void run_map(MapOptions& o) {
  read_options(o);
  if (o.output.empty()) o.output = results_folder(o.log, "-map");
  const Threads threads{thread_count(o.threads)};
  std::unique_ptr<Viewer> viewer;
  if (o.view) viewer = std::make_unique<Viewer>(o.viewer);
  Stopwatch stopwatch;
  slam::Mapping mapping = make_map(o, threads, stopwatch, viewer.get());
  Site& site = mapping.site;
  site.options_toml = effective_options(o);
  keep_switched_off(o, site);
  if (o.files) {
    const Results results = write_results(o.output, site, o.options.grid, stopwatch);
    if (o.json)
      fmt::print("{}", results.summary);
    else
      print_result(o, site, results.slips);
  }
  if (!viewer) return;
  std::optional<fs::path> folder;
  if (o.files) folder = o.output;
  const RunView view(*viewer, std::move(site), folder, threads);
  viewer->wait();
}

}  // namespace

void map_on_page(const std::string& log, const ViewerOptions& viewer) {
  MapOptions o;
  o.log = log;
  o.view = true;
  o.files = false;
  o.viewer = viewer;
  run_map(o);
}

void add_map(CLI::App& app) {
  auto o = std::make_shared<MapOptions>();
  CLI::App* command = app.add_subcommand("map", map_help());
  command
      ->add_option("LOG", o->log, "a log or recording of any kind, or a live device's serial port")
      ->required();
  add_log_options(*command, o->source);
  add_device_options(*command, o->device);
  command->add_option("--record", o->record, "device: keep what it sends in this file, too");
  command->add_option("-o,--output", o->output,
                      "folder for the results (default: the log's name + -map)");
  command->add_option("--method", o->method, "one of those above (default: graph-slam)");
  command->add_flag("--no-odometry", o->no_odometry, "use the laser alone");
  command->add_flag("--no-loops", o->no_loops, "do not recognise places seen before");
  command->add_option("--without-loop", o->without_loops,
                      "leave out one closure, FROM-TO as the report lists its scans; repeatable");
  command
      ->add_option("--threads", o->threads,
                   "threads to use (default: all); the results do not depend on it")
      ->check(CLI::Range(1, 1024));
  command->add_option("--options", o->options_file, "options.toml of a run");
  command->add_option("--set", o->set, "one option: name=value");
  command->add_flag("--json", o->json, "print summary.json");
  command->add_flag("--view", o->view, "show it on a page in the browser, and stay");
  add_viewer_options(*command, o->viewer);
  command->callback([o] { run_map(*o); });
}

}  // namespace majak::app
