// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <variant>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

/// Four beams a degree apart; the third sees nothing.
std::vector<Event> log_of_four() {
  Scan scan;
  scan.angle_step = kPi / 180;
  scan.ranges = {3, 6, kNoReturn, 1.5F};
  return {scan};
}

std::vector<Point> dots(const Panel& panel) {
  for (const Mark& mark : panel.marks)
    if (const auto* d = std::get_if<Dots>(&mark)) return d->at;
  return {};
}

TEST(FigureMirror, TheContourGrowsFromPanelToPanel) {
  const Figure figure = figure_mirror({});
  ASSERT_EQ(figure.panels.size(), 5U);
  for (std::size_t k = 1; k < 4; ++k) {
    const auto before = dots(figure.panels[k - 1]), after = dots(figure.panels[k]);
    ASSERT_LT(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(before[i].x, after[i].x);
  }
  EXPECT_EQ(dots(figure.panels[3]).size(), dots(figure.panels[4]).size());
}

TEST(FigureMirror, APulseIsAwayForTwiceItsWay) {
  const auto pulses = dots(figure_mirror(log_of_four()).panels[4]);
  ASSERT_EQ(pulses.size(), 3U);
  const double metres[] = {3, 6, 1.5};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(pulses[i].y, 2 * metres[i] / 0.299792458, 1e-9);
}

TEST(FigureMirror, ADegreeTakesA360thOfATurn) {
  const auto pulses = dots(figure_mirror(log_of_four()).panels[4]);
  const double beam[] = {0, 1, 3};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(pulses[i].x, beam[i] * 1e3 / 75 / 360, 1e-9);
}

TEST(FigureMirror, ALogThatSeesNothingIsAnExample) {
  Scan blind;
  blind.ranges.assign(10, kNoReturn);
  EXPECT_GT(dots(figure_mirror({Event{blind}}).panels[4]).size(), 100U);
}

}  // namespace
}  // namespace majak::draw
