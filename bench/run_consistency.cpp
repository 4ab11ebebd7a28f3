// SPDX-License-Identifier: Apache-2.0
// Are the covariances honest? Many simulated runs of each built-in world, mapped with default
// options; NEES over all poses of a run and of its last pose, against the chi-square band.
//   run_consistency [--runs N] [--document F]
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/parallel.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/slam/graph_slam.hpp"

namespace majak::bench {
namespace {

struct Case {
  std::string world;
  bool short_tour = false, odometry = true;
};

struct Result {
  std::vector<double> mean, last;  ///< NEES of each run
};

constexpr int kFirstSeed = 1001;

Site map_run(const Case& c, int seed) {
  const sim::World world(sim::built_in(c.world));
  sim::SimulationOptions options;
  options.seed = seed;
  slam::GraphSlamOptions slam_options;
  slam_options.chain.use_odometry = c.odometry;
  slam::GraphSlam slam(slam_options, {1});
  for (Event& event :
       sim::simulate(world, sim::plan_tour(world, {.short_tour = c.short_tour}), options))
    slam.add(std::move(event));
  return slam.finish().site;
}

double mean(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

Result run(const Case& c, int runs) {
  Result result{std::vector<double>(static_cast<std::size_t>(runs)),
                std::vector<double>(static_cast<std::size_t>(runs))};
  parallel_for({}, static_cast<std::size_t>(runs), [&](std::size_t i) {
    const Site site = map_run(c, kFirstSeed + static_cast<int>(i));
    std::vector<Estimate> estimates;
    for (const PosedScan& scan : site.scans) estimates.push_back(scan.estimate);
    const std::vector<double> nees = eval::nees_of_run(estimates, eval::truth_of(site.truth));
    result.mean[i] = mean(nees);
    result.last[i] = nees.back();
  });
  return result;
}

std::string table(int runs) {
  std::ostringstream out;
  const double n = 3.0 * runs;
  out << fmt::format(
      "{} runs a row; 3 expected, 95 % band of the mean over that many independent poses {:.2f} "
      "... {:.2f}.\n\n",
      runs, eval::chi_square_quantile(0.025, n) / runs, eval::chi_square_quantile(0.975, n) / runs);
  out << "| world | odometry | NEES, all poses of a run | worst run | NEES, last pose "
         "|\n|---|---|---|---|---|\n";
  for (const Case& c : {Case{"building"}, Case{"building", true}, Case{"ring"}, Case{"corridor"},
                        Case{"building", false, false}, Case{"building", true, false},
                        Case{"ring", false, false}}) {
    const Result r = run(c, runs);
    out << fmt::format("| {}{} | {} | {:.2f} | {:.1f} | {:.2f} |\n", c.world,
                       c.short_tour ? ", short tour" : "", c.odometry ? "yes" : "no", mean(r.mean),
                       *std::max_element(r.mean.begin(), r.mean.end()), mean(r.last));
  }
  return out.str();
}

void put_between_markers(const std::string& document, const std::string& text) {
  std::ifstream in(document);
  std::stringstream whole;
  whole << in.rdbuf();
  std::string s = whole.str();
  const std::string begin = "<!-- consistency: begin -->\n", end = "<!-- consistency: end -->";
  const std::size_t a = s.find(begin), b = s.find(end);
  if (a == std::string::npos || b == std::string::npos)
    throw Error(document + ": has no markers for the table");
  s.replace(a + begin.size(), b - a - begin.size(), text);
  std::ofstream(document) << s;
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  int runs = 50;
  std::string document;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--runs") runs = std::atoi(argv[i + 1]);
    if (std::string(argv[i]) == "--document") document = argv[i + 1];
  }
  try {
    const std::string table = majak::bench::table(std::max(runs, 1));
    fmt::print("{}", table);
    if (!document.empty()) majak::bench::put_between_markers(document, table);
  } catch (const majak::Error& error) {
    fmt::print(stderr, "run_consistency: {}\n", error.what());
    return 1;
  }
  return 0;
}
