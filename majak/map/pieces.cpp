// SPDX-License-Identifier: Apache-2.0
#include "majak/map/pieces.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/error.hpp"

namespace majak::map {
namespace {

constexpr int kLeastOccupied = 2;  // snapshots

int first_column(const KnownMap& map) {
  return static_cast<int>(std::lround(map.x0 / map.resolution));
}
int first_row(const KnownMap& map) {
  return static_cast<int>(std::lround(map.y0 / map.resolution));
}

bool near_occupied(const KnownMap& map, int ix, int iy, int reach) {
  for (int y = iy - reach; y <= iy + reach; ++y)
    for (int x = ix - reach; x <= ix + reach; ++x)
      if (map.at(x, y) == CellState::occupied) return true;
  return false;
}

/// As large as all snapshots together, all cells unknown.
KnownMap around(std::span<const KnownMap> snapshots) {
  KnownMap map;
  if (snapshots.empty()) return map;
  map.resolution = snapshots.front().resolution;
  int x0 = first_column(snapshots.front()), y0 = first_row(snapshots.front()), x1 = x0, y1 = y0;
  for (const KnownMap& s : snapshots) {
    const double off_x = s.x0 / s.resolution - first_column(s),
                 off_y = s.y0 / s.resolution - first_row(s);
    if (s.resolution != map.resolution || std::max(std::abs(off_x), std::abs(off_y)) > 1e-3)
      throw Error("snapshots do not share their lattice of cells");
    x0 = std::min(x0, first_column(s));
    y0 = std::min(y0, first_row(s));
    x1 = std::max(x1, first_column(s) + s.width);
    y1 = std::max(y1, first_row(s) + s.height);
  }
  map.x0 = x0 * map.resolution;
  map.y0 = y0 * map.resolution;
  map.width = x1 - x0;
  map.height = y1 - y0;
  map.cells.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height),
                   CellState::unknown);
  return map;
}

/// Connected groups of marked cells of `map`, which are unmarked on the way.
std::vector<std::vector<std::size_t>> groups(const KnownMap& map, std::vector<std::uint8_t>& marked,
                                             int reach) {
  std::vector<std::vector<std::size_t>> found;
  const auto width = static_cast<std::size_t>(map.width);
  for (std::size_t first = 0; first < marked.size(); ++first) {
    if (!marked[first]) continue;
    std::vector<std::size_t> group{first};
    marked[first] = 0;
    for (std::size_t next = 0; next < group.size(); ++next) {
      const int cx = static_cast<int>(group[next] % width),
                cy = static_cast<int>(group[next] / width);
      for (int y = cy - reach; y <= cy + reach; ++y)
        for (int x = cx - reach; x <= cx + reach; ++x) {
          if (!map.inside(x, y) || !marked[map.index(x, y)]) continue;
          marked[map.index(x, y)] = 0;
          group.push_back(map.index(x, y));
        }
    }
    std::sort(group.begin(), group.end());
    found.push_back(std::move(group));
  }
  return found;
}

double diagonal(const std::vector<Vec2>& points) {
  Vec2 low = points.front(), high = low;
  for (const Vec2& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

}  // namespace

void describe(OptionFields& fields, PieceOptions& o) {
  fields.add("pieces.margin", o.margin,
             {"m", "so near to a thing that stays nothing is told from it", 0, 1});
  fields.add("pieces.gap", o.gap, {"m", "cells that near are of one piece", 0.01, 2});
  fields.add("pieces.least_size", o.least_size, {"m", "smaller pieces are left out", 0, 10});
  fields.add("pieces.most_size", o.most_size, {"m", "larger pieces are left out", 0.1, 100});
  fields.add("pieces.least_cells", o.least_cells, {"1", "occupied cells of a piece", 1, 10000});
}

KnownMap still_map(std::span<const KnownMap> snapshots) {
  KnownMap still = around(snapshots);
  std::vector<int> occupied(still.cells.size()), free(still.cells.size());
  for (const KnownMap& s : snapshots) {
    const int dx = first_column(s) - first_column(still), dy = first_row(s) - first_row(still);
    for (int y = 0; y < s.height; ++y)
      for (int x = 0; x < s.width; ++x) {
        const std::size_t i = still.index(x + dx, y + dy);
        const CellState state = s.at(x, y);
        if (state == CellState::occupied) ++occupied[i];
        if (state == CellState::free && !near_occupied(s, x, y, 1)) ++free[i];
      }
  }
  for (std::size_t i = 0; i < still.cells.size(); ++i) {
    if (occupied[i] >= kLeastOccupied && occupied[i] >= 2 * free[i])
      still.cells[i] = CellState::occupied;
    else if (free[i] > 0)
      still.cells[i] = CellState::free;
  }
  return still;
}

std::vector<Piece> pieces_of(const KnownMap& still, const KnownMap& snapshot,
                             std::size_t snapshot_number, const PieceOptions& options) {
  const int margin = static_cast<int>(std::lround(options.margin / snapshot.resolution));
  const int gap = std::max(1, static_cast<int>(std::lround(options.gap / snapshot.resolution)));
  const int dx = first_column(snapshot) - first_column(still),
            dy = first_row(snapshot) - first_row(still);
  std::vector<std::uint8_t> marked(snapshot.cells.size());
  for (int y = 0; y < snapshot.height; ++y)
    for (int x = 0; x < snapshot.width; ++x)
      marked[snapshot.index(x, y)] = snapshot.at(x, y) == CellState::occupied &&
                                     still.at(x + dx, y + dy) == CellState::free &&
                                     !near_occupied(still, x + dx, y + dy, margin);
  std::vector<Piece> pieces;
  for (const auto& group : groups(snapshot, marked, gap)) {
    if (group.size() < static_cast<std::size_t>(options.least_cells)) continue;
    Piece piece{snapshot_number, {}};
    for (const std::size_t i : group)
      piece.points.push_back(snapshot.centre(static_cast<int>(i) % snapshot.width,
                                             static_cast<int>(i) / snapshot.width));
    const double size = diagonal(piece.points);
    if (size >= options.least_size && size <= options.most_size) pieces.push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace majak::map
