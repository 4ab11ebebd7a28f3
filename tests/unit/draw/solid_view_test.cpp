// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/solid_view.hpp"

#include <gtest/gtest.h>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

map::Solid rectangle(const Vec3& corner, const Vec3& u, const Vec3& v, map::Rgb colour = {}) {
  map::Solid solid{{map::SolidPart{.name = "one"}}};
  map::add_rectangle(solid.parts[0], corner, u, v, colour);
  return solid;
}

TEST(SolidView, WhatItLooksAtIsInTheMiddleAndNearerIsLarger) {
  const Camera camera({0, -10, 0}, {0, 0, 0});
  EXPECT_NEAR(camera.see({0, 0, 0}).x, 0, 1e-12);
  EXPECT_NEAR(camera.see({1, 0, 0}).x, 0.1, 1e-12);
  EXPECT_NEAR(camera.see({0, 0, 1}).y, 0.1, 1e-12);
  EXPECT_NEAR(camera.see({1, -5, 0}).x, 0.2, 1e-12);
}

TEST(SolidView, OnlyWhatFacesTheEyeIsPainted) {
  const Camera camera({0, -10, 0}, {0, 0, 0});
  EXPECT_EQ(view_of(rectangle({0, 0, 0}, {1, 0, 0}, {0, 0, 1}), camera, 2).size(), 1u);
  EXPECT_TRUE(view_of(rectangle({0, 0, 0}, {0, 0, 1}, {1, 0, 0}), camera, 2).empty());
}

TEST(SolidView, RectanglesAreCutButNotIntoMoreThanIsWanted) {
  const Camera camera({0, -10, 0}, {0, 0, 0});
  const map::Solid wall = rectangle({0, 0, 0}, {4, 0, 0}, {0, 0, 2});
  EXPECT_EQ(view_of(wall, camera, 0.5).size(), 8u * 4);
  EXPECT_LE(view_of(wall, camera, 0.01, 50).size(), 100u);
}

TEST(SolidView, NearerIsPaintedLater) {
  const Camera camera({0, -10, 0}, {0, 0, 0});
  map::Solid two = rectangle({0, -3, 0}, {1, 0, 0}, {0, 0, 1}, {255, 0, 0});
  two.parts.push_back(rectangle({0, 3, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0, 255}).parts[0]);
  const std::vector<Mark> marks = view_of(two, camera, 5);
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_GT(std::get<Polyline>(marks[1]).fill->r, 100);
  EXPECT_GT(std::get<Polyline>(marks[0]).fill->b, 100);
}

TEST(SolidView, AllIsInFrontOfWhoOverlooks) {
  const map::Solid floor = rectangle({5, 6, 0}, {40, 0, 0}, {0, 3, 0});
  const Camera camera = overlooking(floor);
  for (const Eigen::Vector3f& v : floor.parts[0].vertices) {
    const Point p = camera.see(v.cast<double>());
    EXPECT_LT(std::abs(p.x), 1);
    EXPECT_LT(std::abs(p.y), 1);
  }
  EXPECT_FALSE(view_of(floor, camera).empty());
  EXPECT_TRUE(view_of({}, overlooking({})).empty());
}

TEST(FigureSolid, ShowsThePointsAndThePlanes) {
  const Figure figure = figure_solid({});
  ASSERT_EQ(figure.panels.size(), 2u);
  EXPECT_EQ(figure.panels[0].marks.size(), 3u);
  EXPECT_GT(figure.panels[1].marks.size(), 1000u);
}

}  // namespace
}  // namespace majak::draw
