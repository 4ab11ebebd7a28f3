// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/comparison_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace majak::draw {
namespace {

constexpr double kWallStep = 0.08, kThin = 0.03;     // m
constexpr double kGap = 1.5;                         // m between poses that are not joined
constexpr double kRow = 25, kMargins = 46;           // points, of a row and around the rows
constexpr double kBars = 0.30, kLongest = 0.42;      // where bars begin, and how long they grow
constexpr double kThick = 0.3;                       // half of a bar, in rows
constexpr double kBarsWidth = 480, kMapWidth = 760;  // points
constexpr Colour kInks[] = {ink::blue, ink::red, ink::green, ink::orange, ink::purple, ink::sky};

Colour ink_of(const std::string& method, std::size_t k) {
  return method == "dead-reckoning" ? ink::grey : kInks[k % std::size(kInks)];
}

// ---- Paths -------------------------------------------------------------------------------------

/// The map's box, with the truth; paths that leave it are cut.
void fit_axes(Panel& panel, const ComparisonPicture& p) {
  const auto take = [&](double x, double y) {
    panel.x.low = std::min(panel.x.low.value_or(x), x - 1);
    panel.x.high = std::max(panel.x.high.value_or(x), x + 1);
    panel.y.low = std::min(panel.y.low.value_or(y), y - 1);
    panel.y.high = std::max(panel.y.high.value_or(y), y + 1);
  };
  for (const Vec2& wall : p.walls) take(wall.x(), wall.y());
  for (const eval::StampedPose& t : p.truth) take(t.pose.x, t.pose.y);
}

Dots walls_of(const std::vector<Vec2>& walls) {
  std::set<std::pair<long, long>> seen;
  Dots dots{{}, 0.8, ink::grey};
  for (const Vec2& p : walls)
    if (seen.insert({std::lround(p.x() / kWallStep), std::lround(p.y() / kWallStep)}).second)
      dots.at.push_back({p.x(), p.y()});
  return dots;
}

/// Pieces of the path where the method did not say that it is lost, and did not leap.
void add_path(Panel& panel, const std::vector<Estimate>& estimates, const Pen& pen) {
  std::vector<Point> piece;
  const auto finish = [&] {
    if (piece.size() > 1) panel.marks.push_back(Polyline{simplify(piece, kThin), pen});
    piece.clear();
  };
  for (const Estimate& e : estimates) {
    const Point at{e.T_map_robot.x, e.T_map_robot.y};
    if (e.health == Health::lost) {
      finish();
      continue;
    }
    if (!piece.empty() && std::hypot(at.x - piece.back().x, at.y - piece.back().y) > kGap) finish();
    piece.push_back(at);
  }
  finish();
}

Panel paths(const ComparisonPicture& p, const Box& place) {
  Panel panel{.place = place, .x = {"x (m)"}, .y = {"y (m)"}};
  fit_axes(panel, p);
  panel.marks.push_back(walls_of(p.walls));
  panel.legend.push_back({"the map", {}, ink::grey});
  const auto& methods = p.comparison.methods;
  for (std::size_t k = methods.size(); k-- > 0;) {  // the first on top
    const Pen pen{ink_of(methods[k].method, k), 1.6};
    add_path(panel, methods[k].estimates, pen);
    panel.legend.insert(panel.legend.begin() + 1, {methods[k].method, pen});
  }
  if (p.truth.empty()) return panel;
  std::vector<Point> truth;
  for (const eval::StampedPose& t : p.truth) truth.push_back({t.pose.x, t.pose.y});
  panel.marks.push_back(Polyline{simplify(truth, kThin), {ink::black, 1, 4}});
  panel.legend.push_back({"truth", Pen{ink::black, 1, 4}});
  return panel;
}

// ---- Bars --------------------------------------------------------------------------------------

struct Bar {
  double value = 0, more = 0;  ///< solid up to the one, faint up to the other; 0: no bar
  std::string words;
};

Polyline block(double from, double to, double row, const Colour& colour) {
  return {{{from, row - kThick}, {to, row - kThick}, {to, row + kThick}, {from, row + kThick}},
          {colour, 0},
          true,
          colour};
}

Label words(double x, double row, const std::string& text) {
  return {{x, row}, text, 0, -4.5, Anchor::start, 13};
}

/// One row a method, the first at the top.
Panel bar_panel(const std::string& title, const std::vector<eval::MethodResult>& methods,
                const Box& place) {
  Panel panel{.place = place,
              .title = title,
              .x = {"", 0, 1},
              .y = {"", -static_cast<double>(methods.size()) + 0.5, 0.5},
              .equal = false,
              .framed = false};
  for (std::size_t k = 0; k < methods.size(); ++k)
    panel.marks.push_back(words(0, -static_cast<double>(k), methods[k].method));
  return panel;
}

void add_bars(Panel& panel, const std::vector<eval::MethodResult>& methods,
              const std::vector<Bar>& bars) {
  double low = 1e300, high = 0;
  for (const Bar& b : bars)
    if (b.value > 0) low = std::min(low, b.value), high = std::max({high, b.value, b.more});
  const auto end = [&](double v) {
    return kBars + kLongest * std::log(3 * v / low) / std::log(3 * high / low);
  };
  for (std::size_t k = 0; k < bars.size(); ++k) {
    const double row = -static_cast<double>(k);
    const Colour colour = ink_of(methods[k].method, k);
    double last = kBars;
    if (bars[k].value > 0) {
      last = end(bars[k].value);
      panel.marks.push_back(block(kBars, last, row, colour));
    }
    if (bars[k].value > 0 && bars[k].more > bars[k].value) {
      panel.marks.push_back(block(last, end(bars[k].more), row, colour.faint(0.35)));
      last = end(bars[k].more);
    }
    panel.marks.push_back(words(last + 0.015, row, bars[k].words));
  }
}

void add_health(Panel& panel, const std::vector<eval::MethodResult>& methods) {
  for (std::size_t k = 0; k < methods.size(); ++k) {
    const double row = -static_cast<double>(k), length = kLongest,
                 n = static_cast<double>(methods[k].estimates.size());
    double from = kBars;
    const Colour colours[] = {ink::green, ink::orange, ink::red};
    for (int h = 0; h < 3; ++h) {
      const double to = from + length * static_cast<double>(methods[k].health[h]) / n;
      if (to > from) panel.marks.push_back(block(from, to, row, colours[h]));
      from = to;
    }
    const std::string wrong =
        methods[k].wrong ? fmt::format("{:.1f} % wrong", 100 * *methods[k].wrong) : "";
    panel.marks.push_back(words(from + 0.015, row, wrong));
  }
}

std::string bytes_text(std::size_t bytes) {
  const auto b = static_cast<double>(bytes);
  return b < 1e3   ? fmt::format("{:.0f} B", b)
         : b < 1e6 ? fmt::format("{:.3g} kB", b / 1e3)
                   : fmt::format("{:.3g} MB", b / 1e6);
}

std::string count_text(const std::optional<int>& count) {
  return count ? fmt::format("{}", *count) : "never";
}

std::string known_text(const eval::MethodResult& r) {
  std::string found = r.told ? "told where" : "found " + count_text(r.found);
  if (!r.recovery) return found;
  if (!r.recovery->knew) return found + "; not known before";
  return found + fmt::format("; lost {}, right {}", count_text(r.recovery->told_lost),
                             count_text(r.recovery->right_again));
}

/// All but the health.
std::vector<std::pair<std::string, std::vector<Bar>>> quantities(const eval::Comparison& c) {
  std::vector<Bar> error, time, memory, known;
  for (const eval::MethodResult& r : c.methods) {
    if (r.translation)
      error.push_back({r.translation->median, r.translation->p95,
                       fmt::format("{:.3g}, {:.3g}", r.translation->median, r.translation->p95)});
    else
      error.push_back({0, 0, "not known"});
    time.push_back({1e3 * r.cpu_mean, 0, fmt::format("{:.3g}", 1e3 * r.cpu_mean)});
    memory.push_back({static_cast<double>(r.belief_median), static_cast<double>(r.belief_most),
                      bytes_text(r.belief_median) + ", " + bytes_text(r.belief_most)});
    known.push_back({0, 0, known_text(r)});
  }
  return {{"error (m): median, 95 %", error},
          {"CPU time a scan (ms)", time},
          {"memory of the belief: median, at most", memory},
          {"updates until found; carried away: until lost, right", known}};
}

}  // namespace

Figure comparison_picture(const ComparisonPicture& p) {
  const auto& methods = p.comparison.methods;
  const double height = kRow * static_cast<double>(methods.size()) + kMargins;
  Figure figure{.width = kMapWidth + kBarsWidth,
                .height = 40 + std::max(640.0, 5 * height),
                .title = p.title};
  const Box whole = figure.whole();
  figure.panels.push_back(paths(p, {0, whole.top, kMapWidth, whole.height}));
  Box place{kMapWidth, whole.top, kBarsWidth, height};
  for (const auto& [title, bars] : quantities(p.comparison)) {
    Panel panel = bar_panel(title, methods, place);
    add_bars(panel, methods, bars);
    figure.panels.push_back(std::move(panel));
    place.top += height;
  }
  Panel health = bar_panel("scans: ok, degraded, lost; ok but wrong", methods, place);
  add_health(health, methods);
  figure.panels.push_back(std::move(health));
  return figure;
}

}  // namespace majak::draw
