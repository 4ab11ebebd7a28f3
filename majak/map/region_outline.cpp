// SPDX-License-Identifier: Apache-2.0
#include "majak/map/region_outline.hpp"

#include <map>
#include <utility>

namespace majak::map {
namespace {

// A corner of cells and the way on: 0 east, 1 north, 2 west, 3 south; the room lies to the left.
struct Edge {
  int x, y, way;
  auto operator<=>(const Edge&) const = default;
};
constexpr int kX[] = {1, 0, -1, 0}, kY[] = {0, 1, 0, -1};

}  // namespace

double polygon_area(const std::vector<Vec2>& points) {
  double twice = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 &a = points[i], &b = points[(i + 1) % points.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

std::vector<Vec2> region_outline(const Topology& t, int room) {
  const auto in = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < t.width && y < t.height &&
           t.labels[static_cast<std::size_t>(y) * t.width + x] == room;
  };
  std::map<Edge, bool> edges;  // done?
  for (const std::uint32_t cell : t.rooms[room].cells) {
    const int x = static_cast<int>(cell % t.width), y = static_cast<int>(cell / t.width);
    if (!in(x, y - 1)) edges[{x, y, 0}] = false;
    if (!in(x + 1, y)) edges[{x + 1, y, 1}] = false;
    if (!in(x, y + 1)) edges[{x + 1, y + 1, 2}] = false;
    if (!in(x - 1, y)) edges[{x, y + 1, 3}] = false;
  }
  std::vector<Vec2> best;
  double most = 0;
  for (auto& [first, done] : edges) {
    if (done) continue;
    std::vector<Vec2> loop;
    Edge edge = first;
    int before = -1;
    do {
      if (edge.way != before)
        loop.push_back({t.x0 + edge.x * t.resolution, t.y0 + edge.y * t.resolution});
      before = edge.way;
      edges[edge] = true;
      edge.x += kX[edge.way];
      edge.y += kY[edge.way];
      for (const int turn : {1, 0, 3}) {  // left first: cells that touch by a corner are two
        const Edge next{edge.x, edge.y, (before + turn) % 4};
        if (edges.contains(next)) {
          edge = next;
          break;
        }
      }
    } while (edge != first);
    if (loop.size() > 1 && before == first.way) loop.erase(loop.begin());
    const double area = polygon_area(loop);
    if (area > most) {
      most = area;
      best = std::move(loop);
    }
  }
  return best;
}

}  // namespace majak::map
