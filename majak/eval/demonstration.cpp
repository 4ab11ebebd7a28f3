// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/demonstration.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"
#include "majak/eval/split_maps.hpp"
#include "majak/localize/dead_reckoning.hpp"

namespace majak::eval {
namespace {

constexpr double kTogether = 60;  // s of truth whose errors go together

Reference reference_of(const Demonstration& d, const DemonstrationOptions& options) {
  Reference r;
  if (d.truth.empty()) {
    r.point = options.antenna;
    r.variance = std::pow(options.ekf.gps_sigma, 2) + std::pow(options.ekf.gps_fast_sigma, 2);
    r.heading = options.heading;
    for (const ReferenceFix& f : d.fixes.fixes)
      r.witnesses.push_back({f.time, f.p, static_cast<int>(f.burst), f.sound, {}});
  } else {
    const auto begin = d.truth.front().time;
    r.heading = d.truth.front().pose.theta;
    for (const StampedPose& t : d.truth) {
      const double seconds = to_seconds(t.time - begin);
      r.witnesses.push_back(
          {t.time, t.pose.translation(), static_cast<int>(seconds / kTogether), true, t.pose});
    }
  }
  return r;
}

class Runner {
 public:
  Runner(const std::vector<Event>& events, const DemonstrationOptions& options)
      : events_(events), options_(options) {}

  DemonstrationRun run(Feed feed, std::vector<bool> withheld) const {
    DemonstrationRun run{feed, std::move(withheld), {}, {}, {}};
    slam::EkfSlam slam(options_.ekf, start());
    const double begin = now();
    std::size_t fix = 0;
    std::int64_t scans = 0;
    for (const Event& event : events_) {
      if (std::holds_alternative<GpsFix>(event) && run.withheld[fix++]) continue;
      const double before = now();
      if (!slam.add(event)) continue;
      run.steps.push_back({slam.filter().size(), now() - before});
      if (options_.progress) options_.progress(name_of(feed), ++scans);
    }
    run.ekf.map = slam.finish();
    run.ekf.cpu = now() - begin;
    run.graph.map = slam::optimize_landmarks(run.ekf.map, options_.ekf, options_.graph);
    run.graph.cpu = now() - begin - run.ekf.cpu;
    return run;
  }

 private:
  double now() const { return options_.clock ? options_.clock() : 0; }
  // Where truth is known, so is the start.
  Pose2 start() const {
    for (const Event& event : events_)
      if (const auto* t = std::get_if<Truth>(&event)) return t->T_world_robot;
    return {};
  }

  const std::vector<Event>& events_;
  const DemonstrationOptions& options_;
};

void tell(DemonstrationRun& run, const Reference& reference, const std::vector<bool>& chosen,
          Against against) {
  for (DemonstrationAnswer* a : {&run.ekf, &run.graph})
    a->scores.push_back(score(a->map.localization.estimates, reference, chosen, against));
}

Trajectory wheels_alone(const std::vector<Event>& events, double wheelbase, const Pose2& start) {
  localize::DeadReckoningOptions options;
  options.wheelbase = wheelbase;
  const auto method = localize::dead_reckoning(options, start);
  for (const Event& event : events) method.add(event);
  Trajectory path;
  for (const Estimate& e : method.finish().estimates) path.push_back({e.time, e.T_map_robot});
  return path;
}

void look_into(const std::vector<Event>& events, const DemonstrationOptions& options,
               Demonstration& d) {
  std::vector<Truth> truth;
  bool scans = false;
  for (const Event& event : events) {
    if (const auto* scan = std::get_if<Scan>(&event); scan && !scans) {
      d.T_robot_laser = scan->T_robot_laser;
      scans = true;
    }
    if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
  }
  d.truth = truth_of(truth);
  d.trunks = options.trunks;
  d.fixes = reference_fixes(events, options.ekf.wheelbase);
  if (!scans) throw Error("the demonstration needs scans; majak info tells what is in the log");
  if (d.truth.empty() && d.fixes.fixes.empty())
    throw Error("the demonstration needs satellite fixes, or truth, to be measured against");
}

}  // namespace

const char* name_of(Feed feed) {
  constexpr const char* kNames[] = {"without satellites", "with half of the bursts",
                                    "satellites cut off for minutes", "with all satellites"};
  return kNames[static_cast<std::size_t>(feed)];
}

Demonstration demonstrate(const std::vector<Event>& events, const DemonstrationOptions& options) {
  Demonstration d;
  look_into(events, options, d);
  const Reference reference = reference_of(d, options);
  const Runner runner(events, options);
  const std::size_t n = d.fixes.fixes.size();
  const bool known = !d.truth.empty();

  d.runs.push_back(runner.run(Feed::none, std::vector<bool>(n, true)));
  tell(d.runs.back(), reference, {}, Against::aligned);
  tell(d.runs.back(), reference, {}, Against::first_pose);
  if (n > 0) {
    if (!known)
      for (const std::size_t fold : {0, 1}) {
        const auto held = hold_out_fold(d.fixes, fold);
        d.runs.push_back(runner.run(Feed::fold, held));
        tell(d.runs.back(), reference, held, Against::held_out);
      }
    const Time begin = d.fixes.fixes.front().time, end = d.fixes.fixes.back().time;
    const Time middle = begin + (end - begin) / 2;
    const Duration half = std::min(from_seconds(0.5 * options.cut_off), (end - begin) / 6);
    const auto cut = hold_out_between(d.fixes, middle - half, middle + half);
    d.runs.push_back(runner.run(Feed::cut_off, cut));
    tell(d.runs.back(), reference, known ? std::vector<bool>{} : cut, Against::held_out);
    d.runs.push_back(runner.run(Feed::all, std::vector<bool>(n, false)));
    tell(d.runs.back(), reference, {}, known ? Against::held_out : Against::fed);
  }
  for (DemonstrationRun& run : d.runs)
    for (DemonstrationAnswer* a : {&run.ekf, &run.graph})
      a->obstacles = obstacle_errors(a->map, d.truth, d.trunks, d.T_robot_laser);
  for (DemonstrationRun& run : d.runs)
    run.graph.obstacles.maps = split_maps(run.graph.map, options.ekf, options.graph);
  d.wheels = wheels_alone(events, options.ekf.wheelbase,
                          d.with_all().graph.map.localization.estimates.front().T_map_robot);
  return d;
}

const std::vector<SightingError>& sightings_of(const Demonstration& demonstration) {
  const DemonstrationRun& run = demonstration.with_all();
  return (demonstration.truth.empty() ? run.graph : run.ekf).obstacles.sightings;
}

std::vector<PlaceError> pooled(const Demonstration& demonstration, Feed feed, Against against,
                               bool graph) {
  std::vector<PlaceError> all;
  for (const DemonstrationRun& run : demonstration.runs) {
    if (run.feed != feed) continue;
    for (const PathScore& s : (graph ? run.graph : run.ekf).scores)
      if (s.against == against) all.insert(all.end(), s.errors.begin(), s.errors.end());
  }
  return all;
}

}  // namespace majak::eval
