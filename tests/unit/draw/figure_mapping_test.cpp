// SPDX-License-Identifier: Apache-2.0
// Figures 14, 15 and 17 show what they say: of mapping with and without closed loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/draw/stroke_font.hpp"
#include "majak/draw/thesis_figures.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/world.hpp"

namespace majak::draw {
namespace {

template <class T>
std::vector<T> marks_of(const Panel& panel) {
  std::vector<T> found;
  for (const Mark& mark : panel.marks)
    if (const auto* m = std::get_if<T>(&mark)) found.push_back(*m);
  return found;
}

double apart(const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Share of a map's cells that lie so near to a true surface.
double share_near_walls(const Panel& panel, const sim::World& world, double reach) {
  double near = 0, all = 0;
  for (const Dots& dots : marks_of<Dots>(panel))
    for (const Point& p : dots.at) {
      ++all;
      near += world.clearance({p.x, p.y}) < reach;
    }
  return near / all;
}

const Figure& the_ring() {
  static const Figure figure = figure_ring({});
  return figure;
}

TEST(FigureRing, EndsMeetOnlyWhereTheLoopIsClosed) {
  const Figure& figure = the_ring();
  ASSERT_EQ(figure.panels.size(), 4U);  // map and seam, incremental and hybrid
  const sim::World world(sim::bare_ring());
  const Vec2 start = world.scene().start.translation();
  double gaps[2];
  for (std::size_t k : {0, 1}) {
    const auto arrows = marks_of<Arrow>(figure.panels[2 * k + 1]);
    ASSERT_EQ(arrows.size(), 1U);
    EXPECT_LT(apart(arrows[0].from, {start.x(), start.y()}), 0.2);  // the lap is full
    gaps[k] = apart(arrows[0].from, arrows[0].to);
    // It leads to the believed way.
    double nearest = 1e9;
    for (const Polyline& line : marks_of<Polyline>(figure.panels[2 * k + 1]))
      if (line.points.size() > 2)
        for (std::size_t i = 1; i < line.points.size(); ++i) {
          const Point &a = line.points[i - 1], &b = line.points[i], &p = arrows[0].to;
          nearest = std::min(nearest, sim::distance_to({{a.x, a.y}, {b.x, b.y}}, {p.x, p.y}));
        }
    EXPECT_LT(nearest, 0.011);
  }
  EXPECT_GT(gaps[0], 0.5);
  EXPECT_LT(gaps[1], 0.02);
  EXPECT_LT(share_near_walls(figure.panels[0], world, 0.35), 0.95);
  EXPECT_GT(share_near_walls(figure.panels[2], world, 0.35), 0.99);
}

TEST(FigureRing, WordsKeepWithinTheRing) {
  const Figure& figure = the_ring();
  int words = 0;
  const Outline* room = nullptr;  // the white one, which keeps the grid out
  const std::vector<Stroke> strokes = strokes_of(figure);
  for (const Stroke& stroke : strokes) {
    const auto* o = std::get_if<Outline>(&stroke.what);
    if (o != nullptr && o->fill && o->fill->r == 255 && o->fill->alpha == 1) room = o;
    const auto* w = std::get_if<Words>(&stroke.what);
    if (w == nullptr || room == nullptr) continue;
    const Point &low = room->points[0], &high = room->points[2];
    if (w->at.y > low.y || w->at.y < high.y || w->at.x < low.x || w->at.x > high.x) continue;
    ++words;
    const double half = text_width(w->text, w->size) / 2;
    EXPECT_GT(w->at.x - half, low.x) << w->text;
    EXPECT_LT(w->at.x + half, high.x) << w->text;
    EXPECT_GT(w->at.y - w->size, high.y) << w->text;
  }
  EXPECT_EQ(words, 6);
}

TEST(FigureOffice, BothKeepTheBuildingTogetherAndParticlesSpreadBetweenLoops) {
  const Figure figure = figure_office({});
  ASSERT_EQ(figure.panels.size(), 3U);
  const auto lines =
      marks_of<Polyline>(figure.panels[2]);  // cm over m: incremental, hybrid, spread
  ASSERT_EQ(lines.size(), 3U);
  const auto worst = [](const Polyline& line) {
    return std::max_element(line.points.begin(), line.points.end(),
                            [](const Point& a, const Point& b) { return a.y < b.y; })
        ->y;
  };
  EXPECT_LT(worst(lines[0]), 20);
  EXPECT_LT(worst(lines[1]), 20);
  EXPECT_GT(worst(lines[2]), 10);
  EXPECT_LT(lines[2].points.back().y, 3);  // at home
  EXPECT_GT(lines[0].points.back().x, 250);
  const sim::World world(sim::building());
  for (const int k : {0, 1})
    EXPECT_GT(share_near_walls({.marks = {marks_of<Dots>(figure.panels[k])[0]}}, world, 0.3), 0.99);
  EXPECT_EQ(marks_of<Dots>(figure.panels[1]).size(), 3U);  // walls, particles, corrections
}

/// Where a mark of the first panel, whose units are points, stands on the sheet.
struct Frame {
  double left, top, right, bottom;
  bool holds(const Point& p) const {
    return p.x > left && p.x < right && p.y > top && p.y < bottom;
  }
};

TEST(FigureSlam, PicturesAndWordsKeepWithinTheirBoxes) {
  const Figure figure = figure_slam({});
  ASSERT_EQ(figure.panels.size(), 4U);
  std::vector<Frame> boxes;
  for (const Polyline& line : marks_of<Polyline>(figure.panels[0]))
    if (line.closed)
      boxes.push_back({line.points[0].x, figure.height - line.points[0].y, line.points[2].x,
                       figure.height - line.points[2].y});
  ASSERT_EQ(boxes.size(), 4U);
  std::vector<int> seen(4), words(4);
  const auto box_of = [&](const Point& p) {
    return std::find_if(boxes.begin(), boxes.end(), [&](const Frame& b) { return b.holds(p); }) -
           boxes.begin();
  };
  for (const Stroke& stroke : strokes_of(figure)) {
    if (const auto* w = std::get_if<Words>(&stroke.what)) {
      const auto box = box_of(w->at);
      if (box == 4) continue;
      ++words[box];
      const double half = text_width(w->text, w->size) / 2;
      EXPECT_GT(w->at.x - half, boxes[box].left + 5) << w->text;
      EXPECT_LT(w->at.x + half, boxes[box].right - 5) << w->text;
    }
    if (const auto* s = std::get_if<Spots>(&stroke.what)) {
      for (const Point& p : s->at) ASSERT_EQ(box_of(p), box_of(s->at[0]));
      ++seen[box_of(s->at[0])];
    }
    if (const auto* o = std::get_if<Outline>(&stroke.what); o != nullptr && o->points.size() > 40)
      for (const Point& p : o->points) ASSERT_EQ(box_of(p), box_of(o->points[0]));
  }
  EXPECT_EQ(words, (std::vector<int>{1, 2, 9, 2}));
  EXPECT_EQ(seen, (std::vector<int>{2, 0, 0, 1}));  // returns and laser; the map
}

}  // namespace
}  // namespace majak::draw
