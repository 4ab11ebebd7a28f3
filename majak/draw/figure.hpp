// SPDX-License-Identifier: Apache-2.0
// A figure, described once and drawn twice: as SVG and as a picture. Panels hold marks in the units
// of their axes (metres, mostly; y upwards); pens, dots and letters are measured in points of the
// sheet, whose y points down.
//
//   Figure figure{.width = 800, .height = 500, .title = "A walk"};
//   Panel panel{.place = figure.whole(), .x = {"x (m)"}, .y = {"y (m)"}};
//   panel.marks = {Polyline{path, {ink::blue, 2}}, Dots{fixes, 2.5, ink::red}};
//   panel.legend = {{"wheels", Pen{ink::blue, 2}}, {"satellites", {}, ink::red}};
//   figure.panels.push_back(panel);
//   write(figure_svg(figure)), write(io::encode_png(figure_image(figure)));
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/draw/svg.hpp"
#include "majak/io/png.hpp"

namespace majak::draw {

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0;
  double alpha = 1;
  Colour faint(double a) const { return {r, g, b, a * alpha}; }
};

/// Colours that stay apart in print, on screens and for the colour-blind (after Okabe and Ito).
namespace ink {
inline constexpr Colour black{31, 35, 40}, grey{125, 132, 140}, light{222, 226, 231},
    white{255, 255, 255}, blue{0, 98, 168}, red{200, 62, 32}, green{0, 138, 100},
    orange{214, 138, 0}, purple{150, 84, 150}, sky{84, 170, 222};
}  // namespace ink

struct Pen {
  Colour colour = ink::black;
  double width = 1.6;  ///< points; 0: nothing is drawn
  double dash = 0;     ///< points of line and of gap, 0: a whole line
};

struct Polyline {
  std::vector<Point> points{};
  Pen pen{};
  bool closed = false;
  std::optional<Colour> fill{};
};
struct Dots {
  std::vector<Point> at;
  double radius = 2.5;  ///< points
  Colour colour = ink::black;
};
struct Ellipse {
  Point centre;
  double rx = 1, ry = 1, angle = 0;  ///< half axes; rad, of the first
  Pen pen;
  std::optional<Colour> fill{};
};
struct Arrow {
  Point from, to;  ///< the tip is at `to`
  Pen pen;
  bool both = false;  ///< a dimension: tips at both ends
};
enum class Anchor : std::uint8_t { start, middle, end };
struct Label {
  Point at;
  std::string text;
  double dx = 0, dy = 0;  ///< points to the right and up, from `at` to the baseline
  Anchor anchor = Anchor::start;
  double size = 15;  ///< points
  Colour colour = ink::black;
};
/// Pixels laid into the panel's units: grey, colour, or colour with alpha. Pixels keep their sharp
/// edges.
struct Picture {
  io::Image image;
  Point low;  ///< the lower left corner of the lower left pixel
  double pixel = 1;
};
using Mark = std::variant<Picture, Polyline, Dots, Ellipse, Arrow, Label>;

/// A circle, and the ellipse that holds a share of all errors of (x, y) given by `chi2`, the
/// quantile of chi-square with two degrees of freedom (5.991 for 95 %).
Ellipse circle(Point centre, double radius, Pen pen, std::optional<Colour> fill = {});
Ellipse covariance_ellipse(const Vec2& mean, const Eigen::Matrix2d& covariance, Pen pen,
                           double chi2 = 5.991464547107979);

/// Where a mark is, in the panel's units: the corners of what it covers.
std::vector<Point> points_of(const Mark& mark);

struct Axis {
  std::string label;                    ///< with its unit
  std::optional<double> low{}, high{};  ///< default: as the marks ask
};
struct LegendEntry {
  std::string text;
  std::optional<Pen> pen{};
  std::optional<Colour> dot{};
};
enum class Corner : std::uint8_t { top_left, top_right, bottom_left, bottom_right };

struct Box {
  double left = 0, top = 0, width = 0, height = 0;
};
struct Panel {
  Box place;  ///< on the sheet, title and labels of the axes included
  std::string title{};
  Axis x{}, y{};
  bool equal = true;   ///< one unit is as long along both axes
  bool framed = true;  ///< false: a sketch without frame, ticks and grid
  std::vector<Mark> marks{};
  std::vector<LegendEntry> legend{};
  std::optional<Corner> legend_at{};  ///< default: where it hides least
};

struct Figure {
  double width = 900, height = 600;  ///< points
  std::string title{};
  std::vector<Panel> panels{};
  /// The sheet below the title.
  Box whole() const {
    const double top = title.empty() ? 0 : 40;
    return {0, top, width, height - top};
  }
};

// What a figure consists of on the sheet; both renderers draw these and nothing else.
struct Outline {
  std::vector<Point> points;
  bool closed = false;
  Pen pen;
  std::optional<Colour> fill;
};
struct Spots {
  std::vector<Point> at;
  double radius;
  Colour colour;
};
struct Words {
  Point at;
  std::string text;
  Anchor anchor = Anchor::start;
  double size = 15;
  Colour colour = ink::black;
  bool upright = false;  ///< reads upwards
};
struct Pixels {
  io::Image image;
  Box place;
};
using What = std::variant<Pixels, Outline, Spots, Words>;
struct Stroke {
  What what;
  Box clip;
};

std::vector<Stroke> strokes_of(const Figure& figure);

/// A whole SVG file.
std::string figure_svg(const Figure& figure);
/// `scale` pixels a point.
io::Image figure_image(const Figure& figure, double scale = 2);

}  // namespace majak::draw
