// SPDX-License-Identifier: Apache-2.0
#include "majak/map/object_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace majak::map {
namespace {

constexpr double kSurface = 0.3;      // chance from which on a cell is part of the surface
constexpr int kSearchedPoints = 24;   // of a piece
constexpr double kSearchStep = 0.1;   // m
constexpr double kSearchReach = 0.6;  // m, around where the middles meet
constexpr double kSearchTurn = radians(10);
constexpr std::size_t kRefined = 6;  // starts of the search that are followed uphill
constexpr double kFirstStep = 0.05;  // m
constexpr double kFirstTurn = radians(5);
constexpr int kHalvings = 4;

bool near_occupied(const KnownMap& map, int ix, int iy) {
  for (int y = iy - 1; y <= iy + 1; ++y)
    for (int x = ix - 1; x <= ix + 1; ++x)
      if (map.at(x, y) == CellState::occupied) return true;
  return false;
}

Vec2 middle_of(const std::vector<Vec2>& points) {
  Vec2 sum = Vec2::Zero();
  for (const Vec2& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

/// Turns by `angle` about `about` (map frame), then shifts.
Pose2 moved(const Pose2& T, const Vec2& about, const Vec2& shift, double angle) {
  const Vec2 arm = T.translation() - about;
  const double c = std::cos(angle), s = std::sin(angle);
  return {about.x() + c * arm.x() - s * arm.y() + shift.x(),
          about.y() + s * arm.x() + c * arm.y() + shift.y(), wrap_angle(T.theta + angle)};
}

}  // namespace

KnownMap clear_floor(const KnownMap& snapshot) {
  KnownMap clear = snapshot;
  for (int y = 0; y < clear.height; ++y)
    for (int x = 0; x < clear.width; ++x)
      if (clear.at(x, y) == CellState::free && near_occupied(clear, x, y))
        clear.cells[clear.index(x, y)] = CellState::unknown;
  return clear;
}

void describe(OptionFields& fields, ShapeOptions& o) {
  fields.add("shape.reach", o.reach, {"m", "half side of an object's grid", 0.2, 10});
  fields.add("shape.unseen", o.unseen, {"1", "chance of a cell never seen", 0.001, 0.9});
  fields.add("shape.unseen_weight", o.unseen_weight, {"1", "sightings it is worth", 0.01, 10});
  fields.add("shape.point_weight", o.point_weight,
             {"1", "what a cell counts, of an independent reading", 0.01, 1});
}

ObjectShape::ObjectShape(std::span<const Sighting> sightings, double resolution,
                         const ShapeOptions& options)
    : resolution_(resolution),
      half_(static_cast<int>(std::ceil(options.reach / resolution))),
      outside_(std::log(options.unseen)) {
  const auto side = static_cast<std::size_t>(2 * half_ + 1);
  std::vector<double> hits(side * side), seen(side * side);
  for (const Sighting& s : sightings) add(s, hits, seen);
  chance_.resize(side * side);
  for (std::size_t i = 0; i < chance_.size(); ++i)
    chance_[i] = static_cast<float>((hits[i] + options.unseen * options.unseen_weight) /
                                    (seen[i] + options.unseen_weight));
  finish();
}

/// A point counts in the four cells around it by how near their middles are, a cell once at most.
void ObjectShape::add(const Sighting& sighting, std::vector<double>& hits,
                      std::vector<double>& seen) const {
  std::vector<float> here(hits.size());
  const Pose2 T_object_map = sighting.T_map_object.inverse();
  for (const Vec2& p : sighting.seen.piece->points) {
    const Vec2 q = T_object_map * p / resolution_;
    const int x = static_cast<int>(std::floor(q.x())), y = static_cast<int>(std::floor(q.y()));
    const double fx = q.x() - x, fy = q.y() - y;
    for (int k = 0; k < 4; ++k)
      if (const int cx = x + (k & 1), cy = y + (k >> 1); inside(cx, cy))
        here[index(cx, cy)] +=
            static_cast<float>(((k & 1) ? fx : 1 - fx) * ((k >> 1) ? fy : 1 - fy));
  }
  for (int y = -half_; y <= half_; ++y)
    for (int x = -half_; x <= half_; ++x) {
      const std::size_t i = index(x, y);
      const double hit = std::min(1.0F, here[i]);
      const bool free =
          hit == 0 &&
          sighting.seen.clear->at(sighting.T_map_object * Vec2(x * resolution_, y * resolution_)) ==
              CellState::free;
      hits[i] += sighting.weight * hit;
      seen[i] += sighting.weight * (free ? 1.0 : hit);
    }
}

void ObjectShape::finish() {
  log_chance_.resize(chance_.size());
  best_log_chance_.assign(chance_.size(), static_cast<float>(outside_));
  for (std::size_t i = 0; i < chance_.size(); ++i) log_chance_[i] = std::log(chance_[i]);
  for (int y = -half_; y <= half_; ++y)
    for (int x = -half_; x <= half_; ++x) {
      float best = log_chance_[index(x, y)];
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u)
          if (inside(u, v)) best = std::max(best, log_chance_[index(u, v)]);
      best_log_chance_[index(x, y)] = best;
      if (chance(x, y) <= kSurface) continue;
      surface_.push_back({Vec2(x * resolution_, y * resolution_), std::log1p(-chance(x, y))});
      middle_ += surface_.back().at;
    }
  if (!surface_.empty()) middle_ /= static_cast<double>(surface_.size());
}

double ObjectShape::chance(int ix, int iy) const {
  return inside(ix, iy) ? static_cast<double>(chance_[index(ix, iy)]) : std::exp(outside_);
}

double ObjectShape::log_chance(const Vec2& p) const {
  const Vec2 q = p / resolution_;
  const int x = static_cast<int>(std::floor(q.x())), y = static_cast<int>(std::floor(q.y()));
  if (!inside(x, y) || !inside(x + 1, y + 1)) return outside_;
  const double fx = q.x() - x, fy = q.y() - y;
  const std::size_t i = index(x, y), up = i + static_cast<std::size_t>(2 * half_ + 1);
  return (1 - fy) * ((1 - fx) * log_chance_[i] + fx * log_chance_[i + 1]) +
         fy * ((1 - fx) * log_chance_[up] + fx * log_chance_[up + 1]);
}

double log_likelihood(const ObjectShape& shape, const SeenPiece& seen, const Pose2& T_map_object,
                      const ShapeOptions& options) {
  const double c = std::cos(T_map_object.theta), s = std::sin(T_map_object.theta);
  double sum = 0;
  for (const Vec2& p : seen.piece->points) {
    const double dx = p.x() - T_map_object.x, dy = p.y() - T_map_object.y;
    sum += shape.log_chance({c * dx + s * dy, c * dy - s * dx});
  }
  for (const ObjectShape::Surface& cell : shape.surface()) {
    const Vec2 p(T_map_object.x + c * cell.at.x() - s * cell.at.y(),
                 T_map_object.y + s * cell.at.x() + c * cell.at.y());
    if (seen.clear->at(p) == CellState::free) sum += cell.log_free;
  }
  return options.point_weight * sum;
}

ShapeFit refined_fit(const ObjectShape& shape, const SeenPiece& seen, const Pose2& start,
                     const ShapeOptions& options) {
  constexpr int kMoves[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
  const Vec2 about = middle_of(seen.piece->points);
  ShapeFit best{start, log_likelihood(shape, seen, start, options)};
  double step = kFirstStep, turn = kFirstTurn;
  for (int k = 0; k < kHalvings; ++k, step /= 2, turn /= 2)
    for (bool better = true; better;) {
      better = false;
      for (const auto& m : kMoves) {
        const Pose2 T =
            moved(best.T_map_object, about, Vec2(m[0] * step, m[1] * step), m[2] * turn);
        const double l = log_likelihood(shape, seen, T, options);
        if (l <= best.log_likelihood + 1e-9) continue;
        best = {T, l};
        better = true;
      }
    }
  return best;
}

ShapeFit best_fit(const ObjectShape& shape, const SeenPiece& seen, const ShapeOptions& options) {
  const std::vector<Vec2>& all = seen.piece->points;
  const Vec2 about = middle_of(all);
  std::vector<Vec2> points;  // relative to their middle
  const std::size_t step = 1 + (all.size() - 1) / kSearchedPoints;
  for (std::size_t i = 0; i < all.size(); i += step) points.push_back(all[i] - about);
  std::vector<ShapeFit> starts;
  const int turns = static_cast<int>(std::lround(2 * kPi / kSearchTurn));
  const int reach = static_cast<int>(std::lround(kSearchReach / kSearchStep));
  std::vector<Vec2> turned(points.size());
  for (int k = 0; k < turns; ++k) {
    const double theta = wrap_angle(k * kSearchTurn);
    const double c = std::cos(theta), s = std::sin(theta);
    std::transform(points.begin(), points.end(), turned.begin(), [&](const Vec2& p) {
      return Vec2(c * p.x() + s * p.y(), c * p.y() - s * p.x());
    });
    // The piece's middle in the object frame.
    Vec2 best_at = shape.middle();
    double best = -std::numeric_limits<double>::infinity();
    for (int iy = -reach; iy <= reach; ++iy)
      for (int ix = -reach; ix <= reach; ++ix) {
        const Vec2 at = shape.middle() + kSearchStep * Vec2(ix, iy);
        double sum = 0;  // only falls
        for (std::size_t i = 0; i < turned.size() && sum > best; ++i)
          sum += shape.best_log_chance(turned[i] + at);
        if (sum > best) best = sum, best_at = at;
      }
    const Vec2 origin =
        about - Vec2(c * best_at.x() - s * best_at.y(), s * best_at.x() + c * best_at.y());
    starts.push_back({{origin.x(), origin.y(), theta}, best});
  }
  std::stable_sort(starts.begin(), starts.end(), [](const ShapeFit& a, const ShapeFit& b) {
    return a.log_likelihood > b.log_likelihood;
  });
  ShapeFit best{{}, -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < std::min(kRefined, starts.size()); ++i) {
    const ShapeFit fit = refined_fit(shape, seen, starts[i].T_map_object, options);
    if (fit.log_likelihood > best.log_likelihood) best = fit;
  }
  return best;
}

}  // namespace majak::map
