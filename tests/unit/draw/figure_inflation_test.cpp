// SPDX-License-Identifier: Apache-2.0
// Figure 18 shows what it says: robots stand clear of the obstacles, and as near as the grid lets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

constexpr double kCell = 0.1;

struct Shown {
  std::vector<Vec2> obstacles;  ///< middles of cells
  std::size_t blocked = 0;      ///< cells, obstacles not counted
  std::vector<Ellipse> discs;
  std::vector<Polyline> carts;
};

Vec2 vec(const Point& p) { return {p.x, p.y}; }

Shown shown(const Panel& panel) {
  Shown s;
  for (const Mark& mark : panel.marks) {
    if (const auto* disc = std::get_if<Ellipse>(&mark)) s.discs.push_back(*disc);
    const auto* line = std::get_if<Polyline>(&mark);
    if (line == nullptr || !line->fill) continue;
    const Colour& fill = *line->fill;
    if (fill.r == ink::black.r) s.obstacles.push_back(vec(line->points[0]) + Vec2(0.05, 0.05));
    if (fill.r == ink::orange.r) ++s.blocked;
    if (fill.r == ink::sky.r) s.carts.push_back(*line);
  }
  return s;
}

/// m, from a robot's middle to the nearest obstacle, whose cells are `half` to each side.
double gap(const Shown& s, const Point& robot, double half) {
  double least = 1e9;
  for (const Vec2& o : s.obstacles)
    least = std::min(least, ((o - vec(robot)).cwiseAbs() - Vec2(half, half)).cwiseMax(0).norm());
  return least;
}

TEST(FigureInflation, DiscsStandAsNearAsTheyMay) {
  const Figure figure = figure_inflation({});
  for (const int k : {0, 1}) {
    const Shown s = shown(figure.panels[static_cast<std::size_t>(k)]);
    ASSERT_GE(s.discs.size(), 3U);
    for (const Ellipse& disc : s.discs) {
      const double d = gap(s, disc.centre, k * kCell / 2);
      EXPECT_GE(d, disc.rx - 1e-9);
      EXPECT_LE(d, disc.rx + 0.5 * kCell);
    }
  }
}

TEST(FigureInflation, AnyTouchBlocksMoreThanMiddles) {
  const Figure figure = figure_inflation({});
  EXPECT_GT(shown(figure.panels[0]).blocked, 100U);
  EXPECT_GT(shown(figure.panels[1]).blocked, shown(figure.panels[0]).blocked);
}

// All along its sides a cart is outside every obstacle's cell.
TEST(FigureInflation, CartsStandClear) {
  const Shown s = shown(figure_inflation({}).panels[2]);
  ASSERT_GE(s.carts.size(), 3U);
  double nearest = 1e9;
  for (const Polyline& cart : s.carts)
    for (std::size_t i = 0; i < 4; ++i)
      for (double t = 0; t < 1; t += 0.01) {
        const Vec2 a = vec(cart.points[i]), b = vec(cart.points[(i + 1) % 4]);
        const Vec2 p = a + t * (b - a);
        for (const Vec2& o : s.obstacles)
          nearest = std::min(nearest, (o - p).cwiseAbs().maxCoeff() - kCell / 2);
      }
  EXPECT_GE(nearest, 0);
  EXPECT_LE(nearest, kCell);
}

TEST(FigureInflation, RobotsAreNotInEachOthersWay) {
  for (const Panel& panel : figure_inflation({}).panels) {
    const Shown s = shown(panel);
    for (std::size_t i = 0; i < s.discs.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        EXPECT_GT((vec(s.discs[i].centre) - vec(s.discs[k].centre)).norm(), 2 * s.discs[i].rx);
  }
}

}  // namespace
}  // namespace majak::draw
