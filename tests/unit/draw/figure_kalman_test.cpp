// SPDX-License-Identifier: Apache-2.0
// Figure 8 shows what its caption says.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

bool same(const Colour& a, const Colour& b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

std::vector<Point> line(const Panel& panel, const Colour& colour) {
  for (const Mark& mark : panel.marks)
    if (const auto* p = std::get_if<Polyline>(&mark); p && same(p->pen.colour, colour))
      return p->points;
  return {};
}

double rms(const std::vector<Point>& a, const std::vector<Point>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += std::pow(a[i].x - b.at(i).x, 2) + std::pow(a[i].y - b.at(i).y, 2);
  return std::sqrt(sum / double(a.size()));
}

TEST(FigureKalman, TheGreenEstimateKeepsToTheRedTruth) {
  const Panel plane = figure_kalman({}).panels.at(0);
  const auto truth = line(plane, ink::red), estimate = line(plane, ink::green);
  ASSERT_EQ(truth.size(), 97U);
  EXPECT_LT(rms(estimate, truth), 0.25);  // better than the fixes it is made of
  EXPECT_GT(rms(line(plane, ink::grey), truth), 1);
}

TEST(FigureKalman, EveryFourthStepHasAFixAndItShrinksTheEllipse) {
  const Panel plane = figure_kalman({}).panels.at(0);
  std::size_t fixes = 0;
  std::vector<double> areas;
  for (const Mark& mark : plane.marks) {
    if (const auto* dots = std::get_if<Dots>(&mark)) fixes += dots->at.size();
    if (const auto* e = std::get_if<Ellipse>(&mark)) areas.push_back(e->rx * e->ry);
  }
  EXPECT_EQ(fixes, 24U);
  ASSERT_EQ(areas.size(), 12U);  // before and after a fix, by turns
  for (std::size_t i = 0; i < areas.size(); i += 2) EXPECT_LT(areas[i + 1], areas[i]);
}

TEST(FigureKalman, TheGainSettlesAtATenth) {
  const auto gain = line(figure_kalman({}).panels.at(2), ink::blue);
  ASSERT_EQ(gain.size(), 80U);
  EXPECT_GT(gain.front().y, 0.6);
  EXPECT_NEAR(gain.back().y, 0.1, 1e-6);
  for (std::size_t i = 1; i < gain.size(); ++i) EXPECT_LE(gain[i].y, gain[i - 1].y);
}

}  // namespace
}  // namespace majak::draw
