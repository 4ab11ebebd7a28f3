// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/comparison_figure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

namespace majak::draw {
namespace {

using testing::Contains;
using testing::HasSubstr;

eval::MethodResult method(const std::string& name, double error, std::size_t bytes) {
  eval::MethodResult r;
  r.method = name;
  r.estimates.resize(10);
  for (int i = 0; i < 10; ++i)
    r.estimates[static_cast<std::size_t>(i)].T_map_robot = {0.5 * i, 1, 0};
  r.translation = {error, 2 * error};
  r.health[0] = 10;
  r.cpu_mean = 1e-3;
  r.belief_median = r.belief_most = bytes;
  return r;
}

eval::Comparison two() {
  eval::Comparison c;
  c.methods = {method("global", 0.01, 96), method("markov", 0.1, 38'000'000)};
  return c;
}

Figure figure_of(const eval::Comparison& c) {
  return comparison_picture({"a log", c, {}, {{-1, 0}, {6, 2}}});
}

std::vector<std::string> words_of(const Panel& panel) {
  std::vector<std::string> words;
  for (const Mark& mark : panel.marks)
    if (const auto* label = std::get_if<Label>(&mark)) words.push_back(label->text);
  return words;
}

std::vector<Polyline> lines_of(const Panel& panel) {
  std::vector<Polyline> lines;
  for (const Mark& mark : panel.marks)
    if (const auto* line = std::get_if<Polyline>(&mark)) lines.push_back(*line);
  return lines;
}

/// Where the bars in a method's row end.
double end_of_bars(const Panel& panel, int row) {
  double end = 0;
  for (const Polyline& bar : lines_of(panel))
    if (std::abs((bar.points[0].y + bar.points[2].y) / 2 + row) < 0.1)
      for (const Point& p : bar.points) end = std::max(end, p.x);
  return end;
}

TEST(ComparisonFigure, LongerBarsAreLargerValues) {
  const Figure figure = figure_of(two());
  ASSERT_EQ(figure.panels.size(), 6U);
  for (const int panel : {1, 3})
    EXPECT_LT(end_of_bars(figure.panels[static_cast<std::size_t>(panel)], 0),
              end_of_bars(figure.panels[static_cast<std::size_t>(panel)], 1));
  EXPECT_EQ(end_of_bars(figure.panels[2], 0), end_of_bars(figure.panels[2], 1));
  EXPECT_THAT(words_of(figure.panels[1]), Contains("0.01, 0.02"));
  EXPECT_THAT(words_of(figure.panels[3]), Contains("38 MB, 38 MB"));
}

TEST(ComparisonFigure, BarsAndWordsStayOnTheSheet) {
  for (const Panel& panel : figure_of(two()).panels)
    for (const int row : {0, 1})
      EXPECT_TRUE(panel.framed || end_of_bars(panel, row) < 0.8) << panel.title;
}

TEST(ComparisonFigure, WhatWasLostIsNotInThePath) {
  eval::Comparison c = two();
  c.methods.pop_back();
  const auto whole = lines_of(figure_of(c).panels[0]);
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(whole[0].points.back().x, 4.5);
  c.methods[0].estimates[5].health = Health::lost;
  const auto pieces = lines_of(figure_of(c).panels[0]);
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(pieces[0].points.back().x, 2);
  EXPECT_EQ(pieces[1].points.front().x, 3);
  c.methods[0].estimates[9].T_map_robot.x = 9;  // a leap joins nothing
  EXPECT_EQ(lines_of(figure_of(c).panels[0])[1].points.back().x, 4);
}

TEST(ComparisonFigure, SaysInWordsWhatWasKnown) {
  eval::Comparison c = two();
  c.methods[0].found = 3;
  c.methods[0].recovery = eval::Recovery{true, 1, std::nullopt};
  c.methods[1].translation.reset();
  c.methods[1].told = true;
  c.methods[1].recovery = eval::Recovery{};
  const Figure figure = figure_of(c);
  EXPECT_THAT(words_of(figure.panels[4]), Contains("found 3; lost 1, right never"));
  EXPECT_THAT(words_of(figure.panels[4]), Contains("told where; not known before"));
  EXPECT_THAT(words_of(figure.panels[1]), Contains("not known"));
  EXPECT_THAT(figure_svg(figure), HasSubstr("markov"));
}

}  // namespace
}  // namespace majak::draw
