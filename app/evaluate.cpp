// SPDX-License-Identifier: Apache-2.0
#include "app/evaluate.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "majak/core/error.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/eval/map_quality.hpp"
#include "majak/eval/relations.hpp"
#include "majak/io/site_file.hpp"

namespace majak::app {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct EvaluateOptions {
  std::string run;
  std::string relations;
  std::string truth;
  std::vector<double> mounting;  // m, m, degrees
  eval::Alignment alignment = eval::Alignment::best;
  bool worst = false;
  bool json = false;
};

/// What is evaluated: always a trajectory, and the Site if RUN is a result folder.
struct Run {
  std::string trajectory_file;
  eval::Trajectory trajectory;
  std::optional<Site> site;
  Pose2 T_robot_laser;
};

Json to_json(const eval::ErrorStats& s, double scale) {
  return {{"count", s.count},           {"mean", scale * s.mean}, {"sigma", scale * s.sigma},
          {"median", scale * s.median}, {"rms", scale * s.rms},   {"max", scale * s.max}};
}

void print_errors(const char* name, const eval::ErrorStats& m, const eval::ErrorStats& rad) {
  if (m.count == 0) {
    fmt::print("  {:<22} none\n", name);
    return;
  }
  fmt::print(
      "  {:<22} {:>7}   {:.4f} +- {:.4f} m (median {:.4f}, max {:.3f})   "
      "{:.3f} +- {:.3f} deg (median {:.3f}, max {:.2f})\n",
      name, m.count, m.mean, m.sigma, m.median, m.max, degrees(rad.mean), degrees(rad.sigma),
      degrees(rad.median), degrees(rad.max));
}

Json errors_json(const eval::ErrorStats& m, const eval::ErrorStats& rad) {
  return {{"translation_m", to_json(m, 1)}, {"rotation_deg", to_json(rad, degrees(1))}};
}

void warn(const Report& report) {
  for (const auto& [what, entry] : report.entries()) {
    fmt::print(stderr, "majak: {} ({} times, first in line {})\n", what, entry.count,
               entry.first_line);
  }
}

Json relation_result_json(const eval::RelationResult& r) {
  return {{"exact", r.exact},
          {"interpolated", r.interpolated},
          {"unmatched", r.unmatched},
          {"all", errors_json(r.all.translation, r.all.rotation)},
          {"short", errors_json(r.near.translation, r.near.rotation)},
          {"loop", errors_json(r.loop.translation, r.loop.rotation)}};
}

void print_relation_result(const char* frame, const eval::RelationResult& r, bool better) {
  fmt::print(
      "between {} poses{}: {} relations at exact stamps, {} interpolated, {} without a pose\n",
      frame, better ? " (the better frame)" : "", r.exact, r.interpolated, r.unmatched);
  print_errors("all", r.all.translation, r.all.rotation);
  print_errors("short (up to 20 s)", r.near.translation, r.near.rotation);
  print_errors("loop (over 20 s)", r.loop.translation, r.loop.rotation);
}

/// The relations that fit worst: where to look.
void print_worst(const eval::RelationResult& result, const std::vector<eval::Relation>& relations) {
  auto residuals = result.residuals;
  std::stable_sort(residuals.begin(), residuals.end(),
                   [](const auto& a, const auto& b) { return a.translation > b.translation; });
  fmt::print("the worst:\n");
  for (std::size_t i = 0; i < std::min<std::size_t>(residuals.size(), 10); ++i) {
    const eval::Relation& r = relations[residuals[i].relation];
    fmt::print("  line {:>5}   {:.6f} to {:.6f} s   {:.3f} m   {:.2f} deg\n", r.line,
               to_seconds(r.from), to_seconds(r.to), residuals[i].translation,
               degrees(residuals[i].rotation));
  }
}

Json evaluate_relations(const EvaluateOptions& options, const Run& run) {
  Report report;
  const auto relations = eval::read_relations(options.relations, report);
  warn(report);
  const auto both =
      eval::evaluate_relations_in_both_frames(run.trajectory, run.T_robot_laser, relations);
  if (both.best().residuals.empty()) {
    throw Error(fmt::format("{}: none of its stamps is in {}; do they belong to one log?",
                            options.relations, run.trajectory_file));
  }
  const bool laser_better = both.better == eval::BodyFrame::laser;
  if (!options.json) {
    fmt::print("relations of {}   count, mean +- standard deviation\n", options.relations);
    print_relation_result("robot", both.robot, both.laser && !laser_better);
    if (both.laser) print_relation_result("laser", *both.laser, laser_better);
    if (options.worst) print_worst(both.best(), relations);
  }
  Json json = {{"file", options.relations},
               {"better_frame", laser_better ? "laser" : "robot"},
               {"robot", relation_result_json(both.robot)}};
  if (both.laser) json["laser"] = relation_result_json(*both.laser);
  return json;
}

eval::Trajectory load_truth(const EvaluateOptions& options, const Run& run) {
  if (options.truth != "in-log") {
    Report report;
    auto truth = eval::read_tum(options.truth, report);
    warn(report);
    return truth;
  }
  if (!run.site)
    throw Error("--truth in-log needs a result folder with site.majak, not a .tum file");
  if (run.site->truth.empty()) {
    throw Error(run.site->source_name + ": the log carries no truth; give a TUM file with --truth");
  }
  return eval::truth_of(run.site->truth);
}

Json evaluate_nees(const EvaluateOptions& options, const Site& site,
                   const eval::Trajectory& truth) {
  std::vector<Estimate> estimates;
  for (const PosedScan& scan : site.scans) estimates.push_back(scan.estimate);
  const auto nees = eval::summarize_nees(eval::nees_of_run(estimates, truth));
  if (nees.count == 0) return nullptr;
  if (!options.json) {
    fmt::print(
        "NEES of {} poses: mean {:.2f} (3 expected), {:.1f} % within their own 95 % ellipse "
        "(poses of one run hang together; the band of the mean is for many runs)\n",
        nees.count, nees.mean, 100 * nees.inside_share);
  }
  return {{"count", nees.count},
          {"mean", nees.mean},
          {"expected", 3},
          {"inside_95", nees.inside_share}};
}

Json evaluate_truth(const EvaluateOptions& options, const Run& run) {
  const auto truth = load_truth(options, run);
  const auto associated = eval::associate(run.trajectory, truth);
  if (associated.pairs.empty()) {
    throw Error(fmt::format("{}: no pose at the times of {}; do they belong to one log?",
                            options.truth, run.trajectory_file));
  }
  const auto ate = eval::absolute_error(associated.pairs, options.alignment);
  const auto rpe = eval::relative_errors(associated.pairs, {1, 2, 5, 10, 20, 50, 100, 200, 500});
  Json json = {{"against", options.truth},
               {"exact", associated.exact},
               {"interpolated", associated.interpolated},
               {"unmatched", associated.unmatched},
               {"path_m", eval::path_length(associated.pairs)},
               {"ate", errors_json(ate.translation, ate.rotation)},
               {"rpe", Json::array()}};
  for (const auto& r : rpe) {
    json["rpe"].push_back({{"distance_m", r.distance}});
    json["rpe"].back().update(errors_json(r.translation, r.rotation));
  }
  if (!options.json) {
    fmt::print(
        "truth of {}: {} poses at exact stamps, {} interpolated, {} without truth, path {:.1f} m\n",
        options.truth, associated.exact, associated.interpolated, associated.unmatched,
        eval::path_length(associated.pairs));
    print_errors("absolute (ATE)", ate.translation, ate.rotation);
    for (const auto& r : rpe) {
      print_errors(fmt::format("over {:g} m (RPE)", r.distance).c_str(), r.translation, r.rotation);
    }
    fmt::print("  ATE root mean square   {:.4f} m\n", ate.translation.rms);
  }
  if (run.site) json["nees"] = evaluate_nees(options, *run.site, truth);
  return json;
}

Json evaluate_map(const EvaluateOptions& options, const Run& run) {
  if (!run.site)
    throw Error("without truth the map itself is measured: give a result folder with site.majak");
  const auto q = eval::measure_map_quality(*run.site);
  if (!options.json) {
    fmt::print("the map by itself ({} returns, {} examined)\n", q.points, q.samples);
    fmt::print("  wall thickness         {:.4f} m (one sigma across, median)\n", q.wall_thickness);
    fmt::print("  entropy                {:.3f} nats (mean of the neighbourhoods)\n", q.entropy);
    fmt::print("  doubled walls          {:.2f} % of the points on walls\n", 100 * q.doubled_share);
    if (q.revisit.count == 0) {
      fmt::print("  revisits               none\n");
    } else {
      fmt::print(
          "  revisits               median {:.4f} m from the earlier wall, {:.2f} % beyond 0.1 m "
          "({:.0f} % of the points are revisited)\n",
          q.revisit.median, 100 * q.revisit_beyond, 100 * q.revisited_share);
    }
  }
  return {{"points", q.points},
          {"samples", q.samples},
          {"wall_thickness_m", q.wall_thickness},
          {"entropy_nats", q.entropy},
          {"doubled_share", q.doubled_share},
          {"revisit_m", to_json(q.revisit, 1)},
          {"revisit_beyond_0.1m_share", q.revisit_beyond},
          {"revisited_share", q.revisited_share}};
}

Run load_run(const EvaluateOptions& options) {
  Run run;
  const fs::path path = options.run;
  if (fs::is_directory(path)) {
    run.trajectory_file = (path / "trajectory.tum").string();
    run.site = io::read_site(path / "site.majak");
    if (!run.site->scans.empty()) run.T_robot_laser = run.site->scans.front().scan.T_robot_laser;
  } else {
    run.trajectory_file = options.run;
  }
  Report report;
  run.trajectory = eval::read_tum(run.trajectory_file, report);
  warn(report);
  if (!options.mounting.empty()) {
    run.T_robot_laser = {options.mounting[0], options.mounting[1], radians(options.mounting[2])};
  }
  return run;
}

void evaluate(const EvaluateOptions& options) {
  const Run run = load_run(options);
  Json json = {{"run", options.run}, {"poses", run.trajectory.size()}};
  if (!options.relations.empty()) json["relations"] = evaluate_relations(options, run);
  if (!options.truth.empty()) json["truth"] = evaluate_truth(options, run);
  if (options.relations.empty() && options.truth.empty()) json["map"] = evaluate_map(options, run);
  if (options.json) fmt::print("{}\n", json.dump(2));
}

}  // namespace

void add_evaluate(CLI::App& app) {
  const auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command = app.add_subcommand("evaluate", "how good a result is");
  command->footer(
      "Examples:\n"
      "  majak evaluate out                               the map by itself, no truth needed\n"
      "  majak evaluate out --relations intel.relations   against relations checked by hand\n"
      "  majak evaluate out --truth in-log                against the truth that the log carries\n"
      "  majak evaluate mine.tum --truth other.tum        any two trajectories");
  command->add_option("run", options->run, "result folder, or a trajectory in TUM format")
      ->required();
  command->add_option("--relations", options->relations, "lines `t1 t2 x y z roll pitch yaw`");
  command->add_option("--truth", options->truth, "trajectory in TUM format, or in-log");
  command
      ->add_option("--mounting", options->mounting,
                   "laser on the robot: m ahead, m to the left, degrees (default: from the result)")
      ->expected(3);
  const std::map<std::string, eval::Alignment> alignments = {{"none", eval::Alignment::none},
                                                             {"first", eval::Alignment::first_pose},
                                                             {"best", eval::Alignment::best}};
  command
      ->add_option("--align", options->alignment,
                   "how the trajectory is laid on the truth (default best)")
      ->transform(CLI::CheckedTransformer(alignments));
  command->add_flag("--worst", options->worst, "also list the ten worst relations");
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options] { evaluate(*options); });
}

}  // namespace majak::app
