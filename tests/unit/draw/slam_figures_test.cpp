// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/slam_figures.hpp"

#include <gtest/gtest.h>

namespace majak::draw {
namespace {

TEST(NeesPicture, ShowsBothMethodsAndTheBand) {
  const NeesPicture picture{"Runs", {10, 20, 30}, {2, 3, 9}, {3, 2.5, 3.5},
                            2.5,    3.5,          {1, 2, 1}, {0.5, 0.6, 0.7}};
  const Figure figure = nees_picture(picture);
  ASSERT_EQ(figure.panels.size(), 2U);
  const auto& band = std::get<Polyline>(figure.panels[0].marks.at(0));
  EXPECT_EQ(band.points.at(0).y, 2.5);
  EXPECT_EQ(band.points.at(2).y, 3.5);
  EXPECT_EQ(band.points.at(2).x, 30);
  const auto& ekf = std::get<Polyline>(figure.panels[0].marks.at(2));
  ASSERT_EQ(ekf.points.size(), 3U);
  EXPECT_EQ(ekf.points[2].x, 30);
  EXPECT_EQ(ekf.points[2].y, 9);
  EXPECT_EQ(std::get<Polyline>(figure.panels[1].marks.at(1)).points[1].y, 0.6);
  const std::string svg = figure_svg(figure);
  EXPECT_NE(svg.find("graph"), std::string::npos);
  EXPECT_NE(svg.find("place, rms (m)"), std::string::npos);
}

TEST(NeesPicture, OfNothingIsEmptyAndNoCrash) {
  EXPECT_EQ(nees_picture({}).panels.size(), 2U);
  EXPECT_FALSE(figure_svg(nees_picture({})).empty());
  EXPECT_FALSE(figure_svg(step_time_picture({})).empty());
}

TEST(StepTimePicture, HasAPanelForEachRun) {
  const Figure figure = step_time_picture(
      {{"park", {{10, 0.5}, {20, 0.5}}, {{10, 0.6}, {20, 0.7}}}, {"other", {{1, 2}}, {{1, 3}}}});
  ASSERT_EQ(figure.panels.size(), 2U);
  EXPECT_EQ(figure.panels[0].title, "park");
  EXPECT_EQ(std::get<Polyline>(figure.panels[0].marks.at(0)).points[1].y, 0.7);
  EXPECT_EQ(std::get<Polyline>(figure.panels[1].marks.at(1)).points[0].y, 2);
  EXPECT_GE(figure.panels[1].place.left, figure.panels[0].place.left + 400);
}

}  // namespace
}  // namespace majak::draw
