// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/svg.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/core/random.hpp"

namespace majak::draw {
namespace {

TEST(Number, HasNoIdleDigits) {
  EXPECT_EQ(number(1.5), "1.5");
  EXPECT_EQ(number(2.0), "2");
  EXPECT_EQ(number(-0.25), "-0.25");
  EXPECT_EQ(number(100, 0), "100");
  EXPECT_EQ(number(1e6, 3), "1000000");
  EXPECT_EQ(number(0.126, 2), "0.13");
}

TEST(Number, IsNeverMinusZeroAndNeverNone) {
  EXPECT_EQ(number(-0.0), "0");
  EXPECT_EQ(number(-0.001), "0");
  EXPECT_EQ(number(-0.4, 0), "0");
  EXPECT_EQ(number(std::numeric_limits<double>::quiet_NaN()), "0");
  EXPECT_EQ(number(-std::numeric_limits<double>::infinity()), "0");
}

TEST(Grouped, SplitsThousands) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(13631), "13&#8239;631");
  EXPECT_EQ(grouped(-1000000), "-1&#8239;000&#8239;000");
}

TEST(Escape, LeavesNoMarkup) {
  EXPECT_EQ(escape("<script>&\"'x"), "&lt;script&gt;&amp;&quot;&#39;x");
  EXPECT_EQ(escape(std::string_view("a\0b\tc\nd", 7)), "a b c\nd");
}

TEST(Base64, FollowsRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

TEST(PathData, JoinsPoints) {
  EXPECT_EQ(path_data({}), "");
  EXPECT_EQ(path_data({{1, 2}}), "M1 2");
  EXPECT_EQ(path_data({{1, 2}, {-3.25, 4.04}}), "M1 2L-3.2 4");
}

double distance(Point p, Point a, Point b) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 1000; ++i) {
    const double t = i / 1000.0;
    best = std::min(best, std::hypot(p.x - a.x - t * (b.x - a.x), p.y - a.y - t * (b.y - a.y)));
  }
  return best;
}

TEST(Simplify, KeepsEveryPointNearTheLine) {
  RandomStream random(4);
  std::vector<Point> points = {{0, 0}};
  double heading = 0;
  for (int i = 0; i < 400; ++i) {
    heading += 0.2 * random.normal();
    points.push_back({points.back().x + std::cos(heading), points.back().y + std::sin(heading)});
  }
  for (const double tolerance : {0.1, 1.0, 5.0}) {
    const std::vector<Point> kept = simplify(points, tolerance);
    EXPECT_EQ(kept.front(), points.front());
    EXPECT_EQ(kept.back(), points.back());
    EXPECT_LT(kept.size(), points.size());
    std::size_t k = 0;
    for (const Point& p : points) {
      if (k + 1 < kept.size() && p == kept[k + 1]) ++k;
      if (k + 1 == kept.size()) continue;
      EXPECT_LE(distance(p, kept[k], kept[k + 1]), tolerance * 1.01 + 0.01);
    }
  }
}

TEST(Simplify, StraightensStraightLines) {
  std::vector<Point> line;
  for (int i = 0; i <= 50; ++i) line.push_back({0.1 * i, 0.3 * i});
  EXPECT_EQ(simplify(line, 1e-9).size(), 2U);
  EXPECT_EQ(simplify({}, 1).size(), 0U);
  EXPECT_EQ(simplify({{1, 1}}, 1).size(), 1U);
}

TEST(Simplify, KeepsALoopThatReturnsToItsStart) {
  const std::vector<Point> loop = {{0, 0}, {5, 0}, {5, 5}, {0, 5}, {0, 0}};
  EXPECT_EQ(simplify(loop, 0.5), loop);
}

}  // namespace
}  // namespace majak::draw
