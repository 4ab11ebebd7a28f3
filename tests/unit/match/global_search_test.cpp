// SPDX-License-Identifier: Apache-2.0
#include "majak/match/global_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/ascii_map.hpp"
#include "tests/support/ascii_room.hpp"

namespace majak::match {
namespace {

const std::vector<std::string> kPlan = {"####################",  //
                                        "#..........#.......#",  //
                                        "#..........#.......#",  //
                                        "#...a..............#",  //
                                        "#......##..........#",  //
                                        "#......##....#######",  //
                                        "#............#     #",  //
                                        "##############     #"};

/// The plan's cells of 0.5 m in cells of 0.1 m.
map::KnownMap fine(const std::vector<std::string>& plan) {
  return fixture::ascii_map(fixture::finer(plan, 5), 0.1);
}

Beams seen_from(const fixture::AsciiRoom& room, const Pose2& pose, int most = 0) {
  return beams(room.scan(pose, {181, kPi, 30, 0, 1, {}}), {.most = most});
}

TEST(GlobalSearch, FindsTheRobot) {
  const fixture::AsciiRoom room(kPlan);
  const map::KnownMap map = fine(kPlan);
  const GlobalSearch search(map, map::DistanceField(map));
  for (const double heading : {0.0, 1.0, 2.5, -2.0, -0.4}) {
    const Pose2 truth = room.pose('a', heading);
    const auto result = search.find(seen_from(room, truth));
    ASSERT_FALSE(result.places.empty());
    EXPECT_TRUE(result.complete);
    // Two walls of a corner are seen from many a corner.
    EXPECT_TRUE(std::any_of(result.places.begin(), result.places.end(), [&](const auto& place) {
      const Pose2 off = between(truth, place.T_map_robot);
      return off.translation().norm() < 0.15 && std::abs(off.theta) < 0.06 &&
             place.fit > result.places.front().fit - 0.05;
    }));
  }
}

// The slow twin looks at every cell in every heading.
TEST(GlobalSearch, TheBestOfAllIsFound) {
  const fixture::AsciiRoom room(kPlan);
  const map::KnownMap map = fine(kPlan);
  const map::DistanceField distances(map);
  GlobalSearchOptions o;
  o.returns = 20;
  const GlobalSearch search(map, distances, o);
  for (const Pose2& truth : {room.pose('a', 0.7), Pose2{8, 2.9, -2.2}}) {
    const Beams b = seen_from(room, truth, 20);
    const auto result = search.find(b);
    ASSERT_FALSE(result.places.empty());
    std::vector<double> far;
    for (std::size_t i = 0; i < b.returns; ++i) far.push_back(std::hypot(b.x[i], b.y[i]));
    std::sort(far.begin(), far.end());
    const double step = 1.5 * o.cell / std::max(1.0, far[b.returns * 9 / 10]);
    const int headings = static_cast<int>(std::ceil(2 * kPi / step));
    double best = 0;
    for (int h = 0; h < headings; ++h) {
      const double theta = 2 * kPi * h / headings, c = std::cos(theta), s = std::sin(theta);
      for (int iy = 0; iy < map.height; ++iy)
        for (int ix = 0; ix < map.width; ++ix) {
          if (map.at(ix, iy) != map::CellState::free) continue;
          double sum = 0;
          for (std::size_t i = 0; i < b.returns; ++i) {
            const int px = static_cast<int>(std::floor((c * b.x[i] - s * b.y[i]) / o.cell + 0.5)),
                      py = static_cast<int>(std::floor((s * b.x[i] + c * b.y[i]) / o.cell + 0.5));
            const double d = distances.at(ix + px, iy + py) / o.sigma;
            sum += std::log(std::exp(-d * d / 2) * (1 - o.random) + o.random);
          }
          best = std::max(best, std::exp(sum / static_cast<double>(b.returns)));
        }
    }
    EXPECT_NEAR(result.places.front().fit, best, 0.02);  // a byte a cost
  }
}

TEST(GlobalSearch, PlacesThatLookAlikeAreAllTold) {
  const std::vector<std::string> square = {"###########",  //
                                           "#.........#",  //
                                           "#.........#",  //
                                           "#..a......#",  //
                                           "#.........#",  //
                                           "#.........#",  //
                                           "#.........#",  //
                                           "#.........#",  //
                                           "#.........#",  //
                                           "#.........#",  //
                                           "###########"};
  const fixture::AsciiRoom room(square);
  const map::KnownMap map = fine(square);
  const GlobalSearch search(map, map::DistanceField(map));
  const auto result =
      search.find(beams(room.scan(room.pose('a', 0.3), fixture::all_around()), {.most = 0}));
  const Vec2 middle(2.75, 2.75);
  int turned[4] = {};
  for (const FittingPlace& p : result.places)
    for (int k = 0; k < 4; ++k) {
      const Pose2 turn{0, 0, k * kPi / 2};
      const Vec2 at = turn * Vec2(room.place('a') - middle) + middle;
      turned[k] += (p.T_map_robot.translation() - at).norm() < 0.25 &&
                   std::abs(angle_diff(p.T_map_robot.theta, 0.3 + k * kPi / 2)) < 0.1 &&
                   p.fit > result.places.front().fit - 0.08;
    }
  for (const int n : turned) EXPECT_GE(n, 1);
}

TEST(GlobalSearch, PlacesComeInOrderAndApart) {
  const fixture::AsciiRoom room(kPlan);
  const map::KnownMap map = fine(kPlan);
  const GlobalSearchOptions o;
  const auto result =
      GlobalSearch(map, map::DistanceField(map), o).find(seen_from(room, room.pose('a')));
  for (std::size_t i = 0; i < result.places.size(); ++i) {
    if (i > 0) {
      EXPECT_GE(result.places[i - 1].fit, result.places[i].fit);
    }
    EXPECT_EQ(map.at(result.places[i].T_map_robot.translation()), map::CellState::free);
    for (std::size_t k = 0; k < i; ++k) {
      const Pose2 off = between(result.places[k].T_map_robot, result.places[i].T_map_robot);
      EXPECT_TRUE(off.translation().norm() >= o.apart || std::abs(off.theta) >= o.apart_turn);
    }
  }
}

TEST(GlobalSearch, WithoutReturnsThereIsNoPlace) {
  const map::KnownMap map = fine(kPlan);
  const GlobalSearch search(map, map::DistanceField(map));
  EXPECT_TRUE(search.find({}).places.empty());
}

}  // namespace
}  // namespace majak::match
