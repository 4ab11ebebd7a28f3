// SPDX-License-Identifier: Apache-2.0
// Figure 22b shows what it says: the laser sees as well far off as near by, the heading does not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/draw/thesis_figures.hpp"
#include "majak/sim/park.hpp"

namespace majak::draw {
namespace {

const Figure& the_figure() {
  static const Figure figure = figure_park({});
  return figure;
}

template <class T>
std::vector<T> marks_in(const Panel& panel) {
  std::vector<T> found;
  for (const Mark& mark : panel.marks)
    if (const auto* m = std::get_if<T>(&mark)) found.push_back(*m);
  return found;
}

bool same_colour(const Colour& a, const Colour& b) {
  return a.r == b.r && a.g == b.g && a.b == b.b;
}

std::vector<Point> line_of(const Panel& panel, const Colour& colour) {
  for (const Polyline& p : marks_in<Polyline>(panel))
    if (same_colour(p.pen.colour, colour)) return p.points;
  return {};
}

/// The value of an RMS line_of in the bin about a range.
double at(const std::vector<Point>& line_of, double range) {
  for (const Point& p : line_of)
    if (std::abs(p.x - range) < 1e-9) return p.y;
  return NAN;
}

TEST(FigurePark, RouteAndTrunksAreWhereTheyAre) {
  const Panel& map = the_figure().panels.at(0);
  const auto truth = line_of(map, ink::red), estimate = line_of(map, ink::green);
  ASSERT_EQ(truth.size(), estimate.size());
  ASSERT_GT(truth.size(), 250U);
  double mean = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    mean +=
        std::hypot(truth[i].x - estimate[i].x, truth[i].y - estimate[i].y) / double(truth.size());
  EXPECT_LT(mean, 0.66);  // 0.5 m in the thesis
  std::vector<double> errors;
  for (const Ellipse& e : marks_in<Ellipse>(map)) {
    if (!same_colour(e.pen.colour, ink::blue)) continue;
    double nearest = 1e9;
    for (const sim::Disc& disc : sim::park().discs)
      nearest =
          std::min(nearest, std::hypot(disc.centre.x() - e.centre.x, disc.centre.y() - e.centre.y));
    errors.push_back(nearest);
  }
  EXPECT_GT(errors.size(), 100U);
  double sum = 0;
  for (const double e : errors) sum += e;
  EXPECT_LT(sum / double(errors.size()), 0.25);
  EXPECT_GT(marks_in<Dots>(map).at(0).at.size(), 1600U);
}

TEST(FigurePark, FarSightingsErrByTheHeading) {
  const auto along = line_of(the_figure().panels.at(2), ink::blue);
  const Panel& across = the_figure().panels.at(3);
  const auto all = line_of(across, ink::blue), heading = line_of(across, ink::green),
             laser = line_of(across, ink::orange);
  EXPECT_LT(at(along, 42.5), 0.04);
  EXPECT_GT(at(all, 42.5), 8 * at(along, 42.5));
  EXPECT_GT(at(heading, 42.5), at(laser, 42.5));
  EXPECT_GT(at(heading, 42.5), 3 * at(heading, 7.5));
  EXPECT_LT(at(laser, 42.5), 0.1);
  // They know nothing of each other: squares add up.
  for (const double range : {12.5, 22.5, 32.5, 42.5})
    EXPECT_NEAR(std::hypot(at(heading, range), at(laser, range)), at(all, range),
                0.1 * at(all, range));
}

TEST(FigurePark, LinesAreTheRootMeanSquareOfTheDots) {
  for (const std::size_t k : {2U, 3U}) {
    const Panel& panel = the_figure().panels.at(k);
    const auto dots = marks_in<Dots>(panel).at(0).at;
    for (const Point& d : dots) {  // all are seen
      ASSERT_LT(d.y, *panel.y.high);
      ASSERT_LT(d.x, *panel.x.high);
    }
    for (const Point& p : line_of(panel, ink::blue)) {
      double sum = 0, count = 0;
      for (const Point& d : dots)
        if (std::abs(d.x - p.x) <= 2.5) sum += d.y * d.y, ++count;
      EXPECT_NEAR(p.y, std::sqrt(sum / count), 1e-6);
    }
  }
}

}  // namespace
}  // namespace majak::draw
