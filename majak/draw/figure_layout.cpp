// SPDX-License-Identifier: Apache-2.0
// From a figure's panels and marks to strokes on the sheet.
#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/draw/chart.hpp"
#include "majak/draw/figure.hpp"
#include "majak/draw/stroke_font.hpp"

namespace majak::draw {
namespace {

constexpr double kTitle = 19, kPanelTitle = 16, kLabel = 15, kTick = 13;  // sizes of letters
constexpr double kLeft = 66, kRight = 18, kTop = 14, kTopTitled = 34, kBottom = 52, kSketch = 12;
constexpr double kPad = 0.05;  // of the extent, around the marks
constexpr int kRound = 96;     // corners of an ellipse

struct Range {
  double low = 1e300, high = -1e300;
  void add(double v) {
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  double size() const { return high - low; }
};

std::vector<Point> corners(const Ellipse& e) {
  std::vector<Point> points;
  const double c = std::cos(e.angle), s = std::sin(e.angle);
  for (int i = 0; i < kRound; ++i) {
    const double t = 2 * kPi * i / kRound, x = e.rx * std::cos(t), y = e.ry * std::sin(t);
    points.push_back({e.centre.x + c * x - s * y, e.centre.y + s * x + c * y});
  }
  return points;
}

/// Where a panel's marks come to lie on the sheet.
class View {
 public:
  explicit View(const Panel& panel) {
    const Box& p = panel.place;
    const double top = panel.title.empty() ? (panel.framed ? kTop : kSketch) : kTopTitled;
    const double left = panel.framed ? kLeft : kSketch, right = panel.framed ? kRight : kSketch;
    const double bottom = panel.framed ? kBottom : kSketch;
    inner = {p.left + left, p.top + top, p.width - left - right, p.height - top - bottom};
    for (const Mark& mark : panel.marks)
      for (const Point& q : points_of(mark)) x.add(q.x), y.add(q.y);
    settle(x, panel.x), settle(y, panel.y);
    if (panel.equal) {
      const double unit = std::max(x.size() / inner.width, y.size() / inner.height);
      widen(x, unit * inner.width), widen(y, unit * inner.height);
    }
  }
  Point operator()(const Point& p) const {
    return {inner.left + (p.x - x.low) / x.size() * inner.width,
            inner.top + (y.high - p.y) / y.size() * inner.height};
  }
  std::vector<Point> operator()(const std::vector<Point>& points) const {
    std::vector<Point> out;
    for (const Point& p : points)
      if (std::isfinite(p.x) && std::isfinite(p.y)) out.push_back((*this)(p));
    return out;
  }

  Range x, y;
  Box inner;

 private:
  static void widen(Range& r, double size) {
    const double more = (size - r.size()) / 2;
    r.low -= more, r.high += more;
  }
  static void settle(Range& r, const Axis& axis) {
    if (r.low > r.high) r = {0, 1};
    widen(r, std::max(r.size() * (1 + 2 * kPad), 1e-9 + 1e-6 * std::abs(r.low)));
    if (axis.low) r.low = *axis.low;
    if (axis.high) r.high = *axis.high;
  }
};

/// Adds strokes with one clip.
class Sheet {
 public:
  explicit Sheet(const Box& clip) : clip_(clip) {}
  void clip(const Box& box) { clip_ = box; }
  void line(std::vector<Point> points, const Pen& pen) { area(std::move(points), pen, {}, false); }
  void area(std::vector<Point> points, const Pen& pen, std::optional<Colour> fill, bool closed) {
    put(Outline{std::move(points), closed, pen, fill});
  }
  void words(Words words) { put(std::move(words)); }
  void put(What what) { strokes.push_back({std::move(what), clip_}); }

  std::vector<Stroke> strokes;

 private:
  Box clip_;
};

/// A filled tip, a little longer than it is wide.
void tip(Sheet& sheet, const Point& from, const Point& to, const Pen& pen) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  if (length <= 0) return;
  const double size = std::min(5 + 2.6 * pen.width, length), wide = 0.38 * size;
  const Point u{(to.x - from.x) / length, (to.y - from.y) / length};
  const Point base{to.x - size * u.x, to.y - size * u.y};
  sheet.area(
      {to, {base.x - wide * u.y, base.y + wide * u.x}, {base.x + wide * u.y, base.y - wide * u.x}},
      {pen.colour, 0.5}, pen.colour, true);
}

/// The shaft ends where the tip begins, so that the tip stays sharp.
void arrow(Sheet& sheet, Point from, Point to, const Pen& pen, bool both) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const double cut = length > 0 ? std::min(4 + 1.6 * pen.width, length) / length : 0;
  const Point step{(to.x - from.x) * cut, (to.y - from.y) * cut};
  const Point begin = both ? Point{from.x + step.x, from.y + step.y} : from;
  sheet.line({begin, {to.x - step.x, to.y - step.y}}, pen);
  tip(sheet, from, to, pen);
  if (both) tip(sheet, to, from, pen);
}

void draw_marks(Sheet& sheet, const Panel& panel, const View& view) {
  struct Visitor {
    Sheet& sheet;
    const View& view;
    void operator()(const Picture& m) const {
      const std::vector<Point> p = view(points_of(m));
      sheet.put(Pixels{m.image, {p[3].x, p[3].y, p[1].x - p[3].x, p[1].y - p[3].y}});
    }
    void operator()(const Polyline& m) const {
      sheet.area(view(m.points), m.pen, m.fill, m.closed);
    }
    void operator()(const Dots& m) const { sheet.put(Spots{view(m.at), m.radius, m.colour}); }
    void operator()(const Ellipse& m) const { sheet.area(view(corners(m)), m.pen, m.fill, true); }
    void operator()(const Arrow& m) const { arrow(sheet, view(m.from), view(m.to), m.pen, m.both); }
    void operator()(const Label& m) const {
      const Point p = view(m.at);
      sheet.words({{p.x + m.dx, p.y - m.dy}, m.text, m.anchor, m.size, m.colour});
    }
  };
  for (const Mark& mark : panel.marks) std::visit(Visitor{sheet, view}, mark);
}

/// Round values within a range, about `apart` points from each other.
std::vector<double> round_values(const Range& r, double room, double apart) {
  const double step = ticks(r.size(), std::max(2, int(room / apart)))[1];
  std::vector<double> values;
  for (double k = std::ceil(r.low / step - 1e-9); k * step <= r.high + 1e-9 * step; ++k)
    values.push_back(k * step);
  return values;
}

void draw_axes(Sheet& sheet, const Panel& panel, const View& view) {
  const Box& in = view.inner;
  const double right = in.left + in.width, bottom = in.top + in.height;
  const Pen grid{ink::light, 1};
  for (const double v : round_values(view.x, in.width, 75)) {
    const double x = view(Point{v, 0}).x;
    sheet.line({{x, in.top}, {x, bottom}}, grid);
    sheet.words({{x, bottom + 18}, number(v, 6), Anchor::middle, kTick});
  }
  for (const double v : round_values(view.y, in.height, 50)) {
    const double y = view(Point{0, v}).y;
    sheet.line({{in.left, y}, {right, y}}, grid);
    sheet.words({{in.left - 8, y + 4.5}, number(v, 6), Anchor::end, kTick});
  }
  sheet.words({{(in.left + right) / 2, bottom + 41}, panel.x.label, Anchor::middle, kLabel});
  sheet.words({{in.left - 48, (in.top + bottom) / 2},
               panel.y.label,
               Anchor::middle,
               kLabel,
               ink::black,
               true});
}

void draw_frame(Sheet& sheet, const Box& in) {
  sheet.area({{in.left, in.top},
              {in.left + in.width, in.top},
              {in.left + in.width, in.top + in.height},
              {in.left, in.top + in.height}},
             {ink::grey, 1.2}, {}, true);
}

Box in_corner(const Box& in, Corner corner, double width, double height) {
  constexpr double kInset = 10;
  const bool right = corner == Corner::top_right || corner == Corner::bottom_right;
  const bool top = corner == Corner::top_left || corner == Corner::top_right;
  return {right ? in.left + in.width - width - kInset : in.left + kInset,
          top ? in.top + kInset : in.top + in.height - height - kInset, width, height};
}

/// How much of the marks lies under a box, in points of lines; a picture lies everywhere.
int hidden(const Panel& panel, const View& view, const Box& box) {
  constexpr double kStride = 6, kMost = 1000;
  int count = 0;
  for (const Mark& mark : panel.marks) {
    if (std::holds_alternative<Picture>(mark)) continue;
    const std::vector<Point> points = view(points_of(mark));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point b = points[i],
                  a = i > 0 && !std::holds_alternative<Dots>(mark) ? points[i - 1] : b;
      const int steps = 1 + int(std::min(kMost, std::hypot(b.x - a.x, b.y - a.y) / kStride));
      for (int k = 1; k <= steps; ++k) {
        const double x = a.x + (b.x - a.x) * k / steps, y = a.y + (b.y - a.y) * k / steps;
        count +=
            x > box.left && x < box.left + box.width && y > box.top && y < box.top + box.height;
      }
    }
  }
  return count;
}

/// Where the legend hides least.
Box legend_box(const Panel& panel, const View& view, double width, double height) {
  if (panel.legend_at) return in_corner(view.inner, *panel.legend_at, width, height);
  Box best;
  int least = -1;
  for (const Corner corner :
       {Corner::top_right, Corner::top_left, Corner::bottom_right, Corner::bottom_left}) {
    const Box box = in_corner(view.inner, corner, width, height);
    const int here = hidden(panel, view, box);
    if (least < 0 || here < least) best = box, least = here;
  }
  return best;
}

void draw_legend(Sheet& sheet, const Panel& panel, const View& view) {
  if (panel.legend.empty()) return;
  constexpr double kRow = 22, kSample = 28, kInset = 10;
  double width = 0;
  for (const LegendEntry& e : panel.legend) width = std::max(width, text_width(e.text, 14));
  width += kSample + 3 * kInset;
  const double height = kRow * double(panel.legend.size()) + kInset;
  const Box box = legend_box(panel, view, width, height);
  const double x = box.left;
  double y = box.top;
  sheet.area({{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}}, {ink::light, 1},
             ink::white.faint(0.9), true);
  for (const LegendEntry& e : panel.legend) {
    y += kRow;
    const double middle = y - 5, from = x + kInset;
    if (e.pen) sheet.line({{from, middle}, {from + kSample, middle}}, *e.pen);
    if (e.dot) sheet.put(Spots{{{from + kSample / 2, middle}}, 4, *e.dot});
    sheet.words({{from + kSample + kInset, y}, e.text, Anchor::start, 14});
  }
}

}  // namespace

std::vector<Point> points_of(const Mark& mark) {
  struct Visitor {
    std::vector<Point> operator()(const Picture& m) const {
      const auto [x, y] = m.low;
      const double right = x + m.pixel * m.image.width, top = y + m.pixel * m.image.height;
      return {{x, y}, {right, y}, {right, top}, {x, top}};
    }
    std::vector<Point> operator()(const Polyline& m) const { return m.points; }
    std::vector<Point> operator()(const Dots& m) const { return m.at; }
    std::vector<Point> operator()(const Ellipse& m) const { return corners(m); }
    std::vector<Point> operator()(const Arrow& m) const { return {m.from, m.to}; }
    std::vector<Point> operator()(const Label& m) const { return {m.at}; }
  };
  return std::visit(Visitor{}, mark);
}

Ellipse circle(Point centre, double radius, Pen pen, std::optional<Colour> fill) {
  return {centre, radius, radius, 0, pen, fill};
}

Ellipse covariance_ellipse(const Vec2& mean, const Eigen::Matrix2d& covariance, Pen pen,
                           double chi2) {
  const double a = covariance(0, 0), b = covariance(0, 1), d = covariance(1, 1);
  const double middle = 0.5 * (a + d), spread = std::hypot(0.5 * (a - d), b);
  const auto axis = [&](double v) { return std::sqrt(std::max(0.0, chi2 * v)); };
  return {{mean.x(), mean.y()},
          axis(middle + spread),
          axis(middle - spread),
          0.5 * std::atan2(2 * b, a - d),
          pen,
          {}};
}

std::vector<Stroke> strokes_of(const Figure& figure) {
  const Box all{0, 0, figure.width, figure.height};
  Sheet sheet(all);
  if (!figure.title.empty())
    sheet.words({{figure.width / 2, 28}, figure.title, Anchor::middle, kTitle});
  for (const Panel& panel : figure.panels) {
    const View view(panel);
    sheet.clip(all);
    if (!panel.title.empty())
      sheet.words({{view.inner.left + view.inner.width / 2, panel.place.top + 22},
                   panel.title,
                   Anchor::middle,
                   kPanelTitle});
    if (panel.framed) draw_axes(sheet, panel, view);
    if (panel.framed) sheet.clip(view.inner);
    draw_marks(sheet, panel, view);
    sheet.clip(all);
    if (panel.framed) draw_frame(sheet, view.inner);
    draw_legend(sheet, panel, view);
  }
  return std::move(sheet.strokes);
}

}  // namespace majak::draw
