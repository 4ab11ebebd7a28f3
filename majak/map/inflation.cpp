// SPDX-License-Identifier: Apache-2.0
#include "majak/map/inflation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

constexpr double kSameRadius = 1e-12;   // share of it
constexpr double kSameCell = 1e-9;      // cells
constexpr double kLongestReach = 5000;  // cells
constexpr int kRows = 32;               // rows of one piece of work

/// body(y) for every row, some at a time.
template <class Body>
void for_rows(Threads threads, int height, const Body& body) {
  const int pieces = (height + kRows - 1) / kRows;
  parallel_for(threads, static_cast<std::size_t>(pieces), [&](std::size_t k) {
    const int begin = static_cast<int>(k) * kRows;
    for (int y = begin; y < std::min(begin + kRows, height); ++y) body(y);
  });
}

// How many cells to either side, its own included, a marked cell blocks `dy` rows off; up to the
// first 0.
std::vector<int> half_widths(double radius_cells, InflationMeaning meaning, int width, int height) {
  // In quarters of a squared cell, where both meanings count in integers.
  const double limit = 4 * radius_cells * radius_cells * (1 - kSameRadius);
  const auto off = [meaning](std::int64_t d) {
    return meaning == InflationMeaning::centre ? 2 * d : std::max<std::int64_t>(2 * d - 1, 0);
  };
  const auto blocks = [&](std::int64_t dx, std::int64_t dy) {
    return (dx == 0 && dy == 0) ||
           static_cast<double>(off(dx) * off(dx) + off(dy) * off(dy)) < limit;
  };
  std::vector<int> widths;
  int n = static_cast<int>(std::min<double>(width, std::ceil(radius_cells) + 2));
  for (int dy = 0; dy < height && n > 0; ++dy) {
    while (n > 0 && !blocks(n - 1, dy)) --n;
    widths.push_back(n);
  }
  if (widths.empty() || widths.back() != 0) widths.push_back(0);
  return widths;
}

// Each cell blocks widths[its column's distance] cells to either side, its own included.
void block_row(const std::uint16_t* column, int width, const int* widths, std::uint8_t* row) {
  int left = 0;  // cells still to be blocked
  for (int x = 0; x < width; ++x) {
    left = std::max(left - 1, widths[column[x]]);
    row[x] = left > 0;
  }
  left = 0;
  for (int x = width - 1; x >= 0; --x) {
    left = std::max(left - 1, widths[column[x]]);
    row[x] |= static_cast<std::uint8_t>(left > 0);
  }
}

CellMask inflate_disc(const CellMask& obstacles, double radius_cells, InflationMeaning meaning,
                      Threads threads) {
  const std::vector<int> widths =
      half_widths(radius_cells, meaning, obstacles.width, obstacles.height);
  // Of a column only its nearest obstacle counts: farther ones block less of the row.
  const auto columns = column_distances(obstacles, static_cast<int>(widths.size()) - 1, threads);
  CellMask blocked{obstacles.width, obstacles.height,
                   std::vector<std::uint8_t>(obstacles.cells.size())};
  for_rows(threads, blocked.height, [&](int y) {
    block_row(columns.get() + blocked.index(0, y), blocked.width, widths.data(),
              blocked.cells.data() + blocked.index(0, y));
  });
  return blocked;
}

/// Cells [begin, end) of a row.
struct Run {
  int begin, end;
};

template <class Marked>
std::vector<Run> runs_of(int begin, int end, const Marked& marked) {
  std::vector<Run> runs;
  for (int x = begin; x < end; ++x) {
    if (!marked(x)) continue;
    const int first = x;
    while (x < end && marked(x)) ++x;
    runs.push_back({first, x});
  }
  return runs;
}

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Corners in cells about the robot's point, its heading applied.
class PolygonInCells {
 public:
  explicit PolygonInCells(std::vector<Vec2> corners) : corners_(std::move(corners)) {}

  bool holds_middle(const Vec2& p) const { return even_odd(p) && !meets_border(p, kSameCell); }
  // Sharing area: the border runs through the square, or the square lies within.
  bool meets_square(const Vec2& p) const { return meets_border(p, 0.5 - kSameCell) || even_odd(p); }

 private:
  const Vec2& before(std::size_t i) const { return corners_[i == 0 ? corners_.size() - 1 : i - 1]; }

  bool even_odd(const Vec2& p) const {
    bool within = false;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const Vec2 a = corners_[i] - p, b = before(i) - p;
      if ((a.y() > 0) != (b.y() > 0) && (cross(a, b) > 0) == (b.y() > a.y())) within = !within;
    }
    return within;
  }

  // Does a side run through the square of half a side `half` about p? No axis parts them: x, y and
  // the side's normal are enough.
  bool meets_border(const Vec2& p, double half) const {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const Vec2 middle = 0.5 * (corners_[i] + before(i)) - p;
      const Vec2 along = 0.5 * (corners_[i] - before(i));
      const double x = std::abs(along.x()), y = std::abs(along.y());
      if (std::abs(middle.x()) < half + x && std::abs(middle.y()) < half + y &&
          std::abs(cross(along, middle)) < half * (x + y))
        return true;
    }
    return false;
  }

  std::vector<Vec2> corners_;
};

/// Where obstacles block a robot: cells off its own, row by row from row -reach.
struct Offsets {
  int reach;
  std::vector<std::vector<Run>> rows;
};

Offsets offsets_of(const Polygon& polygon, double resolution, InflationMeaning meaning,
                   int longest) {
  const Pose2 turn{0, 0, *polygon.heading};
  std::vector<Vec2> corners;
  double farthest = 0;
  for (const Vec2& corner : polygon.corners) {
    corners.push_back(turn * corner / resolution);
    farthest = std::max(farthest, corners.back().cwiseAbs().maxCoeff());
  }
  const PolygonInCells cells(std::move(corners));
  Offsets offsets{static_cast<int>(std::min<double>(longest, std::ceil(farthest) + 1)), {}};
  for (int dy = -offsets.reach; dy <= offsets.reach; ++dy)
    offsets.rows.push_back(runs_of(-offsets.reach, offsets.reach + 1, [&](int dx) {
      return (dx == 0 && dy == 0) ||
             (meaning == InflationMeaning::centre ? cells.holds_middle(Vec2(dx, dy))
                                                  : cells.meets_square(Vec2(dx, dy)));
    }));
  return offsets;
}

CellMask inflate_polygon(const CellMask& obstacles, const Offsets& offsets, Threads threads) {
  const int width = obstacles.width, height = obstacles.height;
  std::vector<std::vector<Run>> rows(static_cast<std::size_t>(height));
  for_rows(threads, height, [&](int y) {
    const std::uint8_t* row = obstacles.cells.data() + obstacles.index(0, y);
    rows[y] = runs_of(0, width, [row](int x) { return row[x] != 0; });
  });
  CellMask blocked{width, height, std::vector<std::uint8_t>(obstacles.cells.size())};
  for_rows(threads, height, [&](int y) {
    // How many more runs of blocked cells there are than one cell before.
    std::vector<int> change(static_cast<std::size_t>(width) + 1);
    const int low = std::max(-offsets.reach, -y), high = std::min(offsets.reach, height - 1 - y);
    for (int dy = low; dy <= high; ++dy)
      for (const Run& offset : offsets.rows[dy + offsets.reach])
        for (const Run& obstacle : rows[y + dy]) {
          const int begin = std::max(0, obstacle.begin - offset.end + 1);
          const int end = std::min(width, obstacle.end - offset.begin);
          if (begin < end) ++change[begin], --change[end];
        }
    std::uint8_t* row = blocked.cells.data() + blocked.index(0, y);
    int count = 0;
    for (int x = 0; x < width; ++x) row[x] = (count += change[x]) > 0;
  });
  return blocked;
}

double circumscribed(const Polygon& polygon) {
  double radius = 0;
  for (const Vec2& corner : polygon.corners) radius = std::max(radius, corner.norm());
  return radius;
}

void check(const Footprint& footprint, double resolution) {
  if (!(resolution > 0) || !std::isfinite(resolution))
    throw Error("inflation: the resolution must be above 0 m");
  if (const auto* disc = std::get_if<Disc>(&footprint)) {
    if (!(disc->radius >= 0) || !std::isfinite(disc->radius))
      throw Error("inflation: the radius must be 0 m or more");
    return;
  }
  const auto& polygon = std::get<Polygon>(footprint);
  if (polygon.corners.size() < 3) throw Error("inflation: a polygon has three corners or more");
  const bool finite = std::all_of(polygon.corners.begin(), polygon.corners.end(),
                                  [](const Vec2& corner) { return corner.allFinite(); });
  if (!finite || !std::isfinite(polygon.heading.value_or(0)))
    throw Error("inflation: corners and heading must be finite");
}

// The map's obstacles within `margin` more cells around.
CellMask obstacles_of(const KnownMap& map, bool unknown, int margin) {
  CellMask mask{map.width + 2 * margin, map.height + 2 * margin, {}};
  mask.cells.assign(mask.index(0, mask.height), 1);
  for (int y = 0; y < map.height; ++y) {
    const CellState* row = map.cells.data() + map.index(0, y);
    std::transform(row, row + map.width, mask.cells.data() + mask.index(margin, y + margin),
                   [unknown](CellState state) {
                     return static_cast<std::uint8_t>(state == CellState::occupied ||
                                                      (unknown && state == CellState::unknown));
                   });
  }
  return mask;
}

// Of all that lies outside a map, so many cells around it are enough: the next ones for a disc, for
// none is nearer, and all that a polygon can reach.
int needed_margin(const Footprint& footprint, double resolution) {
  const auto* polygon = std::get_if<Polygon>(&footprint);
  if (polygon == nullptr || !polygon->heading) return 1;
  const double reach = std::ceil(circumscribed(*polygon) / resolution) + 1;
  if (reach > kLongestReach) throw Error("inflation: the polygon reaches farther than 5000 cells");
  return static_cast<int>(reach);
}

CellMask without_margin(const CellMask& mask, int margin) {
  CellMask inner{mask.width - 2 * margin, mask.height - 2 * margin, {}};
  for (int y = 0; y < inner.height; ++y) {
    const auto row = mask.cells.begin() + mask.index(margin, y + margin);
    inner.cells.insert(inner.cells.end(), row, row + inner.width);
  }
  return inner;
}

}  // namespace

CellMask inflate(const CellMask& obstacles, double resolution, const Footprint& footprint,
                 InflationMeaning meaning, Threads threads) {
  check(footprint, resolution);
  require_valid(obstacles);
  const auto* polygon = std::get_if<Polygon>(&footprint);
  if (polygon == nullptr || !polygon->heading) {
    const double radius =
        polygon == nullptr ? std::get<Disc>(footprint).radius : circumscribed(*polygon);
    return inflate_disc(obstacles, radius / resolution, meaning, threads);
  }
  const int longest = std::max(obstacles.width, obstacles.height);
  return inflate_polygon(obstacles, offsets_of(*polygon, resolution, meaning, longest), threads);
}

CellMask inflate(const KnownMap& map, const Footprint& footprint, const InflationOptions& options,
                 Threads threads) {
  check(footprint, map.resolution);
  if (!options.unknown_blocks)
    return inflate(obstacles_of(map, false, 0), map.resolution, footprint, options.meaning,
                   threads);
  const int margin = needed_margin(footprint, map.resolution);
  return without_margin(
      inflate(obstacles_of(map, true, margin), map.resolution, footprint, options.meaning, threads),
      margin);
}

}  // namespace majak::map
