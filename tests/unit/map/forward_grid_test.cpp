// SPDX-License-Identifier: Apache-2.0
#include "majak/map/forward_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/map/known_map.hpp"
#include "majak/sim/world.hpp"

namespace majak::map {
namespace {

ForwardGridOptions options_of(double resolution) {
  ForwardGridOptions options;
  options.resolution = resolution;
  options.sigma = resolution;
  options.scan_spacing = options.scan_turn = 0;
  return options;
}

PosedScan scan_at(const Pose2& pose, std::vector<float> ranges, double start = 0,
                  double step = radians(1)) {
  PosedScan posed;
  posed.estimate.T_map_robot = pose;
  posed.scan.start_angle = start;
  posed.scan.angle_step = step;
  posed.scan.max_range = 80;
  posed.scan.ranges = std::move(ranges);
  return posed;
}

/// What a laser with a normal error sees; nothing moves.
PosedScan look(const sim::World& world, const Pose2& pose, int number, double noise, int beams = 91,
               double field = kPi) {
  PosedScan posed = scan_at(pose, {}, -field / 2, field / (beams - 1));
  RandomStream random(7, static_cast<std::uint64_t>(number));
  for (int i = 0; i < beams; ++i) {
    const double angle = pose.theta + posed.scan.angle(static_cast<std::size_t>(i));
    const double range = world.cast(pose.translation(), angle, 30).range;
    posed.scan.ranges.push_back(
        std::isfinite(range) ? static_cast<float>(range + noise * random.normal()) : kNoReturn);
  }
  return posed;
}

sim::World room() {
  sim::Scene scene;
  const std::vector<Vec2> corners = {{0, 0}, {4, 0}, {4, 3}, {0, 3}};
  for (std::size_t i = 0; i < corners.size(); ++i)
    scene.segments.push_back({corners[i], corners[(i + 1) % corners.size()]});
  scene.segments.push_back({{2.1, 1.0}, {2.1, 2.1}});
  return sim::World(std::move(scene));
}

Site walk_in_room(int scans = 12, double noise = 0.02) {
  const sim::World world = room();
  Site site;
  for (int i = 0; i < scans; ++i) {
    const double turn = 2 * kPi * i / scans + 0.1;
    site.scans.push_back(
        look(world, {2 + 1.3 * std::cos(turn), 1.5 + std::sin(turn), 3 * turn}, i, noise));
  }
  return site;
}

// --- The slow twin: the log-posterior of a whole map, straight from (17.1) to (17.3)
// --------------

double log_density(const ForwardGrid& grid, const ForwardGridOptions& o, const Vec2& from,
                   double angle, float measured) {
  const double step = o.resolution / 2, window = 4 * std::max(o.sigma, o.resolution / 2);
  const ForwardModel& m = grid.model();
  const bool stopped = measured <= o.max_range;
  const double range =
      stopped ? measured
              : std::min(o.max_range, std::isinf(measured) ? o.no_return_range : o.max_range);
  double left = 1 - m.random - m.none, sum = 0;
  for (int k = 0; (k + 0.5) * step <= range + (stopped ? window : 0); ++k) {
    const double r = (k + 0.5) * step, u = (range - r) / m.sigma;
    for (int ray = 0; ray < o.rays; ++ray) {
      const double aside = o.rays > 1 ? o.beam_width * (ray / (o.rays - 1) - 0.5) : 0;
      const Vec2 way(std::cos(angle + aside), std::sin(angle + aside));
      const Vec2 p = (from + r * way) / o.resolution;
      // stop() is of a whole cell, two steps.
      const double stop = 1 - std::sqrt(1 - grid.stop(static_cast<int>(std::floor(p.x())),
                                                      static_cast<int>(std::floor(p.y()))));
      if (std::abs(range - r) <= window)
        sum += left * stop * std::exp(-u * u / 2) / (m.sigma * std::sqrt(2 * std::numbers::pi));
      left *= 1 - stop;
    }
  }
  return std::log(stopped ? sum + m.random / o.max_range : left + m.none);
}

struct Twin {
  double sum = 0;
  std::size_t beams = 0;
};
Twin twin(const ForwardGrid& grid, const ForwardGridOptions& o, const PosedScan& posed) {
  Twin twin;
  const Pose2 laser = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
  for (std::size_t i = 0; i < posed.scan.ranges.size(); ++i) {
    const float r = posed.scan.ranges[i];
    if (!(r > 0) || (std::isinf(r) && o.no_return_range == 0)) continue;
    twin.sum += log_density(grid, o, laser.translation(), laser.theta + posed.scan.angle(i), r);
    ++twin.beams;
  }
  return twin;
}

double log_prior(const ForwardGrid& grid, const ForwardGridOptions& o) {
  const double stop = 2 * o.prior_weight * o.prior_stop, pass = 2 * o.prior_weight - stop;
  const CellBox box = grid.bounds();
  const auto tile = [](int cell) {
    return (cell >> ForwardCells::kTileBits) * ForwardCells::kTileSize;
  };
  double sum = stop * std::log(o.prior_stop) + pass * std::log(1 - o.prior_stop);  // all outside
  for (int y = tile(box.y0); y < tile(box.y0 + box.height - 1) + ForwardCells::kTileSize; ++y)
    for (int x = tile(box.x0); x < tile(box.x0 + box.width - 1) + ForwardCells::kTileSize; ++x) {
      const double half = std::sqrt(1 - grid.stop(x, y));
      sum += stop * std::log(1 - half) + pass * std::log(half);
    }
  const ForwardModel& m = grid.model();
  return sum + std::log(m.random) + std::log(m.none) + std::log(1 - m.random - m.none);
}

TEST(ForwardGrid, LikelihoodEqualsTheSlowTwin) {
  Site site = walk_in_room();
  ForwardGridOptions options = options_of(0.1);
  options.no_return_range = 2;
  options.max_range = 2.6;  // some returns lie beyond
  site.scans[3].scan.ranges[5] = kNoReturn;
  site.scans[3].scan.ranges[6] = kInvalidRange;
  const ForwardGrid grid = build_forward_grid(site, options);
  for (int i = 0; i < 5; ++i) {
    const PosedScan other = look(room(), {1.1 + 0.1 * i, 1.7, 0.7 * i}, 100 + i, 0.02);
    const BeamScore fast = grid.log_likelihood(other);
    const Twin slow = twin(grid, options, other);
    EXPECT_EQ(fast.beams, slow.beams);
    EXPECT_NEAR(fast.log_likelihood, slow.sum, 1e-6 * static_cast<double>(slow.beams));
  }
}

TEST(ForwardGrid, PosteriorEqualsTheSlowTwinAndNeverFalls) {
  const Site site = walk_in_room();
  ForwardGridOptions options = options_of(0.1);
  options.tolerance = 0;
  options.beam_width = 0.05;
  for (const auto& [rounds, rays] : {std::pair(1, 1), {2, 1}, {30, 1}, {5, 4}, {30, 4}}) {
    options.rounds = rounds;
    options.rays = rays;
    const ForwardGrid grid = build_forward_grid(site, options);
    ASSERT_EQ(grid.posterior().size(), rounds);
    double slow = log_prior(grid, options);
    for (const PosedScan& scan : site.scans) slow += twin(grid, options, scan).sum;
    EXPECT_NEAR(grid.posterior().back(), slow, 1e-4);
    for (std::size_t i = 1; i < grid.posterior().size(); ++i)
      EXPECT_GE(grid.posterior()[i], grid.posterior()[i - 1] - 1e-6);
  }
}

// --- A tiny world: all maps --------------------------------------------------------------------

TEST(ForwardGrid, IsThePatternThatAllMapsTogetherFindLikeliest) {
  // Eight cells in a row, a beam along them; what stands in them is a thin thing that stops three
  // of four beams, or nothing. All 256 maps are asked.
  constexpr int kCells = 8;
  constexpr double kStop = 0.75, kFree = 1e-3;
  for (const unsigned truth : {0b10000000U, 0b10010000U, 0b10100100U, 0b11000000U}) {
    RandomStream random(5, truth);
    Site site;
    for (int i = 0; i < 400; ++i) {
      int cell = 0;
      while (cell < kCells - 1 && !((truth >> cell & 1U) && random.uniform(0, 1) < kStop)) ++cell;
      const double range = cell + 0.5 + 0.15 * random.normal();
      site.scans.push_back(scan_at({0, 0.5, 0}, {static_cast<float>(range)}));
    }
    ForwardGridOptions options = options_of(1);
    options.tolerance = 1e-7;
    options.rounds = 200;
    const ForwardGrid grid = build_forward_grid(site, options);
    double best = -1e300;
    unsigned likeliest = 0, found = 0;
    for (unsigned map = 0; map < 1U << kCells; ++map) {
      double sum = 0;
      for (const PosedScan& scan : site.scans) {
        double left = 1, p = 1e-4;
        for (int k = 0; k < 2 * kCells; ++k) {
          const double stop = 1 - std::sqrt(1 - (map >> (k / 2) & 1U ? kStop : kFree));
          const double u = (scan.scan.ranges[0] - (k + 0.5) / 2) / grid.model().sigma;
          p += left * stop * std::exp(-u * u / 2) / grid.model().sigma;
          left *= 1 - stop;
        }
        sum += std::log(p);
      }
      if (sum > best) best = sum, likeliest = map;
    }
    for (int k = 0; k < kCells; ++k) found |= (grid.stop(k, 0) > 0.3 ? 1U : 0U) << k;
    EXPECT_EQ(likeliest, truth);
    EXPECT_EQ(found, truth);
  }
}

TEST(ForwardGrid, FindsHowManyBeamsEachThingStops) {
  // A fence that stops 30 % of beams, a wall behind.
  RandomStream random(11, 0);
  Site site;
  constexpr int kBeams = 3000;
  int stopped = 0;
  for (int i = 0; i < kBeams; ++i) {
    const bool fence = random.uniform(0, 1) < 0.3;
    stopped += fence;
    const double range = (fence ? 2.25 : 4.25) + 0.03 * random.normal();
    site.scans.push_back(scan_at({0.01, 0.1, 0}, {static_cast<float>(range)}));
  }
  ForwardGridOptions options = options_of(0.5);
  options.sigma = 0.1;
  const ForwardGrid grid = build_forward_grid(site, options);
  EXPECT_NEAR(grid.stop(4, 0), stopped / double{kBeams}, 0.005);
  EXPECT_NEAR(grid.stop_sigma(4, 0), std::sqrt(0.3 * 0.7 / kBeams), 0.002);
  EXPECT_GT(grid.stop(8, 0), 0.98);
  for (const int free : {0, 1, 2, 3, 5, 6, 7}) EXPECT_LT(grid.stop(free, 0), 0.005) << free;
}

TEST(ForwardGrid, LearnsTheRangesSigma) {
  // Steps of 0.25 m are too far apart for a wall to be spread over two of them.
  RandomStream random(12, 0);
  Site site;
  constexpr int kBeams = 4000;
  for (int i = 0; i < kBeams; ++i)
    site.scans.push_back(
        scan_at({0, 0.1, 0}, {static_cast<float>(3.125 + 0.05 * random.normal())}));
  const ForwardGrid grid = build_forward_grid(site, options_of(0.5));
  // No less than a quarter of a cell by itself, though.
  EXPECT_NEAR(grid.model().sigma, 0.125, 1e-12);
  ForwardGridOptions wide = options_of(0.5);
  for (PosedScan& scan : site.scans)
    scan.scan.ranges[0] = static_cast<float>(3.125 + 0.15 * random.normal());
  wide.sigma = 0.3;
  EXPECT_NEAR(build_forward_grid(site, wide).model().sigma, 0.15, 0.03);
}

// --- The doorway ---------------------------------------------------------------------------------

// A wall along y = 2 with a doorway from x = 0 to 0.5, seen from a corridor below by beams that are
// wide: the first thing in the cone is what is measured.
constexpr double kCone = radians(18);
constexpr int kConeRays = 15;

sim::World doorway() {
  sim::Scene scene;
  scene.segments = {{{-4, 2}, {0, 2}},  {{0.5, 2}, {5, 2}}, {{-4, 0}, {5, 0}},
                    {{-4, 4}, {5, 4}},  {{0, 2}, {0, 2.1}}, {{0.5, 2}, {0.5, 2.1}},
                    {{-4, 0}, {-4, 4}}, {{5, 0}, {5, 4}}};
  return sim::World(std::move(scene));
}

Site drive_past_the_doorway() {
  const sim::World world = doorway();
  Site site;
  // Often from afar, a few times from near by.
  for (int i = 0; i < 80; ++i) {
    const bool near = i >= 68;
    const Pose2 pose{near ? -2 + 0.38 * (i - 68) : -3 + 0.1 * i, near ? 1.2 : 0.5, 0.02 * (i % 7)};
    PosedScan posed = scan_at(pose, {}, -kPi / 2, kPi / 60);
    RandomStream random(3, static_cast<std::uint64_t>(i));
    for (std::size_t k = 0; k <= 60; ++k) {
      double nearest = 1e9;
      for (int ray = 0; ray < kConeRays; ++ray) {
        const double angle =
            pose.theta + posed.scan.angle(k) + kCone * (ray / (kConeRays - 1.0) - 0.5);
        nearest = std::min(nearest, world.cast(pose.translation(), angle, 20).range);
      }
      posed.scan.ranges.push_back(static_cast<float>(nearest + 0.01 * random.normal()));
    }
    site.scans.push_back(posed);
  }
  return site;
}

/// A row of cells about the wall through which nothing leads.
bool closed(const OccupancyGrid& grid) {
  for (int y = 18; y < 23; ++y) {
    bool all = true;
    for (int x = -15; x < 25; ++x) all &= grid.log_odds(x, y) > 0;
    if (all) return true;
  }
  return false;
}

TEST(ForwardGrid, KeepsTheDoorwayOpenThatLogOddsClose) {
  const Site site = drive_past_the_doorway();
  OccupancyGridOptions plain;
  plain.resolution = 0.1;
  plain.scan_spacing = plain.scan_turn = 0;
  EXPECT_TRUE(closed(build_occupancy_grid(site, plain)));

  ForwardGridOptions options = options_of(0.1);
  options.beam_width = kCone;
  options.rays = 9;
  const OccupancyGrid forward = build_forward_grid(site, options).log_odds();
  EXPECT_FALSE(closed(forward));
  for (int y = 18; y < 23; ++y)
    for (int x = 1; x < 4; ++x) EXPECT_LT(forward.log_odds(x, y), -1) << x << ' ' << y;
  for (int x = 6; x < 20; ++x) {  // and the wall beside it is one
    EXPECT_GT(forward.log_odds(x, 20), 0) << x;
    EXPECT_GT(forward.log_odds(-x, 20), 0) << -x;
    EXPECT_LT(forward.log_odds(x, 19), 0) << x;
  }
  options.rays = 1;  // it is the cone that explains what seems to stand in the doorway
  const OccupancyGrid thin = build_forward_grid(site, options).log_odds();
  EXPECT_GT(thin.log_odds(1, 20), 0);
}

// --- Odds and ends -------------------------------------------------------------------------------

TEST(ForwardGrid, IsTheSameForAnyNumberOfThreads) {
  const Site site = walk_in_room();
  const ForwardGrid one = build_forward_grid(site, options_of(0.05), Threads{1});
  for (const int threads : {2, 8}) {
    const ForwardGrid more = build_forward_grid(site, options_of(0.05), Threads{threads});
    EXPECT_EQ(one.posterior(), more.posterior());
    ASSERT_EQ(one.bounds(), more.bounds());
    const CellBox box = one.bounds();
    for (int y = box.y0; y < box.y0 + box.height; ++y)
      for (int x = box.x0; x < box.x0 + box.width; ++x) {
        ASSERT_EQ(one.stop(x, y), more.stop(x, y));
        ASSERT_EQ(one.stop_sigma(x, y), more.stop_sigma(x, y));
      }
  }
}

TEST(ForwardGrid, SurvivesSitesThatTellLittle) {
  const ForwardGrid none = build_forward_grid(Site{});
  EXPECT_EQ(none.bounds(), CellBox{});
  EXPECT_NEAR(none.stop(5, 5), 1 - 0.98 * 0.98, 1e-12);
  Site empty;
  empty.scans.push_back(scan_at({0, 0, 0}, std::vector<float>(50, kNoReturn)));
  EXPECT_EQ(build_forward_grid(empty).known_area(), 0);
  ForwardGridOptions clearing;
  clearing.no_return_range = 3;
  const ForwardGrid free = build_forward_grid(empty, clearing);
  EXPECT_GT(free.known_area(), 2);
  EXPECT_LT(free.stop(20, 5), 0.0396);  // less than the prior
  Site one;
  one.scans.push_back(scan_at({0, 0, 0}, {2.0F, kInvalidRange, -1.0F, 0.0F, 1e9F}));
  const ForwardGrid wall = build_forward_grid(one);
  EXPECT_GT(wall.stop(40, 0) + wall.stop(39, 0), 0.2);
  Site lost = one;
  lost.scans[0].estimate.health = Health::lost;
  EXPECT_EQ(build_forward_grid(lost).scans_drawn(), 0U);
  lost.scans[0].estimate = {};
  lost.scans[0].estimate.T_map_robot.x = std::nan("");
  EXPECT_EQ(build_forward_grid(lost).scans_drawn(), 0U);
}

TEST(ForwardGrid, RefusesOptionsOutOfRange) {
  ForwardGridOptions options;
  options.resolution = 0;
  EXPECT_THROW(build_forward_grid(Site{}, options), Error);
}

TEST(ForwardGrid, AsLogOddsIsTheSameMap) {
  const ForwardGrid grid = build_forward_grid(walk_in_room(), options_of(0.1));
  const OccupancyGrid odds = grid.log_odds();
  const CellBox box = grid.bounds();
  EXPECT_EQ(odds.bounds(), box);
  for (int y = box.y0; y < box.y0 + box.height; ++y)
    for (int x = box.x0; x < box.x0 + box.width; ++x)
      if (grid.known(x, y)) {
        EXPECT_NEAR(1 / (1 + std::exp(-double{odds.log_odds(x, y)})), grid.stop(x, y), 3e-4);
      }
}

TEST(ForwardGrid, FindsUnseenScansLikelierThanLogOdds) {
  const Site site = walk_in_room(40);
  OccupancyGridOptions plain;
  plain.resolution = 0.05;
  plain.scan_spacing = plain.scan_turn = 0;
  const ForwardGrid forward = build_forward_grid(site, options_of(0.05));
  const ForwardGrid log_odds =
      fit_to_log_odds(build_occupancy_grid(site, plain), site, options_of(0.05));
  EXPECT_GE(forward.posterior().size(), 2U);
  double by_forward = 0, by_log_odds = 0;
  for (int i = 0; i < 20; ++i) {
    const PosedScan other = look(room(), {1.1 + 0.1 * i, 0.4 + 0.1 * i, 0.7 * i}, 100 + i, 0.02);
    by_forward += forward.log_likelihood(other).log_likelihood;
    by_log_odds += log_odds.log_likelihood(other).log_likelihood;
  }
  EXPECT_GT(by_forward, by_log_odds + 0.1 * 20 * 91);
}

TEST(ForwardGrid, TiedCellsAreAlike) {
  const Site site = walk_in_room(40);
  OccupancyGridOptions plain;
  plain.scan_spacing = plain.scan_turn = 0;
  const OccupancyGrid odds = build_occupancy_grid(site, plain);
  const ForwardGrid tied = fit_to_log_odds(odds, site, options_of(0.05));
  std::vector<std::optional<double>> stop(300);
  const CellBox box = tied.bounds();
  for (int y = box.y0; y < box.y0 + box.height; ++y)
    for (int x = box.x0; x < box.x0 + box.width; ++x) {
      if (!odds.known(x, y)) continue;
      auto& of_kind =
          stop[static_cast<std::size_t>(150 + std::lround(odds.log_odds(x, y) / 0.25F))];
      if (!of_kind) of_kind = tied.stop(x, y);
      ASSERT_EQ(*of_kind, tied.stop(x, y));
    }
  for (std::size_t i = 1; i < tied.posterior().size(); ++i)
    EXPECT_GE(tied.posterior()[i], tied.posterior()[i - 1] - 1e-6);
}

}  // namespace
}  // namespace majak::map
