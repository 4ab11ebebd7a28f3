// SPDX-License-Identifier: Apache-2.0
// Localization on known maps, measured.
//   run_localization track SITE LOG [RELATIONS]: tracking on a run's own map, error and time
//   run_localization search SITE [QUERIES [TILES]]: one scan on the whole map; every other minute
//     of the run makes the map, scans of the others are looked for
//   run_localization kidnap SITE [TIMES]: find and track on that map, from nowhere, then carried to
//     another place; on ways of which it knows 95 %, and whatever it knows of them
//   run_localization foreign SITE LOG [METHOD [SCALE]]: the log is of another building, or the map
//     of another scale; what does the method claim?
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "bench/split_site.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/eval/relations.hpp"
#include "majak/io/site_file.hpp"
#include "majak/io/source.hpp"
#include "majak/localize/find_and_track.hpp"
#include "majak/localize/global_localization.hpp"
#include "majak/localize/tracking.hpp"
#include "majak/methods/methods.hpp"

namespace {

using namespace majak;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Event> read(const std::string& path) {
  std::vector<Event> events;
  const auto source = io::open_log(path);
  while (auto event = source->next()) events.push_back(std::move(*event));
  return events;
}

void track(const std::string& site_file, const std::string& log, const std::string& relations) {
  const Site site = io::read_site(site_file);
  const auto place = localize::place_of(site);
  const auto events = read(log);
  auto localizer =
      localize::tracking(place, {}, site.scans.front().estimate.T_map_robot, {}, seconds);
  const double begin = seconds();
  for (const Event& event : events) localizer.add(event);
  const auto run = localizer.finish();
  const double whole = seconds() - begin;
  eval::Trajectory path;
  int health[3] = {};
  double nis = 0;
  for (const Estimate& e : run.estimates) {
    path.push_back({e.time, e.T_map_robot});
    ++health[static_cast<int>(e.health)];
  }
  for (const auto& i : run.innovations) nis += i.nis;
  const auto n = static_cast<double>(run.estimates.size());
  fmt::print("{} scans, {:.4f} ms a scan:", run.estimates.size(), 1e3 * whole / n);
  for (const auto& phase : run.phases)
    fmt::print(" {} {:.4f}", phase.name, 1e3 * phase.seconds / n);
  fmt::print("\n  ok {} degraded {} lost {}, NIS {:.2f} (3)\n", health[0], health[1], health[2],
             nis / n);
  if (relations.empty()) return;
  Report report;
  const auto result = eval::evaluate_relations_in_both_frames(
      path, site.scans.front().scan.T_robot_laser, eval::read_relations(relations, report));
  const auto& e = result.best().all;
  fmt::print("  relations {:.4f} m, {:.2f} degrees; unmatched {}\n", e.translation.mean,
             degrees(e.rotation.mean), result.best().unmatched);
}

/// The map so many times beside and above itself: for the time that a great one takes.
map::KnownMap tiled(const map::KnownMap& map, int times) {
  map::KnownMap wide = map;
  wide.width *= times, wide.height *= times;
  wide.cells.clear();
  for (int y = 0; y < wide.height; ++y)
    for (int x = 0; x < wide.width; ++x)
      wide.cells.push_back(map.at(x % map.width, y % map.height));
  return wide;
}

/// Every other minute makes the map.
bench::SplitSite halves(const std::string& site_file) {
  const Site site = io::read_site(site_file);
  return {site, bench::by_minutes(site)};
}

void search(const std::string& site_file, int queries, int tiles) {
  const bench::SplitSite run = halves(site_file);
  const auto questions = run.questions();
  const auto place = tiles == 1 ? run.place : localize::place_of(tiled(run.place->known, tiles));
  const double begin = seconds();
  const localize::GlobalLocalization search(place);
  fmt::print("{} x {} m, {} questions of {} scans; made in {:.3f} s\n",
             place->known.width * place->known.resolution,
             place->known.height * place->known.resolution, questions.size(), run.site.scans.size(),
             seconds() - begin);
  RandomStream random(1);
  int rank[12] = {};
  int sure = 0, sure_and_wrong = 0;
  double time = 0, longest = 0;
  for (int q = 0; q < queries; ++q) {
    const std::size_t asked = questions[random.below(questions.size())];
    const double t0 = seconds();
    const auto result = search.find(run.site.scans[asked].scan);
    const double t = seconds() - t0;
    time += t, longest = std::max(longest, t);
    std::size_t k = 0;
    while (k < result.places.size() && !run.right(asked, result.places[k].T_map_robot)) ++k;
    if (!result.places.empty() && result.places[0].probability > 0.95) {
      ++sure;
      sure_and_wrong += k != 0;
    }
    ++rank[k < result.places.size() ? std::min<std::size_t>(k, 10) : 11];
  }
  const double n = queries;
  fmt::print(
      "  first {:.1f} %, first three {:.1f} %, in the list {:.1f} %; {:.1f} ms, at most {:.1f} ms, "
      "sure {:.1f} %, of these wrong {:.1f} %\n",
      100 * rank[0] / n, 100 * (rank[0] + rank[1] + rank[2]) / n, 100 * (n - rank[11]) / n,
      1e3 * time / n, 1e3 * longest, 100 * sure / n, 100.0 * sure_and_wrong / std::max(sure, 1));
}

/// What the wheels say of the way to scan k > 0.
std::optional<Pose2> step(const Site& site, std::size_t k) {
  if (!site.scans[k].T_odom_robot || !site.scans[k - 1].T_odom_robot) return {};
  return between(*site.scans[k - 1].T_odom_robot, *site.scans[k].T_odom_robot);
}

/// A scan with the motion before it, unless it is the first.
localize::FedScan fed(const Site& site, std::size_t k, bool continues) {
  localize::FedScan f;
  f.scan = site.scans[k].scan;
  const auto wheels = continues ? step(site, k) : std::nullopt;
  if (!wheels) return f;
  f.T_previous_robot = *wheels;
  const double way = f.T_previous_robot.translation().norm(),
               turn = std::abs(f.T_previous_robot.theta);
  f.covariance = Vec3(0.01 + 0.1 * way, 0.01 + 0.1 * way, 0.01 + 0.1 * turn + 0.05 * way)
                     .cwiseAbs2()
                     .asDiagonal();
  f.by_wheels = true;
  return f;
}

struct Outcome {
  int found = -1;      // updates until it is tracked at the right place
  int told = -1;       // updates until it says that it is lost
  bool wrong = false;  // tracked at a wrong place at the end
};

/// Counts updates by the wheels: each 0.2 m or 0.2 rad.
struct Updates {
  double way = 0, turned = 0;
  int done = 1;  // the first scan is one

  void add(const Pose2& step) {
    way += step.translation().norm(), turned += std::abs(step.theta);
    if (way > 0.2 || turned > 0.2) ++done, way = turned = 0;
  }
};

/// Questions from which that many updates are on what the half map knows.
std::vector<std::size_t> starts(const bench::SplitSite& run, int updates, double known) {
  std::vector<std::size_t> found;
  for (const std::size_t q : run.questions()) {
    Updates count;
    std::size_t last = q;
    while (count.done < updates && ++last < run.site.scans.size())
      count.add(step(run.site, last).value_or(Pose2{}));
    if (run.knows(q, last, known)) found.push_back(q);
  }
  if (found.empty()) throw Error("no scan to start from");
  return found;
}

/// Drives on from scan `first` for so many updates.
Outcome drive(localize::FindAndTrack& method, const bench::SplitSite& run, std::size_t first,
              int updates) {
  Outcome outcome;
  Updates count;
  bool right = false;
  for (std::size_t k = first; k < run.site.scans.size(); ++k) {
    const auto scan = fed(run.site, k, k > first);
    if (k > first) count.add(scan.T_previous_robot);
    const Estimate e = method.add(scan);
    right = run.right(k, e.T_map_robot);
    if (outcome.told < 0 && e.health == Health::lost) outcome.told = count.done;
    if (outcome.found < 0 && right && method.tracking() && e.health != Health::lost)
      outcome.found = count.done;
    if (count.done == updates) break;
  }
  outcome.wrong = method.tracking() && !right;
  return outcome;
}

void kidnap(const std::string& site_file, int times, double known) {
  constexpr int kFrom = 40, kTo = 20;
  const bench::SplitSite run = halves(site_file);
  const auto from = starts(run, kFrom, known), to = starts(run, kTo, known);
  RandomStream random(1);
  const auto at = [&](std::size_t i) {
    return run.site.scans[i].estimate.T_map_robot.translation();
  };
  int within[2] = {}, recovered = 0, told = 0, wrong = 0;
  std::vector<int> needed;
  for (int i = 0; i < times; ++i) {
    localize::FindAndTrack method(run.place, {}, {}, {});
    const std::size_t a = from[random.below(from.size())];
    std::size_t b = to[random.below(to.size())];
    while ((at(a) - at(b)).norm() < 3) b = to[random.below(to.size())];
    const Outcome start = drive(method, run, a, kFrom);
    within[0] += start.found > 0 && start.found <= 15;
    within[1] += start.found > 0;
    wrong += start.wrong;
    if (start.found < 0 || start.wrong) continue;
    needed.push_back(start.found);
    const Outcome carried = drive(method, run, b, kTo);
    recovered += carried.found > 0;
    told += carried.told > 0 && carried.told <= 5;
    wrong += carried.wrong;
  }
  std::sort(needed.begin(), needed.end());
  const double n = times, m = static_cast<double>(needed.size());
  fmt::print(
      "{} scans to start from, {} to be carried to, {:.0f} % of the way known: found within 15 "
      "updates {:.1f} %, 40 {:.1f} %, median {}; carried away: recovered within 20 {:.1f} %, told "
      "within 5 {:.1f} %; at a wrong place at the end {}\n",
      from.size(), to.size(), 100 * known, 100 * within[0] / n, 100 * within[1] / n,
      needed.empty() ? 0 : needed[needed.size() / 2], 100 * recovered / m, 100 * told / m, wrong);
}

/// What a method claims of a log on a map where it cannot be: that of another building, or of the
/// right one at a wrong scale.
void foreign(const std::string& site_file, const std::string& log, const std::string& method,
             double scale) {
  methods::LocalizeOptions options;
  options.place = localize::place_of(io::read_site(site_file));
  if (scale != 1) {
    map::KnownMap known = options.place->known;
    known.resolution *= scale, known.x0 *= scale, known.y0 *= scale;
    options.place = localize::place_of(known);
  }
  const auto localizer = methods::method(method).make(options);
  for (const Event& event : read(log)) localizer.add(event);
  int health[3] = {}, stretches = 0;
  bool before = false;
  const auto estimates = localizer.finish().estimates;
  for (const Estimate& e : estimates) {
    ++health[static_cast<int>(e.health)];
    stretches += e.health == Health::ok && !before;
    before = e.health == Health::ok;
  }
  fmt::print("{} scans: ok {} in {} stretches, degraded {}, lost {}\n", estimates.size(), health[0],
             stretches, health[1], health[2]);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string task = argc > 1 ? argv[1] : "";
    if (task == "track" && argc > 3)
      track(argv[2], argv[3], argc > 4 ? argv[4] : "");
    else if (task == "search" && argc > 2)
      search(argv[2], argc > 3 ? std::stoi(argv[3]) : 200, argc > 4 ? std::stoi(argv[4]) : 1);
    else if (task == "kidnap" && argc > 2)
      for (const double known : {0.95, 0.0})
        kidnap(argv[2], argc > 3 ? std::stoi(argv[3]) : 200, known);
    else if (task == "foreign" && argc > 3)
      foreign(argv[2], argv[3], argc > 4 ? argv[4] : "global", argc > 5 ? std::stod(argv[5]) : 1);
    else
      throw Error(
          "run_localization track SITE LOG [RELATIONS] | search SITE [QUERIES [TILES]] | "
          "kidnap SITE [TIMES] | foreign SITE LOG [METHOD [SCALE]]");
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
