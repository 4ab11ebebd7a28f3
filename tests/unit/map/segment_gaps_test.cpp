// SPDX-License-Identifier: Apache-2.0
#include "majak/map/segment_gaps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace majak::map {
namespace {

constexpr double kCell = 0.1;

/// One row of cells at y = 0 ... 0.1: '#' occupied, '.' free, ' ' unknown; free rows beside it.
OccupancyGrid row(const std::string& cells) {
  OccupancyGrid grid(kCell);
  for (int x = 0; x < static_cast<int>(cells.size()); ++x) {
    for (const int y : {-2, -1, 1, 2}) grid.set_log_odds(x, y, -2);
    const char c = cells[static_cast<std::size_t>(x)];
    if (c != ' ') grid.set_log_odds(x, 0, c == '#' ? 2 : -2);
  }
  return grid;
}

Segment along(double length) {
  Segment s;
  s.a = {0, 0.05}, s.b = {length, 0.05};
  s.covariance << 1e-4, 0, 0, 1e-4;
  s.sigma_a = s.sigma_b = 0.01;
  s.points = 200;
  return s;
}

std::vector<Segment> cut(const std::string& cells, double gap = 0.3) {
  return without_gaps({along(kCell * static_cast<double>(cells.size()))}, row(cells), gap, 0.1);
}

TEST(WithoutGaps, AWholeWallStaysAsItIs) {
  const auto parts = cut("####################");
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(parts[0].b.x(), 2);
  EXPECT_EQ(parts[0].sigma_b, 0.01);
  EXPECT_EQ(parts[0].points, 200U);
}

// Cells beside an occupied one are no gap, so that a gap is a cell shorter at each end.
TEST(WithoutGaps, AWindowIsTakenOut) {
  const auto parts = cut("######........######");
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].a.x(), 0);
  EXPECT_NEAR(parts[0].b.x(), 0.7, 1e-9);
  EXPECT_NEAR(parts[1].a.x(), 1.3, 1e-9);
  EXPECT_EQ(parts[1].b.x(), 2);
  EXPECT_EQ(parts[0].points, 70U);
  EXPECT_EQ(parts[0].sigma_a, 0.01);
  EXPECT_NEAR(parts[0].sigma_b, 0.1 / std::sqrt(3.0), 1e-9);
  // A metre and a bit from where it was stated, the turn's error tells.
  EXPECT_NEAR(parts[0].covariance(0, 0), 1e-4 * (1 + 0.65 * 0.65), 1e-9);
  EXPECT_NEAR(parts[0].covariance(0, 1), -1e-4 * 0.65, 1e-9);
}

TEST(WithoutGaps, SmallGapsAndTheUnknownStay) {
  EXPECT_EQ(cut("######....##########").size(), 1U);
  EXPECT_EQ(cut("######        ######").size(), 1U);
  EXPECT_EQ(cut("######........######", 0.7).size(), 1U);
}

TEST(WithoutGaps, EndsAreCutToo) {
  const auto parts = cut("........####........");
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].a.x(), 0.7, 1e-9);
  EXPECT_NEAR(parts[0].b.x(), 1.3, 1e-9);
}

TEST(WithoutGaps, NothingIsLeftOfWhatIsAllOpen) {
  EXPECT_TRUE(cut("....................").empty());
  EXPECT_TRUE(without_gaps({}, row("##"), 0.3, 0.1).empty());
}

TEST(WithoutGaps, NeitherFrameNorDirectionMatters) {
  Segment s = along(2);
  std::swap(s.a, s.b);
  const auto parts = without_gaps({s}, row("######........######"), 0.3, 0.1);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_NEAR(parts[0].b.x(), 1.3, 1e-9);
  EXPECT_NEAR(parts[1].a.x(), 0.7, 1e-9);
}

}  // namespace
}  // namespace majak::map
