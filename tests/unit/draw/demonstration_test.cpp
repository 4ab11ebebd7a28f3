// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "majak/draw/demonstration_figures.hpp"
#include "majak/draw/demonstration_report.hpp"
#include "tests/support/park_drive.hpp"
#include "tests/support/well_formed.hpp"

namespace majak::draw {
namespace {

using testing::HasSubstr;
using testing::Not;

const eval::Demonstration& with_truth() {
  static const eval::Demonstration d = [] {
    const std::vector<Event> events = test::park_drive();
    eval::DemonstrationOptions input;
    input.ekf.wheelbase = test::kParkWheelbase;
    input.cut_off = 15;
    input.trunks = test::park_trunks();
    return eval::demonstrate(events, input);
  }();
  return d;
}

const eval::Demonstration& on_fixes() {
  static const eval::Demonstration d = [] {
    std::vector<Event> events = test::park_drive();
    std::erase_if(events, [](const Event& e) { return std::holds_alternative<Truth>(e); });
    eval::DemonstrationOptions input;
    input.ekf.wheelbase = test::kParkWheelbase;
    input.cut_off = 15;
    return eval::demonstrate(events, input);
  }();
  return d;
}

TEST(DemonstrationFigures, EveryPanelIsOnItsSheet) {
  for (const auto* d : {&with_truth(), &on_fixes()})
    for (const Figure& figure :
         {demonstration_picture(*d), errors_over_time(*d), errors_over_range(*d),
          consistency_over_time(*d), time_over_size(*d)}) {
      EXPECT_FALSE(figure.panels.empty());
      for (const Panel& p : figure.panels) {
        EXPECT_FALSE(p.marks.empty()) << p.title;
        EXPECT_GE(p.place.left, 0);
        EXPECT_LE(p.place.left + p.place.width, figure.width + 1e-9);
        EXPECT_LE(p.place.top + p.place.height, figure.height + 1e-9);
      }
    }
}

TEST(DemonstrationFigures, TheMapShowsThePathAndTheTrunks) {
  const Panel map = demonstration_picture(with_truth()).panels.front();
  const auto& run = with_truth().with_all();
  const auto standing =
      std::count_if(run.graph.map.landmarks.begin(), run.graph.map.landmarks.end(),
                    [](const slam::MappedLandmark& l) { return !l.gone; });
  EXPECT_EQ(std::count_if(map.marks.begin(), map.marks.end(),
                          [](const Mark& m) { return std::holds_alternative<Ellipse>(m); }),
            standing);
  for (const Estimate& e : run.graph.map.localization.estimates) {
    EXPECT_GT(e.T_map_robot.x, *map.x.low);
    EXPECT_LT(e.T_map_robot.x, *map.x.high);
    EXPECT_GT(e.T_map_robot.y, *map.y.low);
    EXPECT_LT(e.T_map_robot.y, *map.y.high);
  }
}

TEST(DemonstrationFigures, OnFixesTheLinesOfErrorsBreakBetweenBursts) {
  const Figure figure = errors_over_time(on_fixes());
  ASSERT_EQ(figure.panels.size(), 3U);
  std::size_t lines = 0;
  for (const Mark& m : figure.panels[1].marks) lines += std::holds_alternative<Polyline>(m);
  std::size_t inner = 0;  // bursts that a fold holds out, once for EKF and once for the graph
  inner = 2 * (on_fixes().fixes.bursts - 2);
  EXPECT_GE(lines, inner / 2);
  EXPECT_LE(lines, 2 * inner);
}

TEST(DemonstrationReport, IsOneWellFormedPageThatNeedsNothingElse) {
  for (const auto* d : {&with_truth(), &on_fixes()}) {
    const std::string html = demonstration_html(*d, {"park <1>", "0.1"});
    test::expect_well_formed(html);
    EXPECT_THAT(html, HasSubstr("park &lt;1&gt;"));
    EXPECT_THAT(html, Not(HasSubstr("http-equiv")));
    EXPECT_THAT(html, Not(HasSubstr("src=\"http")));
    for (const char* heading : {"Measured against what", "Path and obstacles", "The robot's place",
                                "The obstacles", "Are the covariances honest?", "What happened"})
      EXPECT_THAT(html, HasSubstr(heading));
    EXPECT_EQ(html, demonstration_html(*d, {"park <1>", "0.1"}));
  }
}

TEST(DemonstrationReport, SaysWhatItIsMeasuredAgainst) {
  const std::string known = demonstration_html(with_truth(), {"log", ""});
  EXPECT_THAT(known, HasSubstr("against the true pose"));
  EXPECT_THAT(known, HasSubstr("true trunks"));
  const std::string blind = demonstration_html(on_fixes(), {"log", ""});
  EXPECT_THAT(blind, HasSubstr("held out by turns in two folds"));
  EXPECT_THAT(blind, HasSubstr("How good these fixes are"));
  EXPECT_THAT(blind, HasSubstr("nobody has surveyed them"));
  EXPECT_THAT(blind, Not(HasSubstr("true trunks")));
}

}  // namespace
}  // namespace majak::draw
