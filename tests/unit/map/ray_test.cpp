// SPDX-License-Identifier: Apache-2.0
#include "majak/map/ray.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::map {
namespace {

using Cell = std::pair<int, int>;

constexpr std::ptrdiff_t kPitch = 1 << 20;

std::vector<Cell> walk(SubCellPoint a, SubCellPoint b) {
  std::vector<Cell> cells;
  for_each_cell(a, b, kPitch, [&](std::ptrdiff_t offset) {
    const auto y = static_cast<int>((offset + kPitch / 2) >> 20);
    cells.emplace_back(static_cast<int>(offset - y * kPitch), y);
  });
  return cells;
}

SubCellPoint at(double x, double y) { return {to_sub_cells(x), to_sub_cells(y)}; }

/// Length of the segment a-b inside [x, x+1] x [y, y+1], as a share of its whole; negative when it
/// misses the square. Clipping after Liang and Barsky.
double share_inside(SubCellPoint a, SubCellPoint b, Cell cell, double margin) {
  const auto cells = [](std::int64_t sub) {
    return static_cast<double>(sub) / static_cast<double>(kSubCells);
  };
  const double p[2] = {cells(a.x), cells(a.y)}, d[2] = {cells(b.x - a.x), cells(b.y - a.y)};
  const double low[2] = {cell.first - margin, cell.second - margin};
  double enter = 0, leave = 1;
  for (int k = 0; k < 2; ++k) {
    const double high = low[k] + 1 + 2 * margin;
    if (d[k] == 0) {
      if (p[k] < low[k] || p[k] > high) return -1;
      continue;
    }
    const double t0 = (low[k] - p[k]) / d[k], t1 = (high - p[k]) / d[k];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return leave - enter;
}

void expect_same_as_brute_force(SubCellPoint a, SubCellPoint b) {
  const std::vector<Cell> walked = walk(a, b);
  const std::set<Cell> cells(walked.begin(), walked.end());
  for (const Cell& cell : cells) {
    EXPECT_GE(share_inside(a, b, cell, 1e-6), 0)
        << cell.first << ' ' << cell.second << " is not crossed";
  }
  const auto [x0, x1] = std::minmax({cell_of(a.x), cell_of(b.x)});
  const auto [y0, y1] = std::minmax({cell_of(a.y), cell_of(b.y)});
  const double length = std::hypot(static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y)) /
                        static_cast<double>(kSubCells);
  for (int y = y0 - 1; y <= y1 + 1; ++y) {
    for (int x = x0 - 1; x <= x1 + 1; ++x) {
      if (share_inside(a, b, {x, y}, 0) * length > 1e-6) {
        EXPECT_TRUE(cells.contains({x, y})) << x << ' ' << y << " is missed";
      }
    }
  }
}

TEST(Ray, StaysInOneCell) {
  const std::vector<Cell> cells = walk(at(3.2, -1.4), at(3.7, -1.9));
  EXPECT_EQ(std::set<Cell>(cells.begin(), cells.end()), (std::set<Cell>{{3, -2}}));
}

TEST(Ray, GoesStraightAlongAnAxis) {
  for (const auto& [a, b] :
       {std::pair(at(-1.5, 0.5), at(2.5, 0.5)), std::pair(at(2.5, 0.5), at(-1.5, 0.5))}) {
    const std::vector<Cell> cells = walk(a, b);
    EXPECT_EQ(std::set<Cell>(cells.begin(), cells.end()),
              (std::set<Cell>{{-1 - 1, 0}, {-1, 0}, {0, 0}, {1, 0}, {2, 0}}));
  }
}

TEST(Ray, VisitsTheCellsOfAShallowLineInOrder) {
  // y = x / 4 from 0.5: borders at x = 1, 2 ...; the row changes inside column 2.
  std::vector<Cell> cells = walk(at(0.5, 0.5), at(4.5, 1.5));
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  EXPECT_EQ(cells, (std::vector<Cell>{{0, 0}, {1, 0}, {2, 0}, {2, 1}, {3, 1}, {4, 1}}));
}

TEST(Ray, AgreesWithBruteForceInEveryOctant) {
  RandomStream random(1);
  for (int i = 0; i < 2000; ++i) {
    const double reach = i % 2 ? 3.0 : 25.0;
    const SubCellPoint a = at(random.uniform(-reach, reach), random.uniform(-reach, reach));
    const SubCellPoint b = at(random.uniform(-reach, reach), random.uniform(-reach, reach));
    expect_same_as_brute_force(a, b);
    if (HasFailure()) return;
  }
}

TEST(Ray, AgreesWithBruteForceOnCornersDiagonalsAndBorders) {
  const std::vector<double> nasty = {-2, -1.5, -1, -1e-3, 0, 1e-9, 0.5, 1, 1.5, 2};
  for (const double ax : nasty) {
    for (const double ay : nasty) {
      for (const double bx : nasty) {
        for (const double by : nasty) expect_same_as_brute_force(at(ax, ay), at(bx, by));
      }
    }
  }
}

TEST(Ray, LeavesNoCellOfALongLineOut) {
  RandomStream random(2);
  for (int i = 0; i < 20; ++i) {
    const SubCellPoint a = at(0.3, 0.7),
                       b = at(random.uniform(-9000, 9000), random.uniform(-9000, 9000));
    std::vector<Cell> cells = walk(a, b);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    // Without gaps: from one border to the next, or through a corner.
    for (std::size_t k = 1; k < cells.size(); ++k) {
      const int step = std::abs(cells[k].first - cells[k - 1].first) +
                       std::abs(cells[k].second - cells[k - 1].second);
      ASSERT_EQ(step, 1) << "at " << k;
    }
    for (const Cell& cell : cells) ASSERT_GE(share_inside(a, b, cell, 1e-5), 0);
    const Cell goal{cell_of(b.x), cell_of(b.y)};
    EXPECT_TRUE(cells.back() == goal || cells.front() == goal);
  }
}

}  // namespace
}  // namespace majak::map
