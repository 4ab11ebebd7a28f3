// SPDX-License-Identifier: Apache-2.0
// The thesis's example (p. 24): the robot senses the colour of the floor.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/filter/histogram.hpp"
#include "majak/localize/monte_carlo.hpp"
#include "majak/match/cell_attributes.hpp"
#include "tests/unit/localize/hall.hpp"

namespace majak::localize {
namespace {

constexpr int kWhite = 0, kRed = 1;
/// White is told right nine times of ten, red eight times.
const match::ClassSense kColour{2, {0.9, 0.1, 0.2, 0.8}};

std::vector<double> likelihoods(const match::CellAttributes& floor, int told) {
  std::vector<double> p;
  for (const float there : floor.values) p.push_back(kColour(told, there));
  return p;
}

TEST(FloorColour, BayesByHandInACorridor) {
  const match::CellAttributes floor{1, 0, 0, 5, 1, {kWhite, kWhite, kRed, kWhite, kRed}};
  auto belief = filter::Histogram::uniform(5, false);
  EXPECT_NEAR(belief.see(likelihoods(floor, kRed)), 1.9 / 5, 1e-15);
  const double first[] = {0.1, 0.1, 0.8, 0.1, 0.8};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(belief.p[i], first[i] / 1.9, 1e-15) << i;
  belief.move(1, 0);  // what stood in the last cell meets the wall
  belief.see(likelihoods(floor, kWhite));
  const double then[] = {0, 0.09, 0.02, 0.72, 0.18};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(belief.p[i], then[i] / 1.01, 1e-15) << i;
}

class Particles : public testing::Test {
 protected:
  /// Spread about a place in the hall, by one scan.
  Particles() : filter(hall(), {.start_sigma = 0.5}, {6, 2, 0}) {
    filter.add({fixture::seen_from({6, 2, 0}), {}, Mat3::Zero(), false});
  }
  static const PlacePtr& hall() { return fixture::hall(); }
  double left() const {
    double sum = 0;
    for (std::size_t i = 0; i < filter.weights().size(); ++i)
      sum += filter.poses().x[i] < kBorder ? filter.weights()[i] : 0;
    return sum;
  }

  /// Red to the left of the border, white to the right.
  static constexpr double kBorder = 6;
  const match::CellAttributes floor{kBorder, 0, 0, 2, 1, {kRed, kWhite}};
  MonteCarlo filter;
};

TEST_F(Particles, WeighBayesByHand) {
  const double before = left();
  ASSERT_GT(before, 0.05);
  ASSERT_LT(before, 0.95);
  const double evidence =
      filter.see([&](const Pose2& l) { return kColour(kRed, floor.at(l.translation())); });
  EXPECT_NEAR(evidence, 0.8 * before + 0.1 * (1 - before), 1e-12);
  EXPECT_NEAR(left(), 0.8 * before / evidence, 1e-12);
}

TEST_F(Particles, TwoSightingsAreTheirProduct) {
  const double before = left();
  for (const int told : {kRed, kWhite})
    filter.see([&](const Pose2& l) { return kColour(told, floor.at(l.translation())); });
  const double red = before * 0.8 * 0.2, white = (1 - before) * 0.1 * 0.9;
  EXPECT_NEAR(left(), red / (red + white), 1e-12);
}

TEST_F(Particles, WhatCannotBeChangesNothing) {
  const auto weights = filter.weights();
  EXPECT_EQ(filter.see([](const Pose2&) { return 0.0; }), 0);
  EXPECT_EQ(filter.weights(), weights);
  EXPECT_NEAR(filter.see([](const Pose2&) { return 1.0; }), 1, 1e-12);
  EXPECT_EQ(filter.weights(), weights);
}

TEST_F(Particles, TheSightingIsKeptByTheNextScan) {
  const double before = left();
  filter.see([&](const Pose2& l) { return l.x < kBorder ? 0.0 : 1.0; });
  EXPECT_EQ(left(), 0);
  filter.add({fixture::seen_from({6, 2, 0}), {}, Mat3::Zero(), false});
  EXPECT_LT(left(), before / 2) << "by the blur of a motion alone some come back";
  EXPECT_GT(filter.clusters().front().T_map_robot.x, kBorder - 0.05);
}

}  // namespace
}  // namespace majak::localize
