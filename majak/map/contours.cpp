// SPDX-License-Identifier: Apache-2.0
#include "majak/map/contours.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "majak/map/ray.hpp"

namespace majak::map {
namespace {

struct Cell {
  int x = 0, y = 0;
  bool operator==(const Cell&) const = default;
};

/// Directions along the borders between cells, counter-clockwise: right, up, left, down.
constexpr std::array<Cell, 4> kSteps = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
/// From the corner at which a border begins to the cell on its right and on its left.
constexpr std::array<Cell, 4> kRight = {{{0, -1}, {0, 0}, {-1, 0}, {-1, -1}}};
constexpr std::array<Cell, 4> kLeft = {{{0, 0}, {-1, 0}, {-1, -1}, {0, -1}}};

/// Borders with free on their left and occupied on their right, followed from one to the next.
class Borders {
 public:
  explicit Borders(const KnownMap& map) : map_(map) {
    for (int y = 0; y <= map.height; ++y)
      for (int x = 0; x <= map.width; ++x)
        for (int d = 0; d < 4; ++d)
          if (is_border({x, y}, d)) open_[number({x, y})] |= static_cast<std::uint8_t>(1 << d);
  }

  /// Occupied cells along each border, in order; a ring begins and ends with the same one.
  std::vector<std::vector<Cell>> chains() {
    std::vector<std::vector<Cell>> chains;
    for (const bool rings : {false, true})
      for (int y = 0; y <= map_.height; ++y)
        for (int x = 0; x <= map_.width; ++x)
          for (int d = 0; d < 4; ++d)
            if (is_open({x, y}, d) && (rings || !has_before({x, y}, d)))
              chains.push_back(follow({x, y}, d));
    return chains;
  }

 private:
  std::size_t number(const Cell& corner) const {
    return static_cast<std::size_t>(corner.y) * static_cast<std::size_t>(map_.width + 1) +
           static_cast<std::size_t>(corner.x);
  }
  bool is_border(const Cell& c, int d) const {
    const auto i = static_cast<std::size_t>(d);
    return map_.at(c.x + kLeft[i].x, c.y + kLeft[i].y) == CellState::free &&
           map_.at(c.x + kRight[i].x, c.y + kRight[i].y) == CellState::occupied;
  }
  bool is_open(const Cell& c, int d) const {
    const auto found = open_.find(number(c));
    return found != open_.end() && (found->second >> d & 1) != 0;
  }
  /// Does a border end where this one begins?
  bool has_before(const Cell& c, int d) const {
    for (int turn = -1; turn <= 1; ++turn) {
      const int e = (d + turn + 4) % 4;
      const Cell& step = kSteps[static_cast<std::size_t>(e)];
      if (is_open({c.x - step.x, c.y - step.y}, e)) return true;
    }
    return false;
  }
  std::vector<Cell> follow(Cell corner, int d) {
    std::vector<Cell> chain;
    while (true) {
      const auto i = static_cast<std::size_t>(d);
      open_[number(corner)] &= static_cast<std::uint8_t>(~(1 << d));
      const Cell wall{corner.x + kRight[i].x, corner.y + kRight[i].y};
      if (chain.empty() || !(chain.back() == wall)) chain.push_back(wall);
      corner = {corner.x + kSteps[i].x, corner.y + kSteps[i].y};
      // Around the same free cell first: walls hang together over corners, rooms do not.
      int next = -1;
      for (const int turn : {1, 0, 3})
        if (next < 0 && is_open(corner, (d + turn) % 4)) next = (d + turn) % 4;
      if (next < 0) return chain;
      d = next;
    }
  }

  const KnownMap& map_;
  std::unordered_map<std::size_t, std::uint8_t> open_;  // corner -> directions not yet followed
};

using Points = std::vector<Vec2>;

/// Ends of the straight parts of points[first ... last] (Douglas and Peucker 1973).
void split(const Points& points, std::size_t first, std::size_t last, double most,
           std::vector<std::size_t>& ends) {
  const Vec2 a = points[first], way = points[last] - a;
  const double length = way.norm();
  double farthest = most;
  std::size_t at = first;
  for (std::size_t i = first + 1; i < last; ++i) {
    const Vec2 p = points[i] - a;
    const double off = length > 0 ? std::abs(way.x() * p.y() - way.y() * p.x()) / length : p.norm();
    if (off > farthest) farthest = off, at = i;
  }
  if (at != first) {
    split(points, first, at, most, ends);
    split(points, at, last, most, ends);
  } else {
    ends.push_back(last);
  }
}

/// The line through points[first ... last] by total least squares. Its ends, which it shares with
/// its neighbours and which may lie round a corner, have no say in its
/// direction where there are others.
Segment fitted(const Points& points, std::size_t first, std::size_t last, double cell) {
  constexpr std::size_t kEnough = 5;
  const std::size_t ends[] = {first, last};
  if (last - first + 1 >= kEnough) ++first, --last;
  const auto n = static_cast<double>(last - first + 1);
  Vec2 mean = Vec2::Zero();
  for (std::size_t i = first; i <= last; ++i) mean += points[i] / n;
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (std::size_t i = first; i <= last; ++i)
    spread += (points[i] - mean) * (points[i] - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  Vec2 along = axes.eigenvectors().col(1);
  if (along.dot(points[last] - points[first]) < 0) along = -along;
  const double half = cell / 2, variance = cell * cell / 12;  // of a cell's middle
  const auto on_line = [&](std::size_t i) {
    return std::abs(Segment::left_of(along).dot(points[i] - mean)) <= half;
  };
  if (on_line(ends[0])) first = ends[0];
  if (on_line(ends[1])) last = ends[1];
  Segment s;
  s.a = mean + (along.dot(points[first] - mean) - half) * along;
  s.b = mean + (along.dot(points[last] - mean) + half) * along;
  s.covariance << variance / n, 0, 0, variance / std::max(axes.eigenvalues()(1), variance);
  s.sigma_a = s.sigma_b = std::sqrt(variance);
  s.points = last - first + 1;
  return s;
}

}  // namespace

std::vector<Segment> contour_segments(const KnownMap& map, const ContourOptions& options) {
  std::vector<Segment> segments;
  for (const std::vector<Cell>& chain : Borders(map).chains()) {
    Points points;
    for (const Cell& cell : chain) points.push_back(map.centre(cell.x, cell.y));
    std::vector<std::size_t> ends = {0};
    split(points, 0, points.size() - 1, options.split_cells * map.resolution, ends);
    for (std::size_t i = 1; i < ends.size(); ++i) {
      const Segment s = fitted(points, ends[i - 1], ends[i], map.resolution);
      if (ends[i] > ends[i - 1] && s.length() >= options.min_length) segments.push_back(s);
    }
  }
  return segments;
}

CellMask cells_of(const std::vector<Segment>& segments, const KnownMap& frame) {
  CellMask mask{frame.width, frame.height,
                std::vector<std::uint8_t>(static_cast<std::size_t>(frame.width) *
                                          static_cast<std::size_t>(frame.height))};
  const auto in_cells = [&](const Vec2& p) {
    return SubCellPoint{to_sub_cells((p.x() - frame.x0) / frame.resolution),
                        to_sub_cells((p.y() - frame.y0) / frame.resolution)};
  };
  constexpr std::ptrdiff_t kPitch = std::ptrdiff_t{1} << 32;  // no cell shares its number
  for (const Segment& s : segments)
    for_each_cell(in_cells(s.a), in_cells(s.b), kPitch, [&](std::ptrdiff_t at) {
      const int ix = static_cast<std::int32_t>(at & 0xffffffff);
      const int iy = static_cast<int>((at - ix) >> 32);
      if (mask.inside(ix, iy)) mask.cells[mask.index(ix, iy)] = 1;
    });
  return mask;
}

ConversionError conversion_error(const KnownMap& map, const std::vector<Segment>& segments) {
  const CellMask drawn = cells_of(segments, map);
  CellMask occupied{map.width, map.height, std::vector<std::uint8_t>(map.cells.size())};
  for (std::size_t i = 0; i < map.cells.size(); ++i)
    occupied.cells[i] = map.cells[i] == CellState::occupied;
  const auto from_drawn = squared_distances(drawn), from_occupied = squared_distances(occupied);
  std::int64_t walls = 0, missed = 0, lines = 0, added = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const std::size_t i = map.index(x, y);
      const bool seen = std::any_of(kSteps.begin(), kSteps.end(), [&](const Cell& step) {
        return map.at(x + step.x, y + step.y) == CellState::free;
      });
      if (occupied.cells[i] != 0 && seen) ++walls, missed += from_drawn[i] > 2;
      if (drawn.cells[i] != 0) ++lines, added += from_occupied[i] > 2;
    }
  const auto share = [](std::int64_t part, std::int64_t all) {
    return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : 0;
  };
  return {share(missed, walls), share(added, lines)};
}

}  // namespace majak::map
