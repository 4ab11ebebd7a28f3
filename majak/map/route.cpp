// SPDX-License-Identifier: Apache-2.0
#include "majak/map/route.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "majak/map/distance_transform.hpp"

namespace majak::map {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// m from every free cell to the nearest that is not.
std::vector<float> clearances(const KnownMap& known) {
  CellMask walls{known.width, known.height, {}};
  for (const CellState s : known.cells) walls.cells.push_back(s != CellState::free);
  std::vector<float> clearance;
  for (const std::int32_t d : squared_distances(walls))
    clearance.push_back(static_cast<float>((std::sqrt(d) - 0.5) * known.resolution));
  return clearance;
}

class Search {
 public:
  Search(const KnownMap& known, const RouteOptions& o)
      : known_(known), options_(o), clearance_(clearances(known)) {}

  bool passable(int ix, int iy) const {
    return known_.inside(ix, iy) && known_.at(ix, iy) == CellState::free &&
           clearance_[known_.index(ix, iy)] >= options_.radius;
  }
  double clearance(std::uint32_t cell) const { return clearance_[cell]; }

  /// The passable cell nearest to p, or -1.
  std::int64_t near(const Vec2& p) const {
    if (!p.allFinite()) return -1;
    const int reach = static_cast<int>(std::ceil(options_.snap / known_.resolution));
    const int cx = known_.column(p.x()), cy = known_.row(p.y());
    std::int64_t best = -1;
    double least = options_.snap + 1e-9;
    for (int iy = cy - reach; iy <= cy + reach; ++iy)
      for (int ix = cx - reach; ix <= cx + reach; ++ix) {
        const double d = (known_.centre(ix, iy) - p).norm();
        if (d >= least || !passable(ix, iy)) continue;
        least = d;
        best = static_cast<std::int64_t>(known_.index(ix, iy));
      }
    return best;
  }

  /// Dijkstra over the eight neighbours; equal costs: the lower cell first, always.
  std::vector<std::uint32_t> cheapest(std::uint32_t from, std::uint32_t to) const {
    std::vector<double> cost(known_.cells.size(), kFar);
    std::vector<std::uint32_t> before(known_.cells.size(), from);
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    cost[from] = 0;
    open.push({0, from});
    while (!open.empty()) {
      const auto [at, cell] = open.top();
      open.pop();
      if (cell == to) break;
      if (at > cost[cell]) continue;
      const int x = static_cast<int>(cell % known_.width),
                y = static_cast<int>(cell / known_.width);
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (!passable(x + dx, y + dy)) continue;
          const auto next = static_cast<std::uint32_t>(known_.index(x + dx, y + dy));
          const double total = at + step_cost(next) * std::hypot(dx, dy) * known_.resolution;
          if (total >= cost[next]) continue;
          cost[next] = total;
          before[next] = cell;
          open.push({total, next});
        }
    }
    std::vector<std::uint32_t> way;
    if (cost[to] == kFar) return way;
    for (std::uint32_t c = to; c != from; c = before[c]) way.push_back(c);
    way.push_back(from);
    std::reverse(way.begin(), way.end());
    return way;
  }

 private:
  double step_cost(std::uint32_t cell) const {
    if (clearance_[cell] >= options_.comfort) return 1;
    const double tight = 1 - clearance_[cell] / options_.comfort;
    return 1 + options_.wall_cost * tight * tight;
  }

  const KnownMap& known_;
  const RouteOptions& options_;
  std::vector<float> clearance_;
};

/// The door between two rooms that is nearest to p, or -1.
int door_near(const Topology& t, int a, int b, const Vec2& p) {
  int best = -1;
  for (int d = 0; d < static_cast<int>(t.doors.size()); ++d) {
    const Doorway& door = t.doors[d];
    if (door.from != std::min(a, b) || door.to != std::max(a, b)) continue;
    if (best < 0 || (door.centre - p).norm() < (t.doors[best].centre - p).norm()) best = d;
  }
  return best;
}

}  // namespace

Route find_route(const KnownMap& known, const Topology& topology, const Vec2& from, const Vec2& to,
                 const RouteOptions& options) {
  Route route;
  const Search search(known, options);
  const std::int64_t first = search.near(from), last = search.near(to);
  if (first < 0 || last < 0) return route;
  const auto cells =
      search.cheapest(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last));
  route.found = !cells.empty();
  route.narrowest = route.found ? kFar : 0;
  for (const std::uint32_t cell : cells) {
    const Vec2 p = topology.centre(cell);
    if (!route.way.empty()) route.length += (p - route.way.back()).norm();
    route.way.push_back(p);
    route.narrowest = std::min(route.narrowest, search.clearance(cell));
    const int room = topology.labels[cell];
    if (room < 0 || (!route.rooms.empty() && route.rooms.back() == room)) continue;
    if (!route.rooms.empty())
      route.doors.push_back(door_near(topology, route.rooms.back(), room, p));
    route.rooms.push_back(room);
  }
  return route;
}

GraphRoute graph_route(const Topology& t, int from, int to) {
  // Nodes: the doors, then the start, then the end; two of them are joined if a room has both.
  const int n = static_cast<int>(t.doors.size());
  const auto place = [&](int k) {
    return k < n ? t.doors[k].centre : t.rooms[k == n ? from : to].widest_spot;
  };
  const auto in = [&](int k, int room) {
    return k < n ? t.doors[k].from == room || t.doors[k].to == room : (k == n ? from : to) == room;
  };
  struct At {
    double cost = kFar;
    int before = -1, through = -1;
    bool done = false;
  };
  std::vector<At> at(n + 2);
  at[n].cost = 0;
  for (;;) {
    int k = -1;
    for (int i = 0; i < n + 2; ++i)
      if (!at[i].done && at[i].cost < kFar && (k < 0 || at[i].cost < at[k].cost)) k = i;
    if (k < 0) return {};
    if (k == n + 1) break;
    at[k].done = true;
    for (int room = 0; room < static_cast<int>(t.rooms.size()); ++room) {
      if (!in(k, room)) continue;
      for (int i = 0; i < n + 2; ++i) {
        const double cost = at[k].cost + (place(i) - place(k)).norm();
        if (i == k || !in(i, room) || cost >= at[i].cost) continue;
        at[i] = {cost, k, room, false};
      }
    }
  }
  GraphRoute route;
  route.length = at[n + 1].cost;
  for (int k = n + 1; k != n; k = at[k].before) {
    route.rooms.push_back(at[k].through);
    if (k < n) route.doors.push_back(k);
  }
  std::reverse(route.rooms.begin(), route.rooms.end());
  std::reverse(route.doors.begin(), route.doors.end());
  return route;
}

}  // namespace majak::map
