// SPDX-License-Identifier: Apache-2.0
// Figures 6 and 7 show what their captions say.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

template <class T>
std::vector<T> all(const Panel& panel) {
  std::vector<T> out;
  for (const Mark& mark : panel.marks) {
    if (const T* m = std::get_if<T>(&mark)) out.push_back(*m);
  }
  return out;
}

TEST(FigureTrilateration, BothPlacesLieOnBothCircles) {
  const Figure figure = figure_trilateration({});
  ASSERT_EQ(figure.panels.size(), 2U);
  std::vector<Ellipse> circles;
  for (const Ellipse& e : all<Ellipse>(figure.panels[0])) {
    if (e.rx == e.ry && e.rx > 2) circles.push_back(e);
  }
  ASSERT_EQ(circles.size(), 2U);
  int places = 0;
  for (const Dots& dots : all<Dots>(figure.panels[0])) {
    const Point p = dots.at.at(0);
    const auto off = [&](const Ellipse& c) {
      return std::abs(std::hypot(p.x - c.centre.x, p.y - c.centre.y) - c.rx);
    };
    places += off(circles[0]) < 1e-9 && off(circles[1]) < 1e-9;
  }
  EXPECT_EQ(places, 2);
}

TEST(FigureTriangulation, TheDangerCircleIsRed) {
  const Panel field = figure_triangulation({}).panels.at(1);
  const Ellipse circle = all<Ellipse>(field).at(0);
  const auto colour_at = [&](double x, double y) {
    for (const Polyline& cell : all<Polyline>(field)) {
      const Point &low = cell.points[0], &high = cell.points[2];
      if (cell.fill && x >= low.x && x < high.x && y >= low.y && y < high.y)
        return cell.fill->r * 65536 + cell.fill->g * 256 + cell.fill->b;
    }
    return -1;
  };
  const int worst = 185 * 65536 + 45 * 256 + 40;
  int on_circle = 0, red = 0;
  for (double t = 0; t < 2 * kPi; t += 0.05) {
    const int colour = colour_at(circle.centre.x + circle.rx * std::cos(t),
                                 circle.centre.y + circle.rx * std::sin(t));
    on_circle += colour != -1;
    red += colour == worst;
  }
  EXPECT_GT(on_circle, 60);
  EXPECT_GT(red, 0.95 * on_circle);
  EXPECT_NE(colour_at(circle.centre.x, circle.centre.y), worst);
}

TEST(FigureTriangulation, IsASmallFile) {
  EXPECT_LT(figure_svg(figure_triangulation({})).size(), 400'000U);
}

}  // namespace
}  // namespace majak::draw
