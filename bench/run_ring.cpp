// SPDX-License-Identifier: Apache-2.0
// Do the ends of a ring meet? Many simulated laps, each mapped by several methods.
//   run_ring [--world W] [--methods A,B] [--seeds N] [--first N] [--long] [--set OPTION=VALUE]...
//            [--laser M] [--slip S] [--each] [--threads N]
//   run_ring --latency PREFIX [--first N]: what the hybrid's correction costs in rings of many
//     sizes, at once and bounded; PREFIX.svg and PREFIX.png
// The gap: how far the pose at the end of the lap is off, seen from the pose at the same place a
// lap before; "anywhere": at most over all places that are passed again. The robot: worn wheels, a
// laser of 8 m range.
#include <fmt/core.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "bench/picture.hpp"
#include "majak/core/error.hpp"
#include "majak/core/parallel.hpp"
#include "majak/eval/ate_rpe.hpp"
#include "majak/io/options_file.hpp"
#include "majak/methods/mappers.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"
#include "majak/slam/hybrid.hpp"

namespace majak::bench {
namespace {

constexpr double kClosed = 0.1;  // m

struct Run {
  std::string world = "bare_ring", latency;
  std::vector<std::string> methods;
  int seeds = 50, first = 1, threads = 1;
  bool long_tour = false, each = false;
  double laser = 8, slip = 0.02;
  methods::MappingOptions mapping;
};

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts(1);
  for (const char c : list) {
    if (c == ',')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

Run parse(int argc, char** argv) {
  Run run;
  OptionFields fields;
  methods::describe(fields, run.mapping);
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    if (a == "--long" || a == "--each") {
      (a == "--long" ? run.long_tour : run.each) = true;
      continue;
    }
    if (i + 1 == argc) throw Error(a + ": a value is missing");
    const std::string value = argv[++i];
    if (a == "--world") run.world = value;
    if (a == "--latency") run.latency = value;
    if (a == "--methods") run.methods = split(value);
    if (a == "--seeds") run.seeds = std::atoi(value.c_str());
    if (a == "--first") run.first = std::atoi(value.c_str());
    if (a == "--threads") run.threads = std::atoi(value.c_str());
    if (a == "--laser") run.laser = std::atof(value.c_str());
    if (a == "--slip") run.slip = std::atof(value.c_str());
    if (a == "--set") io::apply_option(fields, value);
  }
  if (run.methods.empty())
    for (const methods::MappingMethod& m : methods::mapping_methods())
      run.methods.emplace_back(m.name);
  return run;
}

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The left wheel counts 2 % too much, both slip; four times as much as new ones, if not told.
sim::SimulationOptions worn_robot(const Run& run, int seed) {
  sim::SimulationOptions o;
  o.seed = seed;
  o.laser.max_range = run.laser;
  o.robot.left_scale = 1.02;
  o.robot.slip = run.slip;
  return o;
}

/// Where each scan was truly taken.
std::vector<Pose2> truth_of(const Site& site) {
  std::map<Time, Pose2> at;
  for (const Truth& t : site.truth) at[t.time] = t.T_world_robot;
  std::vector<Pose2> truth;
  for (const PosedScan& s : site.scans) truth.push_back(at.at(s.scan.time));
  return truth;
}

/// The scan of the last time at which the robot is where it set off, with the same heading.
std::size_t lap_of(const std::vector<Pose2>& truth) {
  const auto away = [&](std::size_t i) {
    const Pose2 d = between(truth[0], truth[i]);
    return std::hypot(d.x, d.y) + std::abs(d.theta);
  };
  std::size_t lap = truth.size() - 1;
  while (lap > 0 && away(lap) > 0.5) --lap;
  for (std::size_t i = lap; i > 0 && away(i) < 0.5; --i)
    if (away(i) < away(lap)) lap = i;
  return lap;
}

/// How far the pose of scan `to` is off, seen from that of `from`.
Pose2 off(const Site& site, const std::vector<Pose2>& truth, std::size_t from, std::size_t to) {
  const auto pose = [&](std::size_t i) { return site.scans[i].estimate.T_map_robot; };
  return between(between(truth[from], truth[to]), between(pose(from), pose(to)));
}

/// At most, over all places that are passed again in the same direction, m.
double gap_anywhere(const Site& site, const std::vector<Pose2>& truth) {
  constexpr std::size_t kEach = 5, kLater = 300;  // scans
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); i += kEach)
    for (std::size_t j = i + kLater; j < truth.size(); j += kEach) {
      const Pose2 d = between(truth[i], truth[j]);
      if (std::hypot(d.x, d.y) > 0.3 || std::abs(d.theta) > 0.5) continue;
      const Pose2 gap = off(site, truth, i, j);
      worst = std::max(worst, std::hypot(gap.x, gap.y));
    }
  return worst;
}

struct Score {
  double gap = 0, turn = 0;  ///< m, rad
  double anywhere = 0;       ///< m, at most
  double ate = 0;            ///< m, rms
  double cpu = 0;            ///< s
  double longest = 0;        ///< s, of one add()
  std::size_t corrections = 0, undone = 0;
};

Score map_run(const Run& run, const std::string& method, const std::vector<Event>& events) {
  Score score;
  const double begin = cpu_seconds();
  const slam::Mapper mapper = methods::mapping_method(method).make(run.mapping, {1});
  for (const Event& event : events) {
    const double before = cpu_seconds();
    mapper.add(event);
    score.longest = std::max(score.longest, cpu_seconds() - before);
  }
  const slam::Mapping mapping = mapper.finish();
  score.cpu = cpu_seconds() - begin;
  const std::vector<PosedScan>& scans = mapping.site.scans;
  const std::vector<Pose2> truth = truth_of(mapping.site);
  const Pose2 gap = off(mapping.site, truth, 0, lap_of(truth));
  score.gap = std::hypot(gap.x, gap.y);
  score.turn = std::abs(gap.theta);
  score.anywhere = gap_anywhere(mapping.site, truth);
  std::vector<eval::PosePair> pairs;
  for (std::size_t i = 0; i < scans.size(); ++i)
    pairs.push_back({scans[i].scan.time, scans[i].estimate.T_map_robot, truth[i], true});
  score.ate = eval::absolute_error(pairs).translation.rms;
  score.corrections = mapping.corrections.size();
  for (const slam::LoopCorrection& c : mapping.corrections) score.undone += c.undone.has_value();
  return score;
}

/// [method][seed]
std::vector<std::vector<Score>> score_all(const Run& run) {
  std::vector<std::vector<Score>> scores(run.methods.size(),
                                         std::vector<Score>(static_cast<std::size_t>(run.seeds)));
  const sim::World world(sim::built_in(run.world));
  const sim::Path path = sim::plan_tour(world, {.short_tour = !run.long_tour});
  parallel_for({run.threads}, static_cast<std::size_t>(run.seeds), [&](std::size_t s) {
    const auto events =
        sim::simulate(world, path, worn_robot(run, run.first + static_cast<int>(s)));
    for (std::size_t m = 0; m < run.methods.size(); ++m)
      scores[m][s] = map_run(run, run.methods[m], events);
  });
  return scores;
}

template <class Value>
std::vector<double> sorted(const std::vector<Score>& scores, const Value& value) {
  std::vector<double> values;
  for (const Score& s : scores) values.push_back(value(s));
  std::sort(values.begin(), values.end());
  return values;
}

void print(const Run& run, const std::vector<std::vector<Score>>& scores) {
  fmt::print(
      "| method | closed | gap: median, worst (m) | anywhere (m) | turn: median, worst (deg) | "
      "ATE: median, worst "
      "(m) | CPU s | longest add() ms | corrections, undone "
      "|\n|---|---|---|---|---|---|---|---|---|\n");
  for (std::size_t m = 0; m < scores.size(); ++m) {
    const auto gap = sorted(scores[m], [](const Score& s) { return s.gap; });
    const auto anywhere = sorted(scores[m], [](const Score& s) { return s.anywhere; });
    const auto turn = sorted(scores[m], [](const Score& s) { return degrees(s.turn); });
    const auto ate = sorted(scores[m], [](const Score& s) { return s.ate; });
    const auto cpu = sorted(scores[m], [](const Score& s) { return s.cpu; });
    const auto longest = sorted(scores[m], [](const Score& s) { return 1e3 * s.longest; });
    std::size_t corrections = 0, undone = 0;
    for (const Score& s : scores[m]) corrections += s.corrections, undone += s.undone;
    const std::size_t half = gap.size() / 2;
    const auto closed = std::lower_bound(gap.begin(), gap.end(), kClosed) - gap.begin();
    fmt::print(
        "| {} | {} of {} | {:.3f}, {:.3f} | {:.3f}, {:.3f} | {:.2f}, {:.2f} | {:.3f}, {:.3f} | "
        "{:.2f} | {:.0f}, "
        "{:.0f} | {}, {} |\n",
        run.methods[m], closed, gap.size(), gap[half], gap.back(), anywhere[half], anywhere.back(),
        turn[half], turn.back(), ate[half], ate.back(), cpu[half], longest[half], longest.back(),
        corrections, undone);
    if (!run.each) continue;
    for (std::size_t s = 0; s < scores[m].size(); ++s) {
      const Score& one = scores[m][s];
      fmt::print(
          "  {} seed {}: gap {:.3f} m, anywhere {:.3f} m, {:.2f} deg, ATE {:.3f} m, {} "
          "corrections, {} undone\n",
          run.methods[m], run.first + static_cast<int>(s), one.gap, one.anywhere, degrees(one.turn),
          one.ate, one.corrections, one.undone);
    }
  }
}

/// Of the add() that corrected most.
struct Latency {
  double loop = 0;  ///< m
  double ms = 0;
  std::size_t touched = 0;
};

Latency latency_of(const std::vector<Event>& events, slam::HybridOptions options, int bound) {
  options.latency_keys = bound;
  slam::Hybrid hybrid({}, options, {1});
  Latency latency;
  for (const Event& event : events) {
    const double before = cpu_seconds();
    hybrid.add(event);
    latency.ms = std::max(latency.ms, 1e3 * (cpu_seconds() - before));
    latency.touched = std::max(latency.touched, hybrid.touched());
  }
  if (!hybrid.corrections().empty()) latency.loop = hybrid.corrections()[0].way;
  return latency;
}

draw::Panel latency_panel(const draw::Figure& figure, int side, const char* label) {
  const draw::Box all = figure.whole();
  return {.place = {side * all.width / 2, all.top, all.width / 2, all.height},
          .x = {"length of the loop (m)", 0},
          .y = {label, 0},
          .equal = false};
}

void measure_latency(const Run& run) {
  constexpr int kBound = 20;
  draw::Figure figure{.width = 1000, .height = 420, .title = "What a correction costs at once"};
  draw::Panel touched = latency_panel(figure, 0, "key scans moved and drawn anew"),
              time = latency_panel(figure, 1, "CPU of the longest add (ms)");
  fmt::print(
      "| loop (m) | at once: key scans, ms | at most {} a scan: key scans, ms |\n|---|---|---|\n",
      kBound);
  std::vector<draw::Point> lines[4];
  for (const double length : {24.0, 40.0, 60.0, 90.0, 120.0}) {
    const sim::World world(sim::bare_ring(length, std::max(20.0, length * 2 / 3)));
    const auto events = sim::simulate(world, sim::plan_tour(world, {.short_tour = true}),
                                      worn_robot(run, run.first));
    const Latency whole = latency_of(events, run.mapping.hybrid, 0),
                  bounded = latency_of(events, run.mapping.hybrid, kBound);
    fmt::print("| {:.0f} | {}, {:.1f} | {}, {:.1f} |\n", whole.loop, whole.touched, whole.ms,
               bounded.touched, bounded.ms);
    lines[0].push_back({whole.loop, static_cast<double>(whole.touched)});
    lines[1].push_back({whole.loop, static_cast<double>(bounded.touched)});
    lines[2].push_back({whole.loop, whole.ms});
    lines[3].push_back({whole.loop, bounded.ms});
  }
  const draw::Colour inks[] = {draw::ink::blue, draw::ink::orange};
  for (int i = 0; i < 4; ++i) {
    draw::Panel& panel = i < 2 ? touched : time;
    panel.marks.emplace_back(draw::Polyline{lines[i], {inks[i % 2], 2}});
    panel.marks.emplace_back(draw::Dots{lines[i], 3.5, inks[i % 2]});
  }
  for (draw::Panel* panel : {&touched, &time}) {
    panel->legend = {{"all at once", draw::Pen{draw::ink::blue, 2}},
                     {fmt::format("at most {} a scan", kBound), draw::Pen{draw::ink::orange, 2}}};
    figure.panels.push_back(*panel);
  }
  write_picture(run.latency, figure);
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  try {
    const auto run = majak::bench::parse(argc, argv);
    if (!run.latency.empty())
      majak::bench::measure_latency(run);
    else
      majak::bench::print(run, majak::bench::score_all(run));
  } catch (const majak::Error& error) {
    fmt::print(stderr, "run_ring: {}\n", error.what());
    return 1;
  }
  return 0;
}
