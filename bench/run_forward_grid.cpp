// SPDX-License-Identifier: Apache-2.0
// Forward-model grid against log-odds grid: how likely each finds scans that it was not made from.
//   run_forward_grid RUN|SEED [--pieces] [--threads N] [NAME=VALUE ...]
// RUN is a run's folder or its site.majak; SEED a number: a simulated tour of a building with that
// seed, true poses. Every tenth of the scans that would be drawn is held out, with --pieces every
// other 12 m of the way. Options of both grids (forward_grid.*, grid.*) may be given.
//   mixture        nats a beam by the forward model; the log-odds grid as the likeliest function of
//                  its log-odds; (own): of the scans that made the map
//   cell by cell   nats a beam, cells before it passed, the last one hit, each by itself; cells of
//                  like log-odds as the scans that made the map had them, or (own odds) as stated
//   within, median the range before which half of all beams end, against the measured one
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

#include "bench/split_site.hpp"
#include "majak/core/error.hpp"
#include "majak/io/known_map_files.hpp"
#include "majak/io/options_file.hpp"
#include "majak/map/forward_grid.hpp"
#include "majak/map/ray.hpp"
#include "majak/map/scan_choice.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace {

using namespace majak;

double cpu() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double wall() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Probability that a beam which comes into a cell ends there, by the cell's log-odds.
class Calibrated {
 public:
  Calibrated(const map::OccupancyGrid& grid, const Site& site, double max_range)
      : grid_(grid), max_range_(max_range), ends_(kKinds, 0.5), beams_(kKinds, 1) {
    for (const PosedScan& scan : site.scans)
      for_each_beam(scan, [&](const std::vector<std::size_t>& kinds, double /*range*/) {
        for (const std::size_t kind : kinds) ++beams_[kind];
        ++ends_[kinds.back()];
      });
  }
  /// As beams of the scans that made the map have it, and as the map's log-odds say.
  double probability(std::size_t kind) const { return ends_[kind] / beams_[kind]; }
  static double own(std::size_t kind) {
    return kind == 0 ? 0.5 : 1 / (1 + std::exp(0.25 * (129 - static_cast<double>(kind))));
  }

  /// Kinds of the cells from the laser's to the one the beam ends in.
  template <class Visit>
  void for_each_beam(const PosedScan& posed, Visit visit) const {
    const Pose2 T = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
    std::vector<std::size_t> kinds;
    for (std::size_t i = 0; i < posed.scan.ranges.size(); ++i) {
      const double range = posed.scan.ranges[i];
      if (!(range > 0 && range <= max_range_)) continue;
      kinds.clear();
      walk(T, posed.scan.angle(i), range, [&](std::size_t kind) {
        kinds.push_back(kind);
        return true;
      });
      visit(kinds, range);
    }
  }
  /// Range before which half of all beams end.
  double median_range(const Pose2& T, double angle) const {
    double left = 1, cells = 0;
    walk(T, angle, max_range_, [&](std::size_t kind) {
      left *= 1 - probability(kind);
      if (left > 0.5) ++cells;
      return left > 0.5;
    });
    const double long_side =
        std::max(std::abs(std::cos(T.theta + angle)), std::abs(std::sin(T.theta + angle)));
    return cells * grid_.resolution() / long_side;
  }

 private:
  static constexpr std::size_t kKinds = 260;
  std::size_t kind(int ix, int iy) const {
    if (!grid_.known(ix, iy)) return 0;
    return static_cast<std::size_t>(129 + std::lround(grid_.log_odds(ix, iy) / 0.25F));
  }
  /// One cell for each cell's width along the longer axis.
  template <class Visit>
  void walk(const Pose2& T, double angle, double range, Visit visit) const {
    const Vec2 way(std::cos(T.theta + angle), std::sin(T.theta + angle));
    const double longer = way.cwiseAbs().maxCoeff(), cell = grid_.resolution();
    const Vec2 step = way / longer;  // cells
    const int steps = static_cast<int>(range * longer / cell);
    const Vec2 end = (T.translation() + range * way) / cell;
    for (int k = steps; k >= 0; --k) {
      const Vec2 p = end - k * step;
      if (!visit(kind(static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())))))
        return;
    }
  }
  const map::OccupancyGrid& grid_;
  double max_range_;
  std::vector<double> ends_, beams_;
};

struct Split {
  Site made, asked;
};

Split split(Site site, const map::ForwardGridOptions& options, bool pieces) {
  Split out;
  const std::vector<int> piece = bench::by_way(site);
  const auto chosen = map::scans_to_draw(
      site, {options.resolution, options.max_range, options.scan_spacing, options.scan_turn});
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const bool ask = pieces ? piece[chosen[i]] % 2 != 0 : i % 10 == 9;
    (ask ? out.asked : out.made).scans.push_back(std::move(site.scans[chosen[i]]));
  }
  return out;
}

Site simulated(int seed) {
  const sim::World world(sim::building());
  sim::SimulationOptions options;
  options.seed = seed;
  Site site;
  for (const Event& event : sim::simulate(world, sim::plan_tour(world), options)) {
    if (const auto* scan = std::get_if<Scan>(&event)) site.scans.emplace_back().scan = *scan;
    if (const auto* truth = std::get_if<Truth>(&event))
      site.scans.back().estimate.T_map_robot = truth->T_world_robot;
  }
  return site;
}

struct Mean {
  double sum = 0, n = 0;
  void add(double value) { sum += value, ++n; }
  double mean() const { return sum / std::max(n, 1.0); }
};

double mixture(const map::ForwardGrid& grid, const Site& site) {
  Mean mean;
  for (const PosedScan& scan : site.scans) {
    const map::BeamScore s = grid.log_likelihood(scan);
    mean.sum += s.log_likelihood, mean.n += static_cast<double>(s.beams);
  }
  return mean.mean();
}

/// Each cell by itself: log(1 - p) of those before, log p of the one the beam ends in.
template <class Probability>
double cell_by_cell(const Calibrated& cells, const Site& site, Probability probability) {
  Mean mean;
  for (const PosedScan& scan : site.scans)
    cells.for_each_beam(scan, [&](const std::vector<std::size_t>& kinds, double) {
      double sum = std::log(probability(kinds.back()));
      for (std::size_t k = 0; k + 1 < kinds.size(); ++k) sum += std::log(1 - probability(kinds[k]));
      mean.add(sum);
    });
  return mean.mean();
}

/// Of every fifth beam, how far off the range is that the map lets expect (m).
std::vector<double> range_errors(const Calibrated& cells, const Site& site, double max_range) {
  std::vector<double> errors;
  for (const PosedScan& posed : site.scans) {
    const Pose2 T = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
    for (std::size_t i = 0; i < posed.scan.ranges.size(); i += 5) {
      const double r = posed.scan.ranges[i];
      if (r > 0 && r <= max_range)
        errors.push_back(std::abs(cells.median_range(T, posed.scan.angle(i)) - r));
    }
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

void scores(const char* name, const map::ForwardGrid& forward, const map::OccupancyGrid& grid,
            const Split& split, double max_range) {
  const Calibrated cells(grid, split.made, max_range);
  const std::vector<double> errors = range_errors(cells, split.asked, max_range);
  const auto near = std::lower_bound(errors.begin(), errors.end(), 0.1) - errors.begin();
  fmt::print("{:<9} {:>8.3f} ({:>6.3f}) {:>11.3f} {:>11.3f} {:>9.1f} % {:>7.3f} m\n", name,
             mixture(forward, split.asked), mixture(forward, split.made),
             cell_by_cell(cells, split.asked, [&](std::size_t k) { return cells.probability(k); }),
             cell_by_cell(cells, split.asked, [&](std::size_t k) { return Calibrated::own(k); }),
             100.0 * static_cast<double>(near) / static_cast<double>(errors.size()),
             errors[errors.size() / 2]);
}

void measure(const std::string& run, map::ForwardGridOptions options,
             map::OccupancyGridOptions grid_options, bool pieces, Threads threads) {
  const bool seed = !run.empty() && run.find_first_not_of("0123456789") == std::string::npos;
  std::optional<Site> site;
  if (seed)
    site = simulated(std::atoi(run.c_str()));
  else
    site = io::read_map(run).site;
  if (!site) throw Error(run + ": not a run");
  grid_options.resolution = options.resolution;
  grid_options.max_range = options.max_range;
  {
    const double begin = cpu(), begin_wall = wall();
    const map::ForwardGrid whole = build_forward_grid(*site, options, threads);
    fmt::print(
        "{} scans of {}, {} rounds, {:.2f} s of CPU, {:.2f} s; {} bytes, {:.0f} m2; "
        "log-odds {} bytes\n",
        whole.scans_drawn(), site->scans.size(), whole.posterior().size(), cpu() - begin,
        wall() - begin_wall, whole.bytes(), whole.known_area(),
        build_occupancy_grid(*site, grid_options).bytes());
  }
  const Split parts = split(std::move(*site), options, pieces);
  options.scan_spacing = grid_options.scan_spacing = 0;
  options.scan_turn = grid_options.scan_turn = 0;
  const map::OccupancyGrid log_odds = build_occupancy_grid(parts.made, grid_options, threads);
  const map::ForwardGrid forward = build_forward_grid(parts.made, options, threads);
  const map::ForwardGrid tied = fit_to_log_odds(log_odds, parts.made, options, threads);
  fmt::print("{} scans made the maps, {} are asked\n", parts.made.scans.size(),
             parts.asked.scans.size());
  fmt::print("          mixture (own)     cell by cell  (own odds)  within 0.1 m  median\n");
  scores("log-odds", tied, log_odds, parts, options.max_range);
  scores("forward", forward, forward.log_odds(), parts, options.max_range);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 2)
      throw Error("usage: run_forward_grid RUN|SEED [--pieces] [--threads N] [NAME=VALUE ...]");
    map::ForwardGridOptions options;
    map::OccupancyGridOptions grid_options;
    OptionFields fields;
    describe(fields, options);
    describe(fields, grid_options);
    bool pieces = false;
    Threads threads{2};
    for (int i = 2; i < argc; ++i) {
      if (std::string_view(argv[i]) == "--pieces")
        pieces = true;
      else if (std::string_view(argv[i]) == "--threads" && i + 1 < argc)
        threads.count = std::atoi(argv[++i]);
      else
        io::apply_option(fields, argv[i]);
    }
    measure(argv[1], options, grid_options, pieces, threads);
    return 0;
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
