// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

const Picture& picture_of(const Panel& panel) {
  for (const Mark& mark : panel.marks)
    if (const auto* picture = std::get_if<Picture>(&mark)) return *picture;
  throw std::runtime_error("no picture");
}

/// 0 black ... 255 white; of the pixel at (x, y) m.
int grey(const Picture& p, double x, double y) {
  const int column = static_cast<int>(std::floor((x - p.low.x) / p.pixel));
  const int row = p.image.height - 1 - static_cast<int>(std::floor((y - p.low.y) / p.pixel));
  return p.image.pixels.at(
      static_cast<std::size_t>((row * p.image.width + column) * p.image.channels));
}

/// Does a row of cells about the wall y = 2 bar the way from x0 to x1?
bool closed(const Panel& panel, double x0, double x1) {
  const Picture& p = picture_of(panel);
  for (double y = 1.75; y < 2.4; y += 0.1) {
    bool dark = true;
    for (double x = x0; x < x1; x += 0.1) dark &= grey(p, x, y) < 100;
    if (dark) return true;
  }
  return false;
}

TEST(FigureForward, StandardClosesADoorwayThatTheForwardModelKeeps) {
  const Figure figure = figure_forward({});
  ASSERT_EQ(figure.panels.size(), 2U);
  // The narrowest doorway with a bit of wall on either side.
  EXPECT_TRUE(closed(figure.panels[0], -3.25, -2.2));
  for (const auto& [x0, x1] : {std::pair(-3.25, -2.2), {-0.25, 0.9}, {2.75, 4.2}})
    EXPECT_FALSE(closed(figure.panels[1], x0, x1)) << x0;
  EXPECT_TRUE(closed(figure.panels[1], -2.2, -1.3));  // a wall is one
}

}  // namespace
}  // namespace majak::draw
