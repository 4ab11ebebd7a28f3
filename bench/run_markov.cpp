// SPDX-License-Identifier: Apache-2.0
// Markov localization, measured.
//   run_markov global SITE LOG [STARTS]       starts anywhere
//   run_markov kidnapped SITE LOG [TIMES]     carried from one place of the log to another
//   run_markov log SITE LOG                   the whole log on its own map: error, time, memory
// The first two on a run cut in pieces (bench/split_site.hpp). Right is within 0.5 m and 10
// degrees. Times are of one thread, user and system.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "bench/split_site.hpp"
#include "majak/core/random.hpp"
#include "majak/io/site_file.hpp"
#include "majak/localize/markov.hpp"

namespace {

using namespace majak;

double cpu() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Every other 12 m of the run make the map, the robot is localized in the others.
struct Run : bench::SplitSite {
  std::vector<localize::FedScan> scans;

  Run(const Site& run, const std::string& log)
      : SplitSite(run, bench::by_way(run)), scans(bench::scans_of(log, run)) {}
};

/// A filter that is stepped along a log and timed.
struct Robot {
  localize::Markov filter;
  bool fresh = true;  // it was put down: the wheels tell nothing yet
  double seconds = 0;
  bool updated = false;
  Estimate estimate;

  explicit Robot(const localize::PlacePtr& place) : filter(place, {}) {}
  void step(localize::FedScan scan) {
    if (fresh) scan.T_previous_robot = {}, scan.covariance.setZero();
    fresh = false;
    const int before = filter.updates();
    const double begin = cpu();
    estimate = filter.add(scan);
    seconds = cpu() - begin;
    updated = filter.updates() > before;
  }
};

double quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}

double mean(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return v.empty() ? 0 : sum / static_cast<double>(v.size());
}

void global(const Run& run, int times) {
  constexpr int kLooks[] = {1, 2, 5, 10, 15, 40};
  constexpr int kMany = 6;
  const auto from = run.starts(8.5, 0);
  RandomStream random(1);
  int right[kMany] = {}, counted[kMany] = {}, sure = 0, sure_and_wrong = 0;
  std::vector<double> first, later, localized, errors, turns;
  std::size_t most = 0;
  for (int k = 0; k < times; ++k) {
    Robot robot(run.place);
    std::size_t i = from[random.below(from.size())];
    for (int look = 0; i < run.scans.size() && look < kMany; ++i) {
      robot.step(run.scans[i]);
      if (!robot.updated) continue;
      const Estimate& e = robot.estimate;
      const bool good = run.right(i, e.T_map_robot);
      const int n = robot.filter.updates();
      most = std::max(most, robot.filter.bytes());
      (n == 1 ? first : n <= 15 ? later : localized).push_back(robot.seconds);
      if (e.health == Health::ok) ++sure, sure_and_wrong += !good;
      if (good && n > 15) {
        errors.push_back(run.error(i, e.T_map_robot).translation().norm());
        turns.push_back(std::abs(run.error(i, e.T_map_robot).theta));
      }
      if (n < kLooks[look]) continue;
      ++counted[look], right[look] += good, ++look;
    }
  }
  for (int look = 0; look < kMany; ++look)
    fmt::print("  after {:2} updates {:5.1f} % of {}\n", kLooks[look],
               100.0 * right[look] / std::max(1, counted[look]), counted[look]);
  fmt::print("  sure in {} updates, of these wrong {:.2f} %\n", sure,
             100.0 * sure_and_wrong / std::max(sure, 1));
  fmt::print(
      "  the first update {:.0f} ms, to the 15th {:.1f} ms, then {:.1f} (95 %: {:.1f}); at "
      "most {:.1f} MB\n",
      1e3 * mean(first), 1e3 * mean(later), 1e3 * mean(localized), 1e3 * quantile(localized, 0.95),
      static_cast<double>(most) / 1e6);
  fmt::print("  error where right, from the 16th: {:.3f} m, {:.2f} degrees\n", mean(errors),
             degrees(mean(turns)));
}

void kidnapped(const Run& run, int times) {
  constexpr int kBefore = 25, kAfter = 40;
  const auto from = run.starts(8.5, 0);
  RandomStream random(2);
  std::vector<double> back;
  int asked = 0;
  for (int k = 0; k < times; ++k) {
    std::size_t i = from[random.below(from.size())], to = i;
    const auto at = [&](std::size_t s) { return run.site.scans[s].estimate.T_map_robot; };
    while ((at(i).translation() - at(to).translation()).norm() < 3)
      to = from[random.below(from.size())];
    Robot robot(run.place);
    for (; robot.filter.updates() < kBefore && i + 1 < run.scans.size(); ++i)
      robot.step(run.scans[i]);
    if (!run.right(i - 1, robot.estimate.T_map_robot)) continue;
    ++asked;
    int recovered = 1000;
    robot.fresh = true;
    for (i = to; robot.filter.updates() < kBefore + kAfter && i < run.scans.size(); ++i) {
      robot.step(run.scans[i]);
      if (robot.updated && run.right(i, robot.estimate.T_map_robot) &&
          robot.estimate.health == Health::ok)
        recovered = std::min(recovered, robot.filter.updates() - kBefore);
    }
    back.push_back(recovered);
  }
  const auto share = [&](int within) {
    return 100.0 *
           static_cast<double>(
               std::count_if(back.begin(), back.end(), [&](double x) { return x <= within; })) /
           asked;
  };
  fmt::print(
      "  {} of {} knew where they were; back within 5, 10, 20, 40 updates {:.0f} {:.0f} "
      "{:.0f} {:.0f} %\n",
      asked, times, share(5), share(10), share(20), share(40));
}

void along(const Run& run) {
  const auto place = localize::place_of(run.site);
  Robot robot(place);
  std::vector<double> seconds, errors, turns;
  int right = 0, ok = 0, ok_and_wrong = 0;
  std::size_t most = 0, localized = 0, cells = 0;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    robot.step(run.scans[i]);
    if (!robot.updated) continue;
    const Pose2& pose = robot.estimate.T_map_robot;
    const bool good = run.right(i, pose);
    most = std::max(most, robot.filter.bytes()), localized = robot.filter.belief().bytes();
    seconds.push_back(robot.seconds), cells += robot.filter.weighed().cells;
    right += good;
    if (robot.estimate.health == Health::ok) ++ok, ok_and_wrong += !good;
    if (good) {
      errors.push_back(run.error(i, pose).translation().norm());
      turns.push_back(std::abs(run.error(i, pose).theta));
    }
  }
  const double n = robot.filter.updates();
  fmt::print(
      "  {} updates: right {:.2f} %, ok {:.1f} %, of these wrong {:.2f} %; error {:.3f} m "
      "(95 %: {:.3f}), {:.2f} degrees\n",
      n, 100 * right / n, 100 * ok / n, 100.0 * ok_and_wrong / std::max(1, ok), mean(errors),
      quantile(errors, 0.95), degrees(mean(turns)));
  fmt::print(
      "  an update {:.2f} ms (median {:.2f}, 95 %: {:.2f}, the first {:.0f}), {:.0f} cells; "
      "memory at most {:.1f} MB, at the end {:.2f} awake\n",
      1e3 * mean(seconds), 1e3 * quantile(seconds, 0.5), 1e3 * quantile(seconds, 0.95),
      1e3 * seconds.front(), static_cast<double>(cells) / n, static_cast<double>(most) / 1e6,
      static_cast<double>(localized) / 1e6);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string task = argc > 3 ? argv[1] : "";
    if (task != "global" && task != "kidnapped" && task != "log")
      throw Error("run_markov global|kidnapped|log SITE LOG [TIMES]");
    const int times = argc > 4 ? std::stoi(argv[4]) : 50;
    const Run run(io::read_site(argv[2]), argv[3]);
    if (task == "global") global(run, times);
    if (task == "kidnapped") kidnapped(run, times);
    if (task == "log") along(run);
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
