// SPDX-License-Identifier: Apache-2.0
// The strokes of a figure as SVG and as pixels.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "majak/draw/figure.hpp"
#include "majak/draw/raster.hpp"
#include "majak/draw/stroke_font.hpp"

namespace majak::draw {
namespace {

std::string paint_of(const char* property, const Colour& c) {
  std::string text = fmt::format(" {}=\"#{:02x}{:02x}{:02x}\"", property, c.r, c.g, c.b);
  if (c.alpha < 1) text += fmt::format(" {}-opacity=\"{}\"", property, number(c.alpha));
  return text;
}

std::string svg_of(const Pixels& p) {
  return fmt::format(
      "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" "
      "style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
      number(p.place.left, 3), number(p.place.top, 3), number(p.place.width, 3),
      number(p.place.height, 3), base64(io::encode_png(p.image)));
}

std::string svg_of(const Outline& o) {
  std::string text = fmt::format("<path d=\"{}{}\"", path_data(o.points, 2), o.closed ? "Z" : "");
  text += o.fill ? paint_of("fill", *o.fill) : " fill=\"none\"";
  if (o.pen.width > 0) {
    text += paint_of("stroke", o.pen.colour);
    text += fmt::format(" stroke-width=\"{}\"", number(o.pen.width));
    if (o.pen.dash > 0) text += fmt::format(" stroke-dasharray=\"{}\"", number(o.pen.dash));
  }
  return text + "/>\n";
}

/// Lines of no length whose round ends are the dots: one element for thousands.
std::string svg_of(const Spots& s) {
  std::string d;
  for (const Point& p : s.at)
    fmt::format_to(std::back_inserter(d), "M{} {}h0", number(p.x, 1), number(p.y, 1));
  return fmt::format("<path d=\"{}\" fill=\"none\"{} stroke-width=\"{}\"/>\n", d,
                     paint_of("stroke", s.colour), number(2 * s.radius));
}

/// Words, not numbers, are as wide as they were laid out for, whatever the reader's font.
std::string svg_of(const Words& w) {
  constexpr std::size_t kNumber = 6;  // letters at most
  const char* const anchors[] = {"start", "middle", "end"};
  const std::string width =
      w.text.size() > kNumber
          ? fmt::format(" textLength=\"{}\"", number(text_width(w.text, w.size)))
          : "";
  const std::string at = fmt::format("{} {}", number(w.at.x), number(w.at.y));
  return fmt::format(
      "<text transform=\"translate({}){}\" font-size=\"{}\" text-anchor=\"{}\"{}{}>{}</text>\n", at,
      w.upright ? " rotate(-90)" : "", number(w.size), anchors[int(w.anchor)], width,
      paint_of("fill", w.colour), escape(w.text));
}

double length_of(const std::vector<Point>& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    length += std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
  return length;
}

/// The whole parts of a dashed line; one that runs far beyond any sheet stays whole.
std::vector<std::vector<Point>> dashes(const std::vector<Point>& points, double dash) {
  constexpr double kMost = 1e5;
  if (length_of(points) > kMost * dash) return {points};
  std::vector<std::vector<Point>> parts;
  double left = dash;  // of this dash or gap
  bool drawing = true;
  std::vector<Point> part = {points.front()};
  for (std::size_t i = 1; i < points.size(); ++i) {
    Point a = points[i - 1];
    const Point b = points[i];
    double length = std::hypot(b.x - a.x, b.y - a.y);
    while (length > left) {
      a = {a.x + (b.x - a.x) * left / length, a.y + (b.y - a.y) * left / length};
      length -= left;
      left = dash;
      part.push_back(a);
      if (drawing) parts.push_back(part);
      part = {a};
      drawing = !drawing;
    }
    left -= length;
    part.push_back(b);
  }
  if (drawing) parts.push_back(part);
  return parts;
}

void draw(Raster& raster, const Pixels& p, double scale) {
  raster.picture(p.image, {p.place.left * scale, p.place.top * scale, p.place.width * scale,
                           p.place.height * scale});
}

void draw(Raster& raster, const Outline& o, double scale) {
  std::vector<Point> points;
  for (const Point& p : o.points) points.push_back({p.x * scale, p.y * scale});
  if (points.empty()) return;
  if (o.fill) raster.area(points, *o.fill);
  if (o.pen.width <= 0) return;
  if (o.closed) points.push_back(points.front());
  const double width = o.pen.width * scale;
  if (o.pen.dash <= 0) return raster.line(points, width, o.pen.colour);
  for (const auto& part : dashes(points, o.pen.dash * scale))
    raster.line(part, width, o.pen.colour);
}

void draw(Raster& raster, const Spots& s, double scale) {
  for (const Point& p : s.at) {
    const Point at[] = {{p.x * scale, p.y * scale}};
    raster.line(at, 2 * s.radius * scale, s.colour);
  }
}

void draw(Raster& raster, const Words& w, double scale) {
  const double width = text_width(w.text, w.size);
  const double shift = w.anchor == Anchor::start ? 0 : w.anchor == Anchor::end ? width : width / 2;
  for (auto& line : letter_strokes(w.text, w.size)) {
    for (Point& p : line) {
      p.x -= shift;
      if (w.upright) p = {p.y, -p.x};
      p = {(p.x + w.at.x) * scale, (p.y + w.at.y) * scale};
    }
    raster.line(line, letter_pen(w.size) * scale, w.colour);
  }
}

}  // namespace

std::string figure_svg(const Figure& figure) {
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} "
      "{1}\" font-family=\"Helvetica, Arial, sans-serif\" stroke-linecap=\"round\" "
      "stroke-linejoin=\"round\">\n<title>{2}</title>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
      number(figure.width), number(figure.height), escape(figure.title));
  int clips = 0;
  Box open;  // the clip of the group that is open
  for (const Stroke& stroke : strokes_of(figure)) {
    const Box& c = stroke.clip;
    const bool same = c.left == open.left && c.top == open.top && c.width == open.width &&
                      c.height == open.height;
    if (!same) {
      text += clips > 0 ? "</g>\n" : "";
      text += fmt::format(
          "<clipPath id=\"c{0}\"><rect x=\"{1}\" y=\"{2}\" width=\"{3}\" height=\"{4}\"/>"
          "</clipPath>\n<g clip-path=\"url(#c{0})\">\n",
          ++clips, number(c.left), number(c.top), number(c.width), number(c.height));
      open = c;
    }
    text += std::visit([](const auto& what) { return svg_of(what); }, stroke.what);
  }
  return text + (clips > 0 ? "</g>\n" : "") + "</svg>\n";
}

io::Image figure_image(const Figure& figure, double scale) {
  Raster raster(int(std::lround(figure.width * scale)), int(std::lround(figure.height * scale)));
  for (const Stroke& stroke : strokes_of(figure)) {
    const Box& c = stroke.clip;
    raster.clip({c.left * scale, c.top * scale, c.width * scale, c.height * scale});
    std::visit([&](const auto& what) { draw(raster, what, scale); }, stroke.what);
  }
  return std::move(raster).image();
}

}  // namespace majak::draw
