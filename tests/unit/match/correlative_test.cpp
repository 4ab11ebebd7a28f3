// SPDX-License-Identifier: Apache-2.0
#include "majak/match/correlative.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/ascii_room.hpp"

namespace majak::match {
namespace {

using fixture::all_around;
using fixture::AsciiRoom;

/// Walls all around, things at random inside, 'a' in the middle.
AsciiRoom random_room(std::uint64_t seed) {
  RandomStream r(seed);
  const std::size_t wide = 14 + r.below(10), high = 10 + r.below(8);
  std::vector<std::string> plan(high, std::string(wide, '.'));
  for (std::string& row : plan) row.front() = row.back() = '#';
  plan.front() = plan.back() = std::string(wide, '#');
  for (int things = 0; things < 10; ++things)
    plan[1 + r.below(high - 2)][1 + r.below(wide - 2)] = '#';
  for (std::size_t row = high / 2 - 1; row <= high / 2 + 1; ++row)
    plan[row].replace(wide / 2 - 1, 3, "...");
  plan[high / 2][wide / 2] = 'a';
  return AsciiRoom(plan);
}

map::SurfelMap map_of(const AsciiRoom& room, const Pose2& T_map_robot) {
  map::SurfelMap map;
  add_to(map, scan_points(room.scan(T_map_robot, all_around()), {}, true), T_map_robot);
  return map;
}

// The slow twin of the search: every pose of the grid, point by point, with a check of every bound.
// Points and turns are chosen by the header's words.
struct Exhaustive {
  std::vector<Vec2> points;
  double step = 0;  ///< rad
  int turns = 0, reach = 0;

  Exhaustive(const ScanPoints& all, const LikelihoodPyramid& pyramid, const SearchWindow& window,
             std::size_t max_points) {
    std::vector<float> ranges;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const float range = std::sqrt(all.x[i] * all.x[i] + all.y[i] * all.y[i]);
      if (range > static_cast<float>(pyramid.options().radius)) continue;
      points.push_back({all.x[i], all.y[i]});
      ranges.push_back(range);
    }
    std::sort(ranges.begin(), ranges.end());
    const double far = std::max<double>(ranges.at(ranges.size() * 9 / 10), 1.0);
    const std::size_t stride = (points.size() + max_points - 1) / max_points;
    std::vector<Vec2> kept;
    for (std::size_t i = 0; i < points.size(); i += stride) kept.push_back(points[i]);
    points = kept;
    step = 1.5 * pyramid.cell() / far;
    turns = static_cast<int>(std::ceil(window.rotation / step));
    reach = static_cast<int>(std::ceil(window.translation / pyramid.cell()));
  }

  // Sum of the likelihoods at one offset in cells.
  int sum(const LikelihoodPyramid& pyramid, const Pose2& around, int turn, int dx, int dy) const {
    const Pose2 at{around.x, around.y, around.theta + turn * step};
    const int height = [&] {  // rows of a level, from the distance between two levels
      return static_cast<int>((pyramid.level(1) - pyramid.level(0)) / pyramid.width());
    }();
    int total = 0;
    for (const Vec2& point : points) {
      const Vec2 p = at * point;
      const int column = pyramid.column(p.x()) + dx, row = pyramid.row(p.y()) + dy;
      if (column >= 0 && column < pyramid.width() && row >= 0 && row < height)
        total += pyramid.level(0)[row * pyramid.width() + column];
    }
    return total;
  }
  int best(const LikelihoodPyramid& pyramid, const Pose2& around) const {
    int most = 0;
    for (int turn = -turns; turn <= turns; ++turn)
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx)
          most = std::max(most, sum(pyramid, around, turn, dx, dy));
    return most;
  }
  double full() const { return 255.0 * static_cast<double>(points.size()); }
};

TEST(Correlative, EqualsTheExhaustiveSearch) {
  RandomStream r(1);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const AsciiRoom room = random_room(seed);
    const Pose2 truth = room.pose('a', r.uniform(-kPi, kPi));
    const LikelihoodPyramid pyramid(map_of(room, truth * Pose2{0.2, -0.1, 0.1}),
                                    truth.translation(), {.max_translation = 2.0});
    const SearchWindow window{r.uniform(0.1, 1.2), r.uniform(0.02, 0.3)};
    const Pose2 around = truth * Pose2{r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-0.3, 0.3)};
    const int max_points = static_cast<int>(20 + r.below(150));
    const ScanPoints points = scan_points(room.scan(truth, all_around(181)), {}, false);

    const Exhaustive slow(points, pyramid, window, static_cast<std::size_t>(max_points));
    const int most = slow.best(pyramid, around);
    const auto found = search(points, pyramid, around, window, 0, max_points);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->score, most / slow.full(), 1e-12) << "seed " << seed;
    // And the pose it names has that score.
    const double turn = angle_diff(found->T_map_robot.theta, around.theta) / slow.step;
    const double dx = (found->T_map_robot.x - around.x) / pyramid.cell(),
                 dy = (found->T_map_robot.y - around.y) / pyramid.cell();
    for (const double whole : {turn, dx, dy}) EXPECT_NEAR(whole, std::round(whole), 1e-6);
    EXPECT_EQ(slow.sum(pyramid, around, static_cast<int>(std::lround(turn)),
                       static_cast<int>(std::lround(dx)), static_cast<int>(std::lround(dy))),
              most);
    EXPECT_LE(std::abs(std::lround(dx)), slow.reach);
    EXPECT_LE(std::abs(std::lround(dy)), slow.reach);
    EXPECT_LE(std::abs(std::lround(turn)), slow.turns);
  }
}

TEST(Correlative, BoundsSaveMostOfTheWork) {
  const AsciiRoom room = random_room(3);
  const Pose2 truth = room.pose('a');
  const LikelihoodPyramid pyramid(map_of(room, truth), truth.translation(), {});
  const ScanPoints points = scan_points(room.scan(truth, all_around()), {}, false);
  const SearchWindow window{2.0, 0.3};
  const Exhaustive slow(points, pyramid, window, 120);
  const auto found = search(points, pyramid, truth * Pose2{0.6, -0.8, 0.15}, window, 0.5);
  ASSERT_TRUE(found.has_value());
  const double all = std::pow(2.0 * slow.reach + 1, 2) * (2.0 * slow.turns + 1);
  EXPECT_LT(static_cast<double>(found->evaluations), 0.05 * all);
  EXPECT_GT(found->evaluations, 0);
}

TEST(Correlative, FindsTheTruthInAWideWindow) {
  RandomStream r(2);
  for (std::uint64_t seed = 20; seed < 35; ++seed) {
    const AsciiRoom room = random_room(seed);
    const Pose2 truth = room.pose('a', r.uniform(-kPi, kPi));
    const LikelihoodPyramid pyramid(map_of(room, truth), truth.translation(), {});
    const ScanPoints points = scan_points(room.scan(truth, all_around()), {}, false);
    const Pose2 around =
        truth * Pose2{r.uniform(-1.5, 1.5), r.uniform(-1.5, 1.5), r.uniform(-0.4, 0.4)};
    const auto found = search(points, pyramid, around, {2.2, 0.5}, 0.5);
    ASSERT_TRUE(found.has_value()) << seed;
    const Pose2 off = between(truth, found->T_map_robot);
    EXPECT_LT(off.translation().norm(), 0.15) << seed;  // one and a half cells
    EXPECT_LT(std::abs(off.theta), 0.04) << seed;
    EXPECT_GT(found->score, 0.8) << seed;
  }
}

TEST(Correlative, NothingBelowTheLeastScore) {
  const AsciiRoom room = random_room(4);
  const Pose2 truth = room.pose('a');
  const LikelihoodPyramid pyramid(map_of(room, truth), truth.translation(), {});
  const ScanPoints points = scan_points(room.scan(truth, all_around()), {}, false);
  const SearchWindow window{0.5, 0.1};
  const Pose2 around = truth * Pose2{0.3, 0, 0};
  const auto best = search(points, pyramid, around, window, 0);
  ASSERT_TRUE(best.has_value());
  // "At least min_score": the best one's own score lets it pass, a hair more does not.
  const auto again = search(points, pyramid, around, window, best->score);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->score, best->score);
  EXPECT_FALSE(search(points, pyramid, around, window, best->score + 1e-6).has_value());
  EXPECT_FALSE(search(points, pyramid, around, window, 1.1).has_value());
}

TEST(Correlative, NothingFromNothing) {
  const AsciiRoom room = random_room(5);
  const Pose2 truth = room.pose('a');
  const LikelihoodPyramid pyramid(map_of(room, truth), truth.translation(), {});
  const LikelihoodPyramid empty(map::SurfelMap{}, {0, 0}, {});
  const ScanPoints points = scan_points(room.scan(truth, all_around()), {}, false);
  EXPECT_FALSE(search({}, pyramid, truth, {}, 0.1).has_value());
  EXPECT_FALSE(search(points, empty, {}, {}, 0.1).has_value());
  EXPECT_FALSE(search(points, pyramid, {1e4, -1e4, 0}, {}, 0.1).has_value());  // far from all walls
}

TEST(Correlative, TheWidestWindowStaysInsideTheGrid) {
  // The robot is guessed at the far ends of the widest window that the pyramid was made for: points
  // lie in the margin, or beyond. The score must be that of the twin, which checks every bound.
  const AsciiRoom room({
      "##########",
      "#........#",
      "#...a....#",
      "#........#",
      "##########",
  });
  const Pose2 truth = room.pose('a');
  const LikelihoodPyramid pyramid(map_of(room, truth), truth.translation(),
                                  {.max_translation = 1.2});
  const ScanPoints points = scan_points(room.scan(truth, all_around(90)), {}, false);
  for (const Vec2& off : {Vec2(1.2, 1.2), Vec2(-1.2, -1.2), Vec2(4.5, 0), Vec2(-4.5, 0),
                          Vec2(0, 3.5), Vec2(0, -3.5), Vec2(-6, -4)}) {
    const Pose2 around{truth.x + off.x(), truth.y + off.y(), 0};
    const SearchWindow window{1.2, 0.05};
    const Exhaustive slow(points, pyramid, window, 120);
    const auto found = search(points, pyramid, around, window, 0);
    EXPECT_NEAR(found ? found->score : 0, slow.best(pyramid, around) / slow.full(), 1e-12)
        << off.transpose();
  }
}

TEST(Correlative, LikelihoodIsTheScoreOfOnePose) {
  const AsciiRoom room = random_room(8);
  const Pose2 truth = room.pose('a', 0.5);
  const LikelihoodPyramid pyramid(map_of(room, truth), truth.translation(), {});
  const ScanPoints points = scan_points(room.scan(truth, all_around(500)), {}, false);
  RandomStream r(3);
  for (int i = 0; i < 50; ++i) {
    const Pose2 at = truth * Pose2{r.uniform(-2, 2), r.uniform(-2, 2), r.uniform(-kPi, kPi)};
    const auto found = search(points, pyramid, at, {0, 0}, 0);  // a window of one pose
    EXPECT_DOUBLE_EQ(likelihood(points, pyramid, at), found ? found->score : 0);
  }
  EXPECT_GT(likelihood(points, pyramid, truth), 0.8);
  EXPECT_EQ(likelihood(points, pyramid, {1e4, 0, 0}), 0);
  EXPECT_EQ(likelihood({}, pyramid, truth), 0);
}

TEST(Correlative, AHeadingAcrossTheSeamIsOneLikeAnother) {
  const AsciiRoom room = random_room(6);
  const Pose2 truth = room.pose('a', kPi);
  const LikelihoodPyramid pyramid(map_of(room, truth), truth.translation(), {});
  const ScanPoints points = scan_points(room.scan(truth, all_around()), {}, false);
  for (const double turn : {-0.1, 0.1}) {
    const auto found = search(points, pyramid, truth * Pose2{0, 0, turn}, {0.3, 0.2}, 0.3);
    ASSERT_TRUE(found.has_value());
    EXPECT_LT(std::abs(angle_diff(found->T_map_robot.theta, truth.theta)), 0.04);
    EXPECT_LE(found->T_map_robot.theta, kPi);
    EXPECT_GT(found->T_map_robot.theta, -kPi);
  }
}

// The pyramid.

TEST(LikelihoodPyramid, LevelsAreMaximaOverSquares) {
  const AsciiRoom room = random_room(7);
  const LikelihoodPyramid pyramid(map_of(room, room.pose('a')), room.place('a'),
                                  {.max_translation = 1.0});
  const int width = pyramid.width();
  const int height = static_cast<int>((pyramid.level(1) - pyramid.level(0)) / width);
  for (int l = 1; l < LikelihoodPyramid::kLevels; ++l) {
    const int side = 1 << l;
    int differences = 0;
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        int most = 0;
        for (int y = row; y < std::min(row + side, height); ++y)
          for (int x = column; x < std::min(column + side, width); ++x)
            most = std::max<int>(most, pyramid.level(0)[y * width + x]);
        differences += pyramid.level(l)[row * width + column] != most;
      }
    EXPECT_EQ(differences, 0) << "level " << l;
  }
}

TEST(LikelihoodPyramid, LikelihoodFallsWithTheDistanceToASurface) {
  map::SurfelMap map;
  map.add(-1, -1, 0, 1);  // the cells' edges lie on the lowest surface: the next is mid-cell
  map.add(0.05F, 0.05F, 0, 1);
  const LikelihoodPyramid pyramid(map, {0, 0}, {.cell = 0.10, .sigma = 0.08, .max_translation = 1});
  const auto at = [&](double x, double y) {
    return int{pyramid.level(0)[pyramid.row(y) * pyramid.width() + pyramid.column(x)]};
  };
  EXPECT_EQ(at(0.05, 0.05), 255);
  EXPECT_LT(at(0.15, 0.05), 255);
  EXPECT_LT(at(0.15, 0.15), at(0.15, 0.05));
  EXPECT_LT(at(0.25, 0.05), at(0.15, 0.05));
  EXPECT_GT(at(0.15, 0.15), 0);
  EXPECT_EQ(at(0.15, 0.05), at(-0.05, 0.05));
  EXPECT_EQ(at(0.15, 0.05), at(0.05, -0.05));
  EXPECT_EQ(at(0.55, 0.05), 0);
}

TEST(LikelihoodPyramid, SurfacesBeyondItsRadiusAreLeftOut) {
  map::SurfelMap map;
  map.add(0, 0, 0, 1);
  map.add(20, 0, 0, 1);
  const LikelihoodPyramid near(map, {0, 0}, {.radius = 10, .max_translation = 1});
  const LikelihoodPyramid all(map, {0, 0}, {.radius = 25, .max_translation = 1});
  EXPECT_NEAR(all.width() - near.width(), 200, 1);
}

}  // namespace
}  // namespace majak::match
