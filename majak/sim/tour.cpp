// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/tour.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <string>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::sim {

namespace {

constexpr double kCell = 0.2;                           // m
constexpr double kComfort = 0.8;                        // m; a wider berth is not worth a detour
constexpr double kWallCost = 4.0;                       // a metre along a wall costs this many more
constexpr std::size_t kMinPlaces = 5, kMaxPlaces = 80;  // of a tour that is made up
constexpr float kFar = std::numeric_limits<float>::infinity();

/// How far every cell is from the nearest surface (up to kComfort), and ways between cells.
class Floor {
 public:
  Floor(const World& world, double clearance) : world_(world), needed_(clearance) {
    low_ = world.low() - Vec2::Constant(kCell);
    const Vec2 size = (world.high() - low_) / kCell;
    columns_ = static_cast<int>(std::ceil(size.x())) + 2;
    rows_ = static_cast<int>(std::ceil(size.y())) + 2;
    clearance_.assign(static_cast<std::size_t>(columns_) * rows_, static_cast<float>(kComfort));
    for (const Segment& s : world.scene().segments) {
      lower(s.a.cwiseMin(s.b), s.a.cwiseMax(s.b), [&](const Vec2& p) { return distance_to(s, p); });
    }
    for (const Disc& d : world.scene().discs) {
      const Vec2 r = Vec2::Constant(d.radius);
      lower(d.centre - r, d.centre + r,
            [&](const Vec2& p) { return (p - d.centre).norm() - d.radius; });
    }
  }

  int cells() const { return static_cast<int>(clearance_.size()); }
  float clearance(int cell) const { return clearance_[cell]; }
  bool free(int cell) const { return clearance_[cell] >= needed_; }
  Vec2 centre(int cell) const {
    const int column = cell % columns_, row = cell / columns_;
    return low_ + kCell * Vec2(column + 0.5, row + 0.5);
  }
  /// -1 outside.
  int cell_at(const Vec2& p) const {
    const Vec2 q = (p - low_) / kCell;
    const int column = static_cast<int>(std::floor(q.x())),
              row = static_cast<int>(std::floor(q.y()));
    const bool inside = column >= 0 && row >= 0 && column < columns_ && row < rows_;
    return inside ? row * columns_ + column : -1;
  }
  /// The free cell nearest to p within 0.6 m, with no wall between, or -1.
  int free_cell_near(const Vec2& p) const {
    int best = -1;
    double best_distance = 0.6;
    for (int c = 0; c < cells(); ++c) {
      const double d = (centre(c) - p).norm();
      if (d < best_distance && free(c) && sees(p, centre(c))) {
        best = c;
        best_distance = d;
      }
    }
    return best;
  }

  struct Ways {
    std::vector<float> cost;  ///< from the source; kFar where it cannot be reached
    std::vector<int> from;
  };
  /// Dijkstra over the eight neighbours; stops at `target` if that is a cell.
  Ways ways(int source, int target = -1) const;

 private:
  template <class Distance>
  void lower(const Vec2& low, const Vec2& high, const Distance& distance) {
    const Vec2 a = (low - low_ - Vec2::Constant(kComfort)) / kCell;
    const Vec2 b = (high - low_ + Vec2::Constant(kComfort)) / kCell;
    const int row1 = std::min(rows_ - 1, static_cast<int>(b.y()));
    const int column1 = std::min(columns_ - 1, static_cast<int>(b.x()));
    for (int row = std::max(0, static_cast<int>(a.y())); row <= row1; ++row) {
      for (int column = std::max(0, static_cast<int>(a.x())); column <= column1; ++column) {
        const int c = row * columns_ + column;
        clearance_[c] = std::min(clearance_[c], static_cast<float>(distance(centre(c))));
      }
    }
  }

  bool sees(const Vec2& from, const Vec2& to) const {
    const Vec2 way = to - from;
    return world_.cast(from, std::atan2(way.y(), way.x()), way.norm()).object < 0;
  }

  const World& world_;
  double needed_;
  Vec2 low_;
  int columns_ = 0, rows_ = 0;
  std::vector<float> clearance_;
};

Floor::Ways Floor::ways(int source, int target) const {
  Ways w{std::vector<float>(clearance_.size(), kFar), std::vector<int>(clearance_.size(), -1)};
  using Entry = std::pair<float, int>;  // equal costs: the lower cell first, always
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  w.cost[source] = 0;
  open.push({0.0F, source});
  while (!open.empty()) {
    const auto [cost, cell] = open.top();
    open.pop();
    if (cell == target) break;
    if (cost > w.cost[cell]) continue;
    const int column = cell % columns_, row = cell / columns_;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = column + dx, y = row + dy, next = y * columns_ + x;
        if (x < 0 || y < 0 || x >= columns_ || y >= rows_ || !free(next)) continue;
        const double tight = 1 - static_cast<double>(clearance_[next]) / kComfort;
        const double way = kCell * std::hypot(dx, dy) * (1 + kWallCost * tight * tight);
        const float total = cost + static_cast<float>(way);
        if (total < w.cost[next]) {
          w.cost[next] = total;
          w.from[next] = cell;
          open.push({total, next});
        }
      }
    }
  }
  return w;
}

/// The cells' zigzag turned into a smooth line: every point moves between its neighbours as long as
/// it stays clear of the walls. The ends stay.
std::vector<Vec2> smooth(const Floor& floor, std::vector<Vec2> points) {
  for (int round = 0; round < 30; ++round) {
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const Vec2 p = 0.5 * points[i] + 0.25 * (points[i - 1] + points[i + 1]);
      if (floor.free(floor.cell_at(p))) points[i] = p;
    }
  }
  return points;
}

std::vector<Vec2> resample(const std::vector<Vec2>& points, double step) {
  std::vector<Vec2> out{points.front()};
  double left = step;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Vec2 edge = points[i] - points[i - 1];
    const double size = edge.norm();
    double at = left;
    for (; at <= size; at += step) out.push_back(points[i - 1] + edge * (at / size));
    left = at - size;
  }
  return out;
}

/// Cells that can be reached, the widest places first, none within `spacing` of another.
std::vector<int> spread_places(const Floor& floor, int start, double spacing) {
  const Floor::Ways reach = floor.ways(start);
  std::vector<int> wide;
  for (int c = 0; c < floor.cells(); ++c) {
    if (reach.cost[c] < kFar) wide.push_back(c);
  }
  std::stable_sort(wide.begin(), wide.end(),
                   [&](int a, int b) { return floor.clearance(a) > floor.clearance(b); });
  std::vector<int> places;
  for (const int c : wide) {
    const auto close = [&](int p) { return (floor.centre(p) - floor.centre(c)).norm() < spacing; };
    if (places.size() < kMaxPlaces && std::none_of(places.begin(), places.end(), close)) {
      places.push_back(c);
    }
  }
  return places;
}

/// Places all over the floor, in the order in which the nearest is visited next, and back to the
/// start. On a small floor they lie closer together.
std::vector<Vec2> make_tour(const Floor& floor, int start, double spacing) {
  std::vector<int> places = spread_places(floor, start, spacing);
  while (places.size() < kMinPlaces && spacing > 2 * kCell) {
    spacing /= 2;
    places = spread_places(floor, start, spacing);
  }
  std::vector<Vec2> tour;
  int here = start;
  while (!places.empty()) {
    const Floor::Ways from_here = floor.ways(here);
    const auto nearest = std::min_element(places.begin(), places.end(), [&](int a, int b) {
      return from_here.cost[a] < from_here.cost[b];
    });
    here = *nearest;
    places.erase(nearest);
    tour.push_back(floor.centre(here));
  }
  tour.push_back(floor.centre(start));
  return tour;
}

[[noreturn]] void refuse(const World& world, const Vec2& p, const char* what) {
  throw Error(world.scene().name + ": " + what + " (" + std::to_string(p.x()) + ", " +
              std::to_string(p.y()) + ") m");
}

/// From the start to place after place in straight lines.
Path straight_way(const World& world, const Floor& floor, const std::vector<Vec2>& places) {
  const Pose2& start = world.scene().start;
  std::vector<Vec2> points{start.translation()};
  points.insert(points.end(), places.begin(), places.end());
  points = resample(points, kPathStep);
  for (const Vec2& p : points) {
    const int cell = floor.cell_at(p);
    if (cell >= 0 && !floor.free(cell)) refuse(world, p, "there is no room for the robot at");
  }
  return {start, std::move(points)};
}

}  // namespace

double length(const std::vector<Vec2>& points) {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

Path plan_tour(const World& world, const TourOptions& options) {
  const Floor floor(world, options.clearance);
  const Scene& scene = world.scene();
  const int start = floor.free_cell_near(scene.start.translation());
  if (start < 0) {
    refuse(world, scene.start.translation(), "there is no room for the robot at its start");
  }
  const std::vector<Vec2>& named =
      options.short_tour && !scene.short_tour.empty() ? scene.short_tour : scene.tour;
  std::vector<Vec2> tour = named.empty() ? make_tour(floor, start, options.spacing) : named;
  const std::size_t once = tour.size();
  for (int lap = 1; lap < options.laps; ++lap) {
    for (std::size_t i = 0; i < once; ++i) tour.push_back(tour[i]);
  }
  if (scene.straight) return straight_way(world, floor, tour);
  std::vector<Vec2> points{scene.start.translation()};
  int here = start;
  for (const Vec2& place : tour) {
    const int there = floor.free_cell_near(place);
    if (there < 0) refuse(world, place, "there is no room for the robot at");
    const Floor::Ways ways = floor.ways(here, there);
    if (!(ways.cost[there] < kFar)) refuse(world, place, "the robot finds no way to");
    std::vector<Vec2> leg;
    for (int c = there; c != -1; c = ways.from[c]) leg.push_back(floor.centre(c));
    std::reverse(leg.begin(), leg.end());
    leg = smooth(floor, std::move(leg));
    points.insert(points.end(), leg.begin(), leg.end());
    here = there;
  }
  return {scene.start, resample(points, kPathStep)};
}

}  // namespace majak::sim
