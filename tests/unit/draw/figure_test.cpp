// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/figure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/draw/stroke_font.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/draw/trajectory_figure.hpp"

namespace majak::draw {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

template <class T>
std::vector<T> all_of(const Figure& figure) {
  std::vector<T> found;
  for (const Stroke& stroke : strokes_of(figure))
    if (const auto* what = std::get_if<T>(&stroke.what)) found.push_back(*what);
  return found;
}

bool says(const Figure& figure, const std::string& text) {
  for (const Words& words : all_of<Words>(figure))
    if (words.text == text) return true;
  return false;
}

/// One sketch panel of 100 x 100 points.
Figure sketch(std::vector<Mark> marks) {
  Figure figure{.width = 124, .height = 124};
  figure.panels.push_back({.place = figure.whole(),
                           .x = {"", 0, 10},
                           .y = {"", 0, 10},
                           .framed = false,
                           .marks = std::move(marks)});
  return figure;
}

TEST(Figure, UnitsBecomePoints) {
  const auto outlines = all_of<Outline>(sketch({Polyline{{{0, 0}, {10, 10}, {5, 2}}}}));
  ASSERT_EQ(outlines.size(), 1U);
  EXPECT_EQ(outlines[0].points, (std::vector<Point>{{12, 112}, {112, 12}, {62, 92}}));
}

TEST(Figure, PicturesLieInTheUnitsOfThePanel) {
  io::Image image(2, 1, 1);
  image.pixels = {0, 255};
  const Figure figure = sketch({Picture{image, {1, 2}, 3}});
  const auto pixels = all_of<Pixels>(figure);
  ASSERT_EQ(pixels.size(), 1U);
  EXPECT_EQ(pixels[0].place.left, 22);
  EXPECT_EQ(pixels[0].place.top, 62);
  EXPECT_EQ(pixels[0].place.width, 60);
  EXPECT_EQ(pixels[0].place.height, 30);
  const io::Image drawn = figure_image(figure, 1);
  EXPECT_EQ(drawn.row(70)[3 * 30], 0);
  EXPECT_EQ(drawn.row(70)[3 * 60], 255);
  EXPECT_THAT(figure_svg(figure), HasSubstr("<image x=\"22\" y=\"62\" width=\"60\" height=\"30\""));
}

TEST(Figure, OneUnitIsAsLongBothWays) {
  Figure figure{.width = 800, .height = 300};
  figure.panels.push_back({.place = figure.whole(), .marks = {circle({3, -2}, 1, {})}});
  for (const Outline& o : all_of<Outline>(figure)) {
    if (o.points.size() < 50) continue;  // the frame
    double left = 1e9, right = 0, top = 1e9, bottom = 0;
    for (const Point& p : o.points) {
      left = std::min(left, p.x), right = std::max(right, p.x);
      top = std::min(top, p.y), bottom = std::max(bottom, p.y);
    }
    EXPECT_NEAR(right - left, bottom - top, 1e-9);
    EXPECT_GT(bottom - top, 150);
  }
}

TEST(Figure, AxesCarryRoundNumbersAndLabels) {
  Figure figure{.width = 500, .height = 400, .title = "A walk"};
  figure.panels.push_back({.place = figure.whole(),
                           .x = {"x (m)", 0, 20},
                           .y = {"error (m)", -1, 1},
                           .equal = false,
                           .legend = {{"wheels", Pen{ink::blue, 2}}, {"fixes", {}, ink::red}}});
  for (const char* text : {"A walk", "x (m)", "error (m)", "0", "10", "20", "-1", "1", "wheels"})
    EXPECT_TRUE(says(figure, text)) << text;
}

TEST(Figure, EllipseOfACovariance) {
  Eigen::Matrix2d P;
  P << 4, 0, 0, 1;
  const Ellipse e = covariance_ellipse({1, 2}, P, {}, 1);
  EXPECT_NEAR(e.rx, 2, 1e-12);
  EXPECT_NEAR(e.ry, 1, 1e-12);
  EXPECT_NEAR(e.angle, 0, 1e-12);
  P << 1, 0.9, 0.9, 1;
  EXPECT_NEAR(covariance_ellipse({0, 0}, P, {}).angle, kPi / 4, 1e-12);
  P.setZero();
  EXPECT_EQ(covariance_ellipse({0, 0}, P, {}).rx, 0);
}

TEST(Figure, SvgHoldsWhatTheSceneSays) {
  Figure figure =
      sketch({Polyline{{{0, 0}, {10, 10}}, {ink::blue, 2, 6}},
              Polyline{{{0, 0}, {10, 0}, {5, 5}}, {ink::red, 0}, true, ink::red.faint(0.5)},
              Dots{{{5, 5}, {6, 5}}, 3, ink::green}, Label{{1, 1}, "a < b"}});
  figure.title = "Q & A";
  const std::string svg = figure_svg(figure);
  EXPECT_THAT(svg, HasSubstr("<title>Q &amp; A</title>"));
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray=\"6\""));
  EXPECT_THAT(svg, HasSubstr("fill-opacity=\"0.5\""));
  EXPECT_THAT(svg, HasSubstr("a &lt; b</text>"));
  EXPECT_THAT(svg, HasSubstr("stroke-width=\"6\""));  // dots of radius 3
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_EQ(svg, figure_svg(figure));
}

TEST(Figure, PointsThatAreNoNumbersAreLeftOut) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Figure figure{.width = 300, .height = 200};
  figure.panels.push_back({.place = figure.whole(),
                           .marks = {Polyline{{{0, 0}, {nan, 1}, {1, 1}}}, Dots{{{nan, nan}}}}});
  EXPECT_THAT(figure_svg(figure), Not(HasSubstr("nan")));
  figure.panels[0].marks.clear();
  EXPECT_THAT(figure_svg(figure), HasSubstr("</svg>"));  // an empty frame
}

TEST(Figure, WhatLiesFarOutsideIsCutOff) {
  Figure figure{.width = 300, .height = 200};
  figure.panels.push_back({.place = figure.whole(),
                           .x = {"", 0, 1},
                           .y = {"", 0, 1},
                           .marks = {Polyline{{{-1e15, 0.5}, {1e15, 0.5}}, {ink::red, 3, 5}},
                                     circle({0.5, 0.5}, 1e12, {ink::blue, 2}, ink::blue)},
                           .legend = {{"far", Pen{}}}});
  EXPECT_EQ(figure_image(figure, 1).width, 300);
  EXPECT_THAT(figure_svg(figure), HasSubstr("clip-path"));
}

TEST(Figure, LegendsStandWhereTheyHideLeast) {
  Figure figure{.width = 600, .height = 400};
  // Lines at the top and on the right: what is left is the bottom on the left.
  Panel panel{.place = figure.whole(),
              .x = {"", 0, 6},
              .y = {"", 0, 4},
              .equal = false,
              .marks = {Polyline{{{0, 3.8}, {6, 3.8}}}, Polyline{{{5.8, 0}, {5.8, 4}}}},
              .legend = {{"a line", Pen{}}}};
  const auto place = [&](const Panel& p) {
    Figure f = figure;
    f.panels = {p};
    for (const Words& w : all_of<Words>(f))
      if (w.text == "a line") return w.at;
    return Point{};
  };
  EXPECT_LT(place(panel).x, 300);
  EXPECT_GT(place(panel).y, 200);
  panel.legend_at = Corner::top_right;
  EXPECT_GT(place(panel).x, 300);
  EXPECT_LT(place(panel).y, 200);
}

TEST(Figure, PictureAndSvgAreOneScene) {
  // Where the scene has ink, the picture has; the dash's gaps are white.
  const Figure figure = sketch({Polyline{{{0, 5}, {10, 5}}, {ink::black, 4, 10}}});
  const io::Image image = figure_image(figure, 1);
  EXPECT_EQ(image.width, 124);
  const auto at = [&](int x, int y) { return int(image.row(y)[3 * x]); };
  EXPECT_LT(at(17, 62), 60);
  EXPECT_GT(at(27, 62), 200);
  EXPECT_LT(at(37, 62), 60);
  EXPECT_EQ(at(17, 40), 255);
}

TEST(Figure, ArrowsPointToTheirEnd) {
  const auto outlines = all_of<Outline>(sketch({Arrow{{0, 0}, {10, 0}, {ink::red, 2}, false}}));
  ASSERT_EQ(outlines.size(), 2U);
  EXPECT_EQ(outlines[1].points[0], (Point{112, 112}));  // the tip
  EXPECT_TRUE(outlines[1].fill.has_value());
  EXPECT_LT(outlines[0].points.back().x, 112);  // the shaft ends within it
  EXPECT_EQ(all_of<Outline>(sketch({Arrow{{0, 0}, {10, 0}, {}, true}})).size(), 3U);
  EXPECT_EQ(all_of<Outline>(sketch({Arrow{{1, 1}, {1, 1}, {}, false}})).size(), 1U);
}

// Letters.

TEST(StrokeFont, LettersStandOnTheLine) {
  for (const auto& line : letter_strokes("H", 100)) {
    for (const Point& p : line) {
      EXPECT_LE(p.y, 0);
      EXPECT_GE(p.y, -73);
    }
  }
  EXPECT_EQ(letter_strokes("i", 20).size(), 2U);
  const auto dot = letter_strokes("i", 20)[1];
  EXPECT_EQ(dot.front(), dot.back());
}

TEST(StrokeFont, WidthsAddUp) {
  EXPECT_EQ(text_width("", 20), 0);
  EXPECT_GT(text_width("mm", 20), 2 * text_width("m", 20));
  EXPECT_NEAR(text_width("abc", 40), 2 * text_width("abc", 20), 1e-12);
  EXPECT_GT(text_width("a b", 20), text_width("ab", 20));
}

TEST(StrokeFont, SignsAndGreekAreKnown) {
  const auto box = letter_strokes("\x01", 20);  // unknown
  for (const char* sign :
       {"°", "±", "²", "·", "×", "θ", "ω", "σ", "χ", "√", "−", "₁", "Δ", "→", "–"})
    EXPECT_NE(letter_strokes(sign, 20), box) << sign;
  for (char c = '0'; c <= 'z'; ++c)
    if (std::isalnum(static_cast<unsigned char>(c))) {
      EXPECT_NE(letter_strokes(std::string(1, c), 20), box) << c;
    }
  for (const char* broken : {"\xC2", "\xE2\x88", "\xFF"})
    EXPECT_EQ(letter_strokes(broken, 20), box);
}

// The figures.

TEST(PathPicture, ShowsWhatThereIs) {
  PathPicture picture{.title = "a log"};
  for (int i = 0; i < 100; ++i) {
    Estimate e{.time = i, .T_map_robot = {0.1 * i, 0, 0}};
    e.covariance = 0.001 * i * Mat3::Identity();
    picture.estimates.push_back(e);
    picture.truth.push_back({0.1 * i, 0.01 * i, 0});
  }
  EXPECT_TRUE(says(path_picture(picture), "truth"));
  EXPECT_TRUE(says(path_picture(picture), "95 % ellipse"));
  EXPECT_FALSE(says(path_picture(picture), "satellite fixes"));
  picture.fixes = {{0, 1, 1, 0}};
  EXPECT_TRUE(says(path_picture(picture), "satellite fixes"));
  std::size_t ellipses = 0;
  for (const Outline& o : all_of<Outline>(path_picture(picture))) ellipses += o.points.size() == 96;
  EXPECT_EQ(ellipses, 12U);
  picture.estimates.back().covariance *= 1e6;  // larger than the path
  EXPECT_TRUE(says(path_picture(picture), "95 % ellipse, while smaller than the path"));
  picture.estimates.resize(1);
  EXPECT_FALSE(says(path_picture(picture), "95 % ellipse"));
}

TEST(ThesisFigures, EachIsDrawnAndNumberedOnce) {
  std::pair<int, std::string> last;  // 9, 10, 22, 22b
  for (const ThesisFigure& f : thesis_figures()) {
    std::size_t digits = 0;
    const int number = std::stoi(f.name, &digits);
    const std::pair<int, std::string> name(number, f.name + digits);
    EXPECT_GT(name, last);
    last = name;
    EXPECT_EQ(&thesis_figure(f.name), &f);
    const Figure figure = f.make({});
    EXPECT_FALSE(figure.title.empty()) << f.name;
    EXPECT_GT(strokes_of(figure).size(), 10U) << f.name;
    for (const Words& w : all_of<Words>(figure)) {  // all letters on the sheet, none unknown
      const double width = text_width(w.text, w.size);
      const double left = w.at.x - (w.anchor == Anchor::start    ? 0
                                    : w.anchor == Anchor::middle ? width / 2
                                                                 : width);
      if (w.upright) continue;
      EXPECT_GE(left, 0) << f.name << ": " << w.text;
      EXPECT_LE(left + width, figure.width) << f.name << ": " << w.text;
    }
  }
  EXPECT_THROW(thesis_figure("1000"), Error);
  EXPECT_THROW(thesis_figure(""), Error);
}

}  // namespace
}  // namespace majak::draw
