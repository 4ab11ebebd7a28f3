// SPDX-License-Identifier: Apache-2.0
#include "majak/map/occupancy_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::map {
namespace {

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

OccupancyGridOptions metre_cells() {
  OccupancyGridOptions options;
  options.resolution = 1;
  options.scan_spacing = 0;
  options.scan_turn = 0;
  return options;
}

/// '#' occupied, '.' free, ' ' unknown; the first line is the highest row.
std::string picture(const OccupancyGrid& grid, CellBox box) {
  std::string text;
  for (int y = box.y0 + box.height - 1; y >= box.y0; --y) {
    for (int x = box.x0; x < box.x0 + box.width; ++x) {
      text += !grid.known(x, y) ? ' ' : grid.log_odds(x, y) > 0 ? '#' : '.';
    }
    text += '\n';
  }
  return text;
}

TEST(OccupancyGrid, IsUnknownEverywhereAtFirst) {
  const OccupancyGrid grid(0.1);
  EXPECT_EQ(grid.bounds(), CellBox{});
  EXPECT_FALSE(grid.known(0, 0));
  EXPECT_EQ(grid.log_odds(-5, 7), 0.0F);
  EXPECT_EQ(grid.known_area(), 0.0);
}

TEST(OccupancyGrid, KeepsWhatIsSetAcrossTilesAndSigns) {
  OccupancyGrid grid(0.1);
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(-1, -1), std::pair(63, 64),
                             std::pair(-64, -65), std::pair(1000, -3)}) {
    grid.set_log_odds(x, y, static_cast<float>(x + y) / 1000);
    EXPECT_TRUE(grid.known(x, y));
    EXPECT_NEAR(grid.log_odds(x, y), static_cast<float>(x + y) / 1000, 1e-6);
  }
  EXPECT_EQ(grid.bounds(), (CellBox{-64, -65, 1065, 130}));
  EXPECT_NEAR(grid.known_area(), 5 * 0.01, 1e-12);
  EXPECT_FALSE(grid.known(1, 0));
}

TEST(OccupancyGrid, CopiesRowsAsCellsTell) {
  OccupancyGrid grid(1);
  for (const int x : {-70, -1, 0, 63, 64, 130}) grid.set_log_odds(x, 5, 1);
  std::vector<std::int16_t> row(300);
  grid.copy_row(-100, 5, 300, row.data());
  for (int x = -100; x < 200; ++x) {
    EXPECT_EQ(row[static_cast<std::size_t>(x + 100)] != OccupancyGrid::kUnknown, grid.known(x, 5))
        << x;
  }
}

TEST(OccupancyGrid, CoarserCellsKeepWhatStandsInTheWay) {
  RandomStream random(4, 0);
  OccupancyGrid grid(0.05);
  for (int i = 0; i < 3000; ++i)
    grid.set_log_odds(static_cast<int>(random.uniform(-90, 90)),
                      static_cast<int>(random.uniform(-90, 90)),
                      static_cast<float>(random.uniform(-3, 3)));
  const OccupancyGrid twice = coarser(grid, 2), four = coarser(grid, 4), again = coarser(twice, 2);
  EXPECT_DOUBLE_EQ(four.resolution(), 0.2);
  EXPECT_LT(four.bytes(), grid.bytes() / 2);
  for (int y = -24; y < 24; ++y)
    for (int x = -24; x < 24; ++x) {
      bool known = false;
      float highest = -100;
      for (int k = 0; k < 16; ++k) {
        const int ix = 4 * x + k % 4, iy = 4 * y + k / 4;
        known |= grid.known(ix, iy);
        if (grid.known(ix, iy)) highest = std::max(highest, grid.log_odds(ix, iy));
      }
      ASSERT_EQ(four.known(x, y), known);
      ASSERT_EQ(again.known(x, y), known);
      if (!known) continue;
      ASSERT_NEAR(four.log_odds(x, y), highest, 1e-6);
      ASSERT_EQ(four.log_odds(x, y), again.log_odds(x, y));
    }
}

TEST(BuildOccupancyGrid, DrawsOneBeam) {
  Site site;
  site.scans = {scan_at({0.5, 0.5, 0}, {4.0F})};
  const OccupancyGrid grid = build_occupancy_grid(site, metre_cells());
  EXPECT_EQ(picture(grid, grid.bounds()), "....#\n");
  EXPECT_EQ(grid.bounds(), (CellBox{0, 0, 5, 1}));
  EXPECT_NEAR(grid.log_odds(4, 0), 1.1, 1e-6);
  EXPECT_NEAR(grid.log_odds(0, 0), -0.4, 1e-6);
  EXPECT_EQ(grid.scans_drawn(), 1U);
}

TEST(BuildOccupancyGrid, StandsWhereTheLaserIsAndLooksWhereItLooks) {
  Site site;
  site.scans = {scan_at({0.5, 0.5, kPi / 2}, {2.0F})};
  site.scans[0].scan.T_robot_laser = {1, 0, kPi / 2};  // one metre up the page, looking left
  const OccupancyGrid grid = build_occupancy_grid(site, metre_cells());
  EXPECT_EQ(picture(grid, {-2, 0, 3, 3}),
            "   \n"
            "#..\n"
            "   \n");
}

TEST(BuildOccupancyGrid, LetsAHitWinOverItsNeighboursInOneScan) {
  Site site;  // the second beam passes through the very cell in which the first one ends
  site.scans = {scan_at({0.5, 0.5, 0}, {3.0F, 6.0F}, 0, 1e-4)};
  const OccupancyGrid grid = build_occupancy_grid(site, metre_cells());
  EXPECT_EQ(picture(grid, grid.bounds()), "...#..#\n");
  EXPECT_NEAR(grid.log_odds(3, 0), 1.1, 1e-6);
  EXPECT_NEAR(grid.log_odds(1, 0), -0.4, 1e-6) << "once a scan, however many beams cross it";
}

TEST(BuildOccupancyGrid, DrawsNothingForBeamsWithoutReturn) {
  Site site;
  site.scans = {scan_at({0.5, 0.5, 0},
                        {kNoReturn, kInvalidRange, 0.0F, -std::numeric_limits<float>::infinity()})};
  EXPECT_EQ(build_occupancy_grid(site, metre_cells()).bounds(), CellBox{});
}

TEST(BuildOccupancyGrid, ClearsUpToWhereAnErasedBeamEnds) {
  Site site;
  site.scans = {scan_at({0.5, 0.5, 0}, {erased(3.0F)})};
  OccupancyGridOptions options = metre_cells();
  OccupancyGrid grid = build_occupancy_grid(site, options);
  EXPECT_EQ(picture(grid, grid.bounds()), "....\n");
  options.max_range = 2;
  grid = build_occupancy_grid(site, options);
  EXPECT_EQ(picture(grid, grid.bounds()), "...\n");
}

TEST(BuildOccupancyGrid, ClearsAlongBeamsWithoutReturnWhenAsked) {
  Site site;
  site.scans = {scan_at({0.5, 0.5, 0}, {kNoReturn})};
  OccupancyGridOptions options = metre_cells();
  options.no_return_range = 3;
  const OccupancyGrid grid = build_occupancy_grid(site, options);
  EXPECT_EQ(picture(grid, grid.bounds()), "....\n");
}

TEST(BuildOccupancyGrid, CutsLongBeamsAtTheMaximum) {
  Site site;
  site.scans = {scan_at({0.5, 0.5, 0}, {50.0F})};
  OccupancyGridOptions options = metre_cells();
  options.max_range = 4;
  const OccupancyGrid grid = build_occupancy_grid(site, options);
  EXPECT_EQ(picture(grid, grid.bounds()), ".....\n");
}

TEST(BuildOccupancyGrid, AddsUpAndStaysWithinItsLimit) {
  Site site;
  for (int i = 0; i < 100; ++i) site.scans.push_back(scan_at({0.5, 0.5, 0}, {4.0F}));
  const OccupancyGrid grid = build_occupancy_grid(site, metre_cells());
  EXPECT_NEAR(grid.log_odds(4, 0), 6.0, 1e-6);
  EXPECT_NEAR(grid.log_odds(2, 0), -6.0, 1e-6);
}

TEST(BuildOccupancyGrid, LeavesOutScansThatHardlyMoved) {
  Site site;
  for (int i = 0; i < 10; ++i) site.scans.push_back(scan_at({0.5 + 0.1 * i, 0.5, 0}, {4.0F}));
  OccupancyGridOptions options = metre_cells();
  options.scan_spacing = 0.25;
  options.scan_turn = 0.25;
  EXPECT_EQ(build_occupancy_grid(site, options).scans_drawn(), 4U);  // 0, 0.3, 0.6, 0.9
  for (int i = 0; i < 10; ++i)
    site.scans[static_cast<std::size_t>(i)].estimate.T_map_robot = {0, 0, 3.1 + 0.1 * i};
  EXPECT_EQ(build_occupancy_grid(site, options).scans_drawn(), 4U) << "turning through pi";
}

TEST(BuildOccupancyGrid, ChoosesTheScansOfEachLaserByItself) {
  Site site;
  for (int i = 0; i < 10; ++i) {
    site.scans.push_back(scan_at({0, 0, 0}, {4.0F}));
    site.scans.back().scan.laser = i % 2;
  }
  OccupancyGridOptions options = metre_cells();
  options.scan_spacing = 0.25;
  options.scan_turn = 0.25;
  EXPECT_EQ(build_occupancy_grid(site, options).scans_drawn(), 2U);
}

TEST(BuildOccupancyGrid, LeavesOutLostScansAndPosesThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Site site;
  for (const Pose2& pose :
       {Pose2{nan, 0, 0}, Pose2{0, 1e300, 0}, Pose2{0, 0, nan}, Pose2{-3e9, 0, 0}}) {
    site.scans.push_back(scan_at(pose, {4.0F}));
  }
  site.scans.push_back(scan_at({0, 0, 0}, {4.0F}));
  site.scans.back().estimate.health = Health::lost;
  site.scans.push_back(scan_at({0, 0, 0}, {4.0F}, nan));
  const OccupancyGrid grid = build_occupancy_grid(site, metre_cells());
  EXPECT_EQ(grid.scans_drawn(), 0U);
  EXPECT_EQ(grid.bounds(), CellBox{});
}

TEST(BuildOccupancyGrid, ManagesWithoutScansAndWithoutBeams) {
  EXPECT_EQ(build_occupancy_grid({}, {}).bounds(), CellBox{});
  Site site;
  site.scans = {scan_at({1, 2, 3}, {})};
  EXPECT_EQ(build_occupancy_grid(site, {}).bounds(), CellBox{});
}

TEST(BuildOccupancyGrid, RefusesOptionsOutOfTheirRange) {
  OccupancyGridOptions options;
  options.resolution = 0;
  EXPECT_THROW(build_occupancy_grid({}, options), Error);
  options = {};
  options.log_odds_hit = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(build_occupancy_grid({}, options), Error);
}

/// A robot that wanders in a square room.
Site wandering_site() {
  RandomStream random(7);
  Site site;
  for (int i = 0; i < 60; ++i) {
    std::vector<float> ranges(180);
    for (float& r : ranges) r = static_cast<float>(random.uniform(0.2, 9.0));
    for (std::size_t k = 0; k < ranges.size(); k += 17) ranges[k] = kNoReturn;
    site.scans.push_back(scan_at(
        {random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-3, 3)}, ranges, -kPi / 2));
    site.scans.back().scan.T_robot_laser = {0.2, -0.1, 0.05};
  }
  return site;
}

/// The same by dense sampling of each beam: per scan a set of free and a set of hit cells.
TEST(BuildOccupancyGrid, AgreesWithDenseSampling) {
  Site site = wandering_site();
  site.scans.resize(4);
  OccupancyGridOptions options;
  options.scan_spacing = options.scan_turn = 0;
  options.resolution = 0.2;
  const OccupancyGrid grid = build_occupancy_grid(site, options);
  OccupancyGrid slow(0.2);
  for (const PosedScan& posed : site.scans) {
    const Pose2 T_map_laser = posed.estimate.T_map_robot * posed.scan.T_robot_laser;
    OccupancyGrid marks(0.2);
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t i = 0; i < posed.scan.ranges.size(); ++i) {
        const double range = static_cast<double>(posed.scan.ranges[i]);
        if (!std::isfinite(range)) continue;
        const double a = posed.scan.angle(i);
        for (double r = pass == 0 ? 0.0 : range; r <= range; r += 2e-4) {
          const Vec2 p = T_map_laser * Vec2(r * std::cos(a), r * std::sin(a));
          marks.set_log_odds(static_cast<int>(std::floor(p.x() / 0.2)),
                             static_cast<int>(std::floor(p.y() / 0.2)), pass == 0 ? -0.4F : 1.1F);
        }
      }
    }
    const CellBox box = marks.bounds();
    for (int y = box.y0; y < box.y0 + box.height; ++y) {
      for (int x = box.x0; x < box.x0 + box.width; ++x) {
        if (marks.known(x, y)) slow.set_log_odds(x, y, slow.log_odds(x, y) + marks.log_odds(x, y));
      }
    }
  }
  // Sampling misses corners that a beam cuts by less than its step: few cells may differ.
  const CellBox box = grid.bounds();
  int differ = 0, known = 0;
  for (int y = box.y0; y < box.y0 + box.height; ++y) {
    for (int x = box.x0; x < box.x0 + box.width; ++x) {
      known += grid.known(x, y);
      EXPECT_TRUE(grid.known(x, y) || !slow.known(x, y)) << x << ' ' << y;
      differ += std::abs(grid.log_odds(x, y) - slow.log_odds(x, y)) > 1e-5F;
    }
  }
  EXPECT_GT(known, 4000);
  EXPECT_LE(differ, known / 500);
}

TEST(BuildOccupancyGrid, IsTheSameForAnyNumberOfThreads) {
  const Site site = wandering_site();
  const OccupancyGrid one = build_occupancy_grid(site, {}, {1});
  for (const int threads : {2, 8}) {
    const OccupancyGrid many = build_occupancy_grid(site, {}, {threads});
    ASSERT_EQ(many.bounds(), one.bounds());
    EXPECT_EQ(many.bytes(), one.bytes());
    const CellBox box = one.bounds();
    std::vector<std::int16_t> a(static_cast<std::size_t>(box.width)), b(a.size());
    for (int y = box.y0; y < box.y0 + box.height; ++y) {
      one.copy_row(box.x0, y, box.width, a.data());
      many.copy_row(box.x0, y, box.width, b.data());
      ASSERT_EQ(a, b) << threads << " threads, row " << y;
    }
  }
}

TEST(BuildOccupancyGrid, TakesMemoryForWhatWasSeenOnly) {
  Site site;
  site.scans = {scan_at({0, 0, 0}, {4.0F}),
                scan_at({1e6, -1e6, 0}, {4.0F})};  // a thousand kilometres apart
  EXPECT_LT(build_occupancy_grid(site, {}).bytes(), 200'000U);
}

}  // namespace
}  // namespace majak::map
