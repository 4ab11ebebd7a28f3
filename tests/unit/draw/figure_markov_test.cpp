// SPDX-License-Identifier: Apache-2.0
// Figure 10 against numbers worked out by hand: 60 cells, 15 of them doors; a door is seen with
// 0.8 where one is and with 0.1 elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

std::vector<double> belief(std::size_t panel) {
  std::vector<double> p;
  const Panel shown = figure_markov({}).panels.at(panel);
  for (const Mark& mark : shown.marks)
    if (const auto* line = std::get_if<Polyline>(&mark); line && line->points.size() > 100)
      for (std::size_t i = 1; i + 1 < line->points.size(); i += 2) p.push_back(line->points[i].y);
  return p;
}

double entropy(const std::vector<double>& p) {
  double sum = 0;
  for (const double q : p) sum -= q * std::log(q);
  return sum;
}

// 15 * 0.8 + 45 * 0.1 = 16.5.
constexpr double kAtDoor = 0.8 / 16.5, kAtWall = 0.1 / 16.5;
// exp(-4) I_n(4), Abramowitz and Stegun, table 9.8, and on by I_(n+1) = I_(n-1) - n / 2 I_n.
constexpr double kBlur[] = {0.20700192, 0.17875084, 0.11762650, 0.06112434, 0.02593999, 0.00924436};

TEST(FigureMarkov, HasItsFivePanels) { EXPECT_EQ(figure_markov({}).panels.size(), 5U); }

TEST(FigureMarkov, FirstEveryPlaceIsAsLikely) {
  for (const double p : belief(0)) EXPECT_DOUBLE_EQ(p, 1 / 60.0);
}

TEST(FigureMarkov, ADoorWeighsByBayes) {
  const auto p = belief(1);
  ASSERT_EQ(p.size(), 60U);
  for (const int cell : {8, 12, 18, 22, 42, 46}) EXPECT_NEAR(p[cell], kAtDoor, 1e-15);
  for (const int cell : {0, 7, 13, 17, 23, 41, 47, 59}) EXPECT_NEAR(p[cell], kAtWall, 1e-15);
}

TEST(FigureMarkov, MotionShiftsByTenCellsAndBlurs) {
  const auto p = belief(2);
  // The middle of the third door's image takes from its five cells and from the wall around.
  const double middle = kBlur[0] + 2 * (kBlur[1] + kBlur[2]);
  EXPECT_NEAR(p[54], kAtWall + (kAtDoor - kAtWall) * middle, 2e-7);
  // Its first cell: from the door at its place and four further on.
  const double edge = kBlur[0] + kBlur[1] + kBlur[2] + kBlur[3] + kBlur[4];
  EXPECT_NEAR(p[52], kAtWall + (kAtDoor - kAtWall) * edge, 2e-7);
  // Two cells outside: what is blurred so far.
  const double outside = kBlur[2] + kBlur[3] + kBlur[4] + kBlur[5] + 0.00282891;
  EXPECT_NEAR(p[50], kAtWall + (kAtDoor - kAtWall) * outside, 2e-7);
}

TEST(FigureMarkov, TheSecondDoorLeavesOnePlace) {
  const auto moved = belief(2), p = belief(3);
  double evidence = 0;
  for (int i = 0; i < 60; ++i) {
    const bool door = (i >= 8 && i < 13) || (i >= 18 && i < 23) || (i >= 42 && i < 47);
    evidence += (door ? 0.8 : 0.1) * moved[i];
  }
  EXPECT_NEAR(p[20], 0.8 * moved[20] / evidence, 1e-15);
  EXPECT_NEAR(p[54], 0.1 * moved[54] / evidence, 1e-15);
  // Where it saw a door but none would have been: an eighth.
  EXPECT_NEAR(p[20] / p[30], 8, 0.01);
  for (int i = 0; i < 60; ++i) EXPECT_LE(p[i], p[20]);
}

TEST(FigureMarkov, EntropyFallsAtSightingsAndGrowsAtMotion) {
  double h[5];
  for (std::size_t i = 0; i < 5; ++i) h[i] = entropy(belief(i));
  EXPECT_NEAR(h[0], std::log(60), 1e-12);
  EXPECT_LT(h[1], h[0]);
  EXPECT_GT(h[2], h[1]);
  EXPECT_LT(h[3], h[2]);
  EXPECT_GT(h[4], h[3]);
}

}  // namespace
}  // namespace majak::draw
