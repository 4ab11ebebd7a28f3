// SPDX-License-Identifier: Apache-2.0
// Figure 21 shows what it says: nine grids, what stays, a tenth visit and four objects.
#include <gtest/gtest.h>

#include <variant>

#include "majak/draw/thesis_figures.hpp"

namespace majak::draw {
namespace {

std::size_t pixels_of(const Picture& picture, const Colour& c) {
  std::size_t count = 0;
  const auto& p = picture.image.pixels;
  for (std::size_t i = 0; i + 2 < p.size(); i += 3)
    count += p[i] == c.r && p[i + 1] == c.g && p[i + 2] == c.b;
  return count;
}

TEST(FigureDogma, NineGridsAndFourObjects) {
  const Figure figure = figure_dogma({});
  ASSERT_EQ(figure.panels.size(), 9U + 2U + 4U);
  std::vector<Picture> pictures;
  for (const Panel& panel : figure.panels)
    pictures.push_back(std::get<Picture>(panel.marks.front()));
  const Colour colours[] = {ink::blue, ink::red, ink::green, ink::orange};
  for (std::size_t t = 0; t < 9; ++t) {
    std::size_t coloured = 0;
    for (const Colour& c : colours) coloured += pixels_of(pictures[t], c);
    EXPECT_GT(coloured, 100U) << t;
    EXPECT_GT(pixels_of(pictures[t], ink::black), 400U) << t;
  }
  // Nothing that moves is left in what stays; all four are recognized on the tenth visit.
  for (const Colour& c : colours) EXPECT_EQ(pixels_of(pictures[9], c), 0U);
  EXPECT_EQ(figure.panels[10].marks.size(), 1U + 4U);
}

}  // namespace
}  // namespace majak::draw
