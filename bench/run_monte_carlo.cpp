// SPDX-License-Identifier: Apache-2.0
// Monte Carlo localization, measured.
//   run_monte_carlo global SITE LOG [STARTS]      starts anywhere
//   run_monte_carlo kidnapped SITE LOG [TIMES]    carried from one place of the log to another
//   run_monte_carlo log SITE LOG                  the whole log on its own map: false alarms, time
//   run_monte_carlo simulated [SEEDS]             error against the truth, beside tracking's
//   run_monte_carlo learn SITE                    beam model and likelihood field of a run
// The first two cut the run into pieces of 12 m (or as much turning); every other piece makes the
// map, the robot is localized in the others. A moment counts as right within 0.5 m and 10 degrees.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/split_site.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/io/site_file.hpp"
#include "majak/io/source.hpp"
#include "majak/localize/monte_carlo.hpp"
#include "majak/localize/tracking.hpp"
#include "majak/match/beam_model.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/known_map.hpp"
#include "majak/sim/simulator.hpp"

namespace {

using namespace majak;

constexpr double kWay = 8.5;  // m, or rad turned: a little more than 40 updates

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Every other 12 m of the run make the map, the robot is localized in the others.
struct Run : bench::SplitSite {
  std::vector<localize::FedScan> scans;

  Run(const Site& run, const std::string& log)
      : SplitSite(run, bench::by_way(run)), scans(bench::scans_of(log, run)) {}
};

void global(const Run& run, double covered, int times) {
  constexpr int kLooks[] = {1, 2, 5, 15, 40};
  const auto from = run.starts(kWay, covered);
  fmt::print("{} starts with {:.0f} % of the next {} m on known ground\n", from.size(),
             100 * covered, kWay);
  RandomStream random(1);
  int right[5] = {}, counted[5] = {}, sure_and_wrong = 0, sure = 0;
  double time = 0, longest = 0;
  int updates = 0;
  for (int k = 0; k < times; ++k) {
    localize::MonteCarlo filter(run.place, {.seed = k + 1});
    const std::size_t first = from[random.below(from.size())];
    for (std::size_t i = first, look = 0; i < run.scans.size() && look < 5; ++i) {
      localize::FedScan scan = run.scans[i];
      if (i == first) scan.T_previous_robot = {};
      const double t0 = seconds();
      const Estimate e = filter.add(scan);
      const double t = seconds() - t0;
      if (!filter.updated()) continue;
      time += t, longest = std::max(longest, t), ++updates;
      if (e.health == Health::ok) ++sure, sure_and_wrong += !run.right(i, e.T_map_robot);
      if (filter.updates() < kLooks[look]) continue;
      ++counted[look];
      right[look] += run.right(i, e.T_map_robot);
      ++look;
    }
  }
  for (int look = 0; look < 5; ++look)
    fmt::print("  after {:2} updates {:5.1f} % of {}\n", kLooks[look],
               100.0 * right[look] / std::max(1, counted[look]), counted[look]);
  fmt::print(
      "  ok in {:.1f} % of updates, of these wrong {:.2f} %; {:.2f} ms an update, at most {:.1f}\n",
      100.0 * sure / updates, 100.0 * sure_and_wrong / std::max(sure, 1), 1e3 * time / updates,
      1e3 * longest);
}

void kidnapped(const Run& run, int times) {
  constexpr int kBefore = 20, kAfter = 40;
  const auto from = run.starts(kWay, 0.95);
  RandomStream random(2);
  std::vector<int> back, told;
  int asked = 0;
  for (int k = 0; k < times; ++k) {
    std::size_t i = from[random.below(from.size())], to = from[random.below(from.size())];
    const auto& poses = run.site.scans;
    while (
        (poses[i].estimate.T_map_robot.translation() - poses[to].estimate.T_map_robot.translation())
            .norm() < 3)
      to = from[random.below(from.size())];
    localize::MonteCarlo filter(run.place, {.seed = k + 1, .start_sigma = 0.3},
                                poses[i].estimate.T_map_robot);
    Estimate e;
    bool first = true;
    for (; filter.updates() < kBefore && i + 1 < run.scans.size(); ++i, first = false) {
      localize::FedScan scan = run.scans[i];
      if (first) scan.T_previous_robot = {};
      e = filter.add(scan);
    }
    if (!run.right(i - 1, e.T_map_robot)) continue;
    ++asked;
    int lost = 1000, recovered = 1000;
    i = to, first = true;
    for (; filter.updates() < kBefore + kAfter && i + 1 < run.scans.size(); ++i, first = false) {
      localize::FedScan scan = run.scans[i];
      if (first) scan.T_previous_robot = {};
      e = filter.add(scan);
      const int since = filter.updates() - kBefore;
      if (!filter.updated()) continue;
      if (e.health == Health::lost) lost = std::min(lost, since);
      if (run.right(i, e.T_map_robot) && e.health == Health::ok)
        recovered = std::min(recovered, since);
    }
    told.push_back(lost), back.push_back(recovered);
  }
  const auto share = [&](const std::vector<int>& v, int within) {
    const auto n = std::count_if(v.begin(), v.end(), [&](int x) { return x <= within; });
    return 100.0 * static_cast<double>(n) / asked;
  };
  fmt::print(
      "{} of {} knew where they were; told within 3, 5, 10 updates {:.1f} {:.1f} {:.1f} %, "
      "back within 5, 10, 20, 40 {:.1f} {:.1f} {:.1f} {:.1f} %\n",
      asked, times, share(told, 3), share(told, 5), share(told, 10), share(back, 5),
      share(back, 10), share(back, 20), share(back, 40));
  int silent = 0;
  for (std::size_t k = 0; k < told.size(); ++k) silent += told[k] > 5 && back[k] <= 5;
  fmt::print("  {} were back within 5 updates without having been told lost\n", silent);
}

/// The whole log, begun anywhere: how often it says lost though it is right, and where it is wrong.
void along(const Run& run, const localize::PlacePtr& place, const std::vector<bool>* covered) {
  localize::MonteCarlo filter(place, {});
  int alarms = 0, updates = 0, right = 0, ok = 0, ok_wrong = 0, degraded = 0;
  bool was_lost = true, settled = false;
  double time = 0;
  std::size_t particles = 0;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const double t0 = seconds();
    const Estimate e = filter.add(run.scans[i]);
    if (filter.updated()) time += seconds() - t0;
    if (!filter.updated() || (covered && !(*covered)[i])) continue;
    ++updates;
    particles += filter.weights().size();
    const bool good = run.right(i, e.T_map_robot), lost = e.health == Health::lost;
    right += good;
    degraded += e.health == Health::degraded;
    if (e.health == Health::ok) ++ok, ok_wrong += !good;
    settled = settled || !lost;
    if (settled && lost && !was_lost && good) ++alarms;
    was_lost = lost;
  }
  const double hours = to_seconds(run.scans.back().scan.time - run.scans.front().scan.time) / 3600;
  fmt::print(
      "  {} updates, right {:.2f} %, ok {:.2f} %, of these wrong {:.3f} %, degraded {:.2f} %; "
      "false alarms {} in {:.2f} h; {:.2f} ms an update, {} particles\n",
      updates, 100.0 * right / updates, 100.0 * ok / updates, 100.0 * ok_wrong / ok,
      100.0 * degraded / updates, alarms, hours, 1e3 * time / updates,
      particles / static_cast<std::size_t>(updates));
}

/// A tour of 100 m through the built-in building, on a map of cells of 2.5 cm.
void simulated(int seeds, double sigma, double cell) {
  const sim::World world(sim::building());
  const sim::Path path = sim::plan_tour(world, {.short_tour = true});
  const auto place = localize::place_of(sim::known_map(world, cell), {.sigma = sigma});
  double way[2] = {}, turn[2] = {}, nees[2] = {};
  int n = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    sim::SimulationOptions drive;
    drive.seed = seed;
    localize::MonteCarlo filter(place, {.seed = seed, .start_sigma = 0.1}, path.start);
    localize::Tracker tracker(place, {}, path.start);
    localize::ScanFeed feed;
    std::vector<Pose2> truth;
    std::size_t i = 0;
    for (const Event& event : sim::simulate(world, path, drive)) {
      if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(t->T_world_robot);
      feed.add(event);
      while (i < truth.size()) {  // a scan's truth comes after it
        const auto scan = feed.next();
        if (!scan) break;
        const Estimate by[2] = {filter.add(*scan), tracker.add(*scan)};
        const Pose2& real = truth[i++];
        if (!filter.updated() || filter.updates() < 10) continue;
        for (int k = 0; k < 2; ++k) {
          const Pose2 off = between(real, by[k].T_map_robot);
          way[k] += off.translation().squaredNorm(), turn[k] += off.theta * off.theta;
        }
        for (int k = 0; k < 2; ++k)
          nees[k] += eval::nees(by[k].T_map_robot, by[k].covariance, real).value_or(0);
        ++n;
      }
    }
  }
  fmt::print("cells of {} m, sigma of the likelihood field {} m, {} updates\n", cell, sigma, n);
  for (int k = 0; k < 2; ++k)
    fmt::print("  {}: {:.4f} m, {:.3f} degrees RMS, NEES {:.2f} (3)\n",
               k == 0 ? "monte-carlo" : "tracking", std::sqrt(way[k] / n),
               degrees(std::sqrt(turn[k] / n)), nees[k] / n);
}

void learn(const Site& site) {
  const auto place = localize::place_of(site);
  std::vector<match::BeamPair> pairs;
  std::vector<double> distances;
  double reach = 0;
  for (std::size_t i = 0; i < site.scans.size(); i += 20) {
    const PosedScan& s = site.scans[i];
    const match::Beams beams = match::beams(s.scan);
    reach = beams.max_range;
    match::expect(beams, place->distances, s.estimate.T_map_robot, pairs);
    for (std::size_t k = 0; k < beams.returns; ++k)
      distances.push_back(
          place->distances.at(s.estimate.T_map_robot * Vec2(beams.x[k], beams.y[k])));
  }
  const auto m = match::learn_beam_model(pairs, reach);
  const auto f = match::learn_likelihood_field(distances);
  fmt::print(
      "beam model: hit {:.3f} brief {:.3f} none {:.3f} random {:.3f}, sigma {:.3f} m, rate "
      "{:.2f} 1/m; field: hit {:.3f}, sigma {:.3f} m; {} beams\n",
      m.hit, m.brief, m.none, m.random, m.sigma, m.rate, f.hit, f.sigma, pairs.size());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string task = argc > 1 ? argv[1] : "";
    if (task == "simulated") {
      for (const double cell : {0.025, 0.05})
        for (const double sigma : {0.1, 0.05})
          simulated(argc > 2 ? std::stoi(argv[2]) : 10, sigma, cell);
      return 0;
    }
    if (task == "learn" && argc > 2) return learn(io::read_site(argv[2])), 0;
    const int times = argc > 4 ? std::stoi(argv[4]) : 200;
    if ((task != "global" && task != "kidnapped" && task != "log") || argc < 4)
      throw Error(
          "run_monte_carlo global|kidnapped|log SITE LOG [TIMES] | simulated [SEEDS] | learn SITE");
    const Run run(io::read_site(argv[2]), argv[3]);
    if (task == "global")
      for (const double covered : {0.95, 0.0}) global(run, covered, times);
    if (task == "kidnapped") kidnapped(run, times);
    if (task == "log") {
      along(run, localize::place_of(run.site), nullptr);
      along(run, run.place, &run.covered);
    }
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
