// SPDX-License-Identifier: Apache-2.0
// Figure 9 shows what its titles say.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

struct Cloud {
  std::vector<Point> particles;
  Point robot;
};

Cloud cloud_of(const Panel& panel) {
  Cloud s;
  for (const Mark& mark : panel.marks) {
    if (const auto* dots = std::get_if<Dots>(&mark)) s.particles = dots->at;
    if (const auto* arrow = std::get_if<Arrow>(&mark)) s.robot = arrow->from;
  }
  return s;
}

double share_within(const Cloud& s, double radius) {
  double n = 0;
  for (const Point& p : s.particles) n += std::hypot(p.x - s.robot.x, p.y - s.robot.y) < radius;
  return n / static_cast<double>(s.particles.size());
}

TEST(FigureMonteCarlo, TheCloudClosesInOnTheRobot) {
  const Figure figure = figure_monte_carlo({});
  ASSERT_EQ(figure.panels.size(), 3U);
  for (const Panel& panel : figure.panels) EXPECT_EQ(cloud_of(panel).particles.size(), 5000U);
  EXPECT_LT(share_within(cloud_of(figure.panels[0]), 2), 0.05);
  EXPECT_LT(share_within(cloud_of(figure.panels[1]), 0.5), 0.9);
  EXPECT_GE(share_within(cloud_of(figure.panels[2]), 0.5), 0.99);
}

}  // namespace
}  // namespace majak::draw
