// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/chart.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace majak::draw {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Ticks, AreRoundAndReachTheMaximum) {
  EXPECT_EQ(ticks(10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(ticks(1, 2), (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(ticks(22.7, 4), (std::vector<double>{0, 10, 20, 30}));
  for (const double max : {1e-9, 0.037, 1.0, 99.0, 12345.0}) {
    const std::vector<double> t = ticks(max, 3);
    EXPECT_GE(t.back(), max * (1 - 1e-6));
    EXPECT_LT(t[t.size() - 2], max);
    EXPECT_LE(t.size(), 8U);
  }
}

TEST(Ticks, OfNothingGoToOne) {
  for (const double max : {0.0, -3.0, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(ticks(max, 1).back(), 1.0);
  }
}

/// The y of a mean line's points, in the chart's pixels.
std::string mean_of(const std::string& svg) {
  const std::size_t begin = svg.find("class=\"mean\" d=\"") + 16;
  return svg.substr(begin, svg.find('"', begin) - begin);
}

TEST(Chart, PutsZeroAtTheBottomAndTheMaximumAtTheTop) {
  const std::string svg = chart_svg({"sigma", "cm", {{0, 0}, {10, 4}}, {}, 4});
  EXPECT_EQ(mean_of(svg), "M54 126L888 24") << svg;
}

TEST(Chart, HasItsTitleAndUnitEscaped) {
  EXPECT_THAT(chart_svg({"a < b", "cm", {{0, 1}}, {}, 0}), HasSubstr("a &lt; b, cm"));
}

TEST(Chart, StaysSmallForManyPoints) {
  Chart chart{"x", "", {}, {}, 0};
  for (int i = 0; i < 100'000; ++i)
    chart.points.push_back({i * 1e-3, std::abs(std::sin(i * 0.01))});
  EXPECT_LT(chart_svg(chart).size(), 30'000U);
}

TEST(Chart, DoesNotDependOnTheOrderOfItsPoints) {
  Chart forward{"x", "", {}, {}, 0}, backward = forward;
  for (int i = 0; i < 1000; ++i) forward.points.push_back({i * 0.5, static_cast<double>(i % 16)});
  backward.points.assign(forward.points.rbegin(), forward.points.rend());
  EXPECT_EQ(chart_svg(forward), chart_svg(backward));
}

TEST(Chart, BreaksTheLineAtAGap) {
  Chart chart{"x", "", {}, {}, 0};
  for (int i = 0; i < 1000; ++i) chart.points.push_back({i + (i < 500 ? 0.0 : 1000.0), 1});
  const std::string mean = mean_of(chart_svg(chart));
  EXPECT_EQ(std::count(mean.begin(), mean.end(), 'M'), 2);
}

TEST(Chart, ManagesWithNothingAndWithNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               inf = std::numeric_limits<double>::infinity();
  for (const std::vector<Point>& points :
       {std::vector<Point>{}, {{nan, 1}, {1, nan}, {inf, inf}}, {{5, 0}}}) {
    const std::string svg = chart_svg({"x", "", points, {{1, 2, "lost"}}, 0});
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
    EXPECT_THAT(svg, HasSubstr("</svg>"));
  }
}

TEST(Chart, ShowsBands) {
  const std::string svg =
      chart_svg({"x", "", {{0, 1}, {10, 1}}, {{2, 4, "weak"}, {7, 7, "lost"}}, 1});
  EXPECT_THAT(
      svg, HasSubstr("<rect class=\"weak\" x=\"220.8\" y=\"24\" width=\"166.8\" height=\"102\"/>"));
  EXPECT_THAT(svg, HasSubstr("<rect class=\"lost\" x=\"637.8\" y=\"24\" width=\"1.5\""));
}

}  // namespace
}  // namespace majak::draw
