// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/core/error.hpp"

namespace majak::sim {

namespace {

constexpr double kCell = 0.5;       // m; a few objects a cell in a furnished building
constexpr double kTouching = 1e-9;  // m; what lies on a cell's border belongs to both sides
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Does the segment touch the box [low, high]? Separating axes: the box's two and its normal.
bool touches(const Segment& s, const Vec2& low, const Vec2& high) {
  if (std::max(s.a.x(), s.b.x()) < low.x() || std::min(s.a.x(), s.b.x()) > high.x()) return false;
  if (std::max(s.a.y(), s.b.y()) < low.y() || std::min(s.a.y(), s.b.y()) > high.y()) return false;
  const Vec2 along = s.b - s.a;
  const Vec2 centre = (low + high) / 2, half = (high - low) / 2;
  const double reach = std::abs(along.x()) * half.y() + std::abs(along.y()) * half.x();
  return std::abs(cross(along, centre - s.a)) <= reach + kTouching * along.norm();
}

void meet_segment(const Segment& s, const Vec2& origin, const Vec2& direction, int object,
                  Hit& best) {
  const Vec2 along = s.b - s.a, to_a = s.a - origin;
  const double det = cross(direction, along);
  if (det == 0) return;  // parallel: a wall seen exactly edge-on sends nothing back
  const double range = cross(to_a, along) / det;
  const double part = cross(to_a, direction) / det;
  if (range < 0 || range >= best.range || part < 0 || part > 1) return;
  best = {range, 0, s.reflectivity, object};
}

void meet_disc(const Disc& d, const Vec2& origin, const Vec2& direction, int object, Hit& best) {
  const Vec2 to_centre = d.centre - origin;
  const double along = to_centre.dot(direction), aside = cross(direction, to_centre);
  const double half_chord2 = d.radius * d.radius - aside * aside;
  if (along <= 0 || half_chord2 < 0) return;
  const double range = along - std::sqrt(half_chord2);
  if (range < 0 || range >= best.range) return;
  best = {range, 0, d.reflectivity, object};
}

/// Between the ray and the surface's normal. Only once a ray, for the hit that counts.
double incidence_on(const Segment& s, const Vec2& direction) {
  const Vec2 along = s.b - s.a;
  return std::acos(std::min(1.0, std::abs(cross(direction, along)) / along.norm()));
}

double incidence_on(const Disc& d, const Vec2& origin, const Vec2& direction) {
  return std::asin(std::min(1.0, std::abs(cross(direction, d.centre - origin)) / d.radius));
}

}  // namespace

double distance_to(const Segment& s, const Vec2& point) {
  const Vec2 along = s.b - s.a;
  const double length2 = along.squaredNorm();
  const double part = length2 > 0 ? std::clamp((point - s.a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - (s.a + part * along)).norm();
}

World::World(Scene scene) : scene_(std::move(scene)) {
  if (scene_.segments.empty() && scene_.discs.empty()) {
    throw Error(scene_.name + ": the world is empty: there is no wall to see");
  }
  low_ = Vec2::Constant(kInfinity);
  high_ = -low_;
  const auto include = [this](const Vec2& p, double radius) {
    low_ = low_.cwiseMin(p - Vec2::Constant(radius));
    high_ = high_.cwiseMax(p + Vec2::Constant(radius));
  };
  for (const Segment& s : scene_.segments) {
    include(s.a, 0);
    include(s.b, 0);
  }
  for (const Disc& d : scene_.discs) include(d.centre, d.radius);
  if (!low_.allFinite() || !high_.allFinite()) {
    throw Error(scene_.name + ": the world has a coordinate that is not finite");
  }
  fill_grid();
}

template <class Body>
void World::for_each_cell(int object, const Body& body) const {
  const bool is_segment = object < static_cast<int>(scene_.segments.size());
  const Segment* segment = is_segment ? &scene_.segments[object] : nullptr;
  Vec2 low, high;
  if (segment != nullptr) {
    low = segment->a.cwiseMin(segment->b);
    high = segment->a.cwiseMax(segment->b);
  } else {
    const Disc& d = scene_.discs[object - scene_.segments.size()];
    low = d.centre - Vec2::Constant(d.radius);
    high = d.centre + Vec2::Constant(d.radius);
  }
  const auto cell = [this](double value, int axis, int count) {
    return std::clamp(static_cast<int>(std::floor((value - grid_low_[axis]) / kCell)), 0,
                      count - 1);
  };
  const int column0 = cell(low.x() - kTouching, 0, columns_);
  const int column1 = cell(high.x() + kTouching, 0, columns_);
  const int row0 = cell(low.y() - kTouching, 1, rows_);
  const int row1 = cell(high.y() + kTouching, 1, rows_);
  for (int row = row0; row <= row1; ++row) {
    for (int column = column0; column <= column1; ++column) {
      const Vec2 corner = grid_low_ + kCell * Vec2(column, row);
      const Vec2 slack = Vec2::Constant(kTouching), opposite = corner + Vec2::Constant(kCell);
      if (segment != nullptr && !touches(*segment, corner - slack, opposite + slack)) continue;
      body(row * columns_ + column);
    }
  }
}

void World::fill_grid() {
  // A rim keeps what lies on the box's border inside the grid.
  grid_low_ = low_ - Vec2::Constant(kCell / 2);
  const Vec2 size = high_ - low_ + Vec2::Constant(kCell);
  if (size.x() * size.y() / (kCell * kCell) > 1e8) {
    throw Error(scene_.name + ": the world is too large: give a smaller scale");
  }
  columns_ = static_cast<int>(std::ceil(size.x() / kCell));
  rows_ = static_cast<int>(std::ceil(size.y() / kCell));
  const int count = static_cast<int>(scene_.segments.size() + scene_.discs.size());
  first_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  for (int o = 0; o < count; ++o) {
    for_each_cell(o, [this](int cell) { ++first_[cell + 1]; });
  }
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  objects_.resize(first_.back());
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (int o = 0; o < count; ++o) {
    for_each_cell(o, [&](int cell) { objects_[next[cell]++] = o; });
  }
}

void World::meet(int object, const Ray& ray, Hit& best) const {
  const int segments = static_cast<int>(scene_.segments.size());
  if (object < segments) {
    meet_segment(scene_.segments[object], ray.origin, ray.direction, object, best);
  } else {
    meet_disc(scene_.discs[object - segments], ray.origin, ray.direction, object, best);
  }
}

/// From cell to cell along the ray (Amanatides and Woo 1987) until the best hit lies before the
/// next border.
void World::walk(const Ray& ray, Hit& best) const {
  const Vec2 size = kCell * Vec2(columns_, rows_);
  double enter = 0, leave = best.range;
  for (int axis = 0; axis < 2; ++axis) {
    const double d = ray.direction[axis], o = ray.origin[axis] - grid_low_[axis];
    if (d == 0) {
      if (o < 0 || o >= size[axis]) return;
      continue;
    }
    const double t0 = -o / d, t1 = (size[axis] - o) / d;
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  if (enter > leave) return;
  int cell[2], step[2];
  double next[2], delta[2];
  const int count[2] = {columns_, rows_};
  for (int axis = 0; axis < 2; ++axis) {
    const double d = ray.direction[axis];
    const double p = (ray.origin[axis] + enter * d - grid_low_[axis]) / kCell;
    cell[axis] = std::clamp(static_cast<int>(std::floor(p)), 0, count[axis] - 1);
    step[axis] = d > 0 ? 1 : -1;
    delta[axis] = d == 0 ? kInfinity : kCell / std::abs(d);
    const double border = grid_low_[axis] + kCell * (cell[axis] + (d > 0 ? 1 : 0));
    next[axis] = d == 0 ? kInfinity : (border - ray.origin[axis]) / d;
  }
  for (;;) {
    const std::size_t c = static_cast<std::size_t>(cell[1]) * columns_ + cell[0];
    for (int i = first_[c]; i < first_[c + 1]; ++i) meet(objects_[i], ray, best);
    const int axis = next[0] < next[1] ? 0 : 1;
    if (next[axis] > std::min(best.range, leave)) return;
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= count[axis]) return;
    next[axis] += delta[axis];
  }
}

Hit World::cast(const Vec2& origin, double angle, double max_range, std::span<const Disc> moving,
                std::span<const Segment> leaves) const {
  const Ray ray{origin, {std::cos(angle), std::sin(angle)}};
  Hit best;
  best.range = max_range;
  const int count = static_cast<int>(scene_.segments.size() + scene_.discs.size());
  for (std::size_t i = 0; i < moving.size(); ++i) {
    if ((moving[i].centre - origin).norm() <= moving[i].radius) continue;
    meet_disc(moving[i], origin, ray.direction, count + static_cast<int>(i), best);
  }
  const int discs = count + static_cast<int>(moving.size());
  for (std::size_t i = 0; i < leaves.size(); ++i)
    meet_segment(leaves[i], origin, ray.direction, discs + static_cast<int>(i), best);
  walk(ray, best);
  const int segments = static_cast<int>(scene_.segments.size());
  if (best.object < 0) {
    best.range = kInfinity;
  } else if (best.object < segments) {
    best.incidence = incidence_on(scene_.segments[best.object], ray.direction);
  } else if (best.object >= discs) {
    best.incidence =
        incidence_on(leaves[static_cast<std::size_t>(best.object - discs)], ray.direction);
  } else {
    const Disc& disc = best.object < count ? scene_.discs[best.object - segments]
                                           : moving[static_cast<std::size_t>(best.object - count)];
    best.incidence = incidence_on(disc, ray.origin, ray.direction);
  }
  return best;
}

double World::clearance(const Vec2& point) const {
  double best = kInfinity;
  for (const Segment& s : scene_.segments) best = std::min(best, distance_to(s, point));
  for (const Disc& d : scene_.discs) {
    best = std::min(best, std::max(0.0, (point - d.centre).norm() - d.radius));
  }
  return best;
}

}  // namespace majak::sim
