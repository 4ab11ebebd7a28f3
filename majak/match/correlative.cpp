// SPDX-License-Identifier: Apache-2.0
#include "majak/match/correlative.hpp"

#include <algorithm>
#include <cmath>

namespace majak::match {

LikelihoodPyramid::LikelihoodPyramid(const map::SurfelMap& map, const LikelihoodPyramidOptions& options)
    : cell_(options.cell) {
  const auto& surfels = map.surfels();
  levels_.resize(static_cast<std::size_t>(options.levels));
  if (surfels.empty()) return;
  double x1 = -1e300, y1 = -1e300;
  x0_ = 1e300, y0_ = 1e300;
  for (const auto& s : surfels) {
    x0_ = std::min<double>(x0_, s.x), x1 = std::max<double>(x1, s.x);
    y0_ = std::min<double>(y0_, s.y), y1 = std::max<double>(y1, s.y);
  }
  const int radius = static_cast<int>(std::ceil(2.5 * options.sigma / cell_));
  x0_ -= (radius + 1) * cell_, y0_ -= (radius + 1) * cell_;
  Level& base = levels_[0];
  base.width = static_cast<unsigned>((x1 - x0_) / cell_) + static_cast<unsigned>(radius) + 2;
  base.height = static_cast<unsigned>((y1 - y0_) / cell_) + static_cast<unsigned>(radius) + 2;
  base.values.assign(static_cast<std::size_t>(base.width) * base.height, 0);
  const double inv = -0.5 / (options.sigma * options.sigma);
  for (const auto& s : surfels) {
    const int cx = column(s.x), cy = row(s.y);
    for (int iy = cy - radius; iy <= cy + radius; ++iy) {
      for (int ix = cx - radius; ix <= cx + radius; ++ix) {
        const double dx = x0_ + (ix + 0.5) * cell_ - s.x, dy = y0_ + (iy + 0.5) * cell_ - s.y;
        const double half = 0.5 * cell_;  // a point anywhere in the cell: distance beyond the cell's half
        const double d = std::max(0.0, std::sqrt(dx * dx + dy * dy) - half);
        const auto value = static_cast<std::uint8_t>(std::lround(255.0 * std::exp(inv * d * d)));
        auto& cell = base.values[static_cast<std::size_t>(iy) * base.width + static_cast<std::size_t>(ix)];
        cell = std::max(cell, value);
      }
    }
  }
  // Level l from level l-1: the maximum of four squares of half the size. Squares begin up to
  // 2^l - 1 cells before the grid, hence the offset.
  for (int l = 1; l < options.levels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    const int half = 1 << (l - 1), shift = (1 << l) - 1;
    level.width = base.width + static_cast<unsigned>(shift);
    level.height = base.height + static_cast<unsigned>(shift);
    level.values.resize(static_cast<std::size_t>(level.width) * level.height);
    for (unsigned r = 0; r < level.height; ++r) {
      for (unsigned c = 0; c < level.width; ++c) {
        const int cc = static_cast<int>(c) - shift, rr = static_cast<int>(r) - shift;
        level.values[static_cast<std::size_t>(r) * level.width + c] = static_cast<std::uint8_t>(
            std::max(std::max(at(l - 1, cc, rr), at(l - 1, cc + half, rr)),
                     std::max(at(l - 1, cc, rr + half), at(l - 1, cc + half, rr + half))));
      }
    }
  }
}

namespace {

// The points at one rotation, as cells relative to the window's centre.
struct Rotated {
  double theta = 0;
  std::vector<int> column, row;
};

struct Candidate {
  int rotation, dx, dy;  // lower corner of the square of offsets, in cells
  int bound;
};

class BranchAndBound {
 public:
  BranchAndBound(const LikelihoodPyramid& pyramid, const std::vector<Rotated>& rotations, int reach)
      : pyramid_(pyramid), rotations_(rotations), reach_(reach) {}

  /// Best offset with a score above `floor`; rotation -1 if there is none.
  Candidate run(int floor) {
    best_ = {-1, 0, 0, floor};
    const int top = pyramid_.levels() - 1, side = 1 << top;
    std::vector<Candidate> roots;
    for (int r = 0; r < static_cast<int>(rotations_.size()); ++r)
      for (int dy = -reach_; dy <= reach_; dy += side)
        for (int dx = -reach_; dx <= reach_; dx += side) roots.push_back({r, dx, dy, bound(r, dx, dy, top)});
    descend(roots, top);
    return best_;
  }
  long evaluations() const { return evaluations_; }

 private:
  int bound(int rotation, int dx, int dy, int level) {
    ++evaluations_;
    const Rotated& p = rotations_[static_cast<std::size_t>(rotation)];
    int sum = 0;
    for (std::size_t i = 0; i < p.column.size(); ++i) sum += pyramid_.at(level, p.column[i] + dx, p.row[i] + dy);
    return sum;
  }

  void descend(std::vector<Candidate>& candidates, int level) {
    // Highest bound first; ties in a fixed order, so that the answer does not depend on the sort.
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      if (a.bound != b.bound) return a.bound > b.bound;
      if (a.rotation != b.rotation) return a.rotation < b.rotation;
      return a.dy != b.dy ? a.dy < b.dy : a.dx < b.dx;
    });
    for (const Candidate& c : candidates) {
      if (c.bound <= best_.bound) return;
      if (level == 0) {
        best_ = c;
        return;
      }
      const int half = 1 << (level - 1);
      std::vector<Candidate> children;
      children.reserve(4);
      for (int dy = c.dy; dy <= std::min(c.dy + half, reach_); dy += half)
        for (int dx = c.dx; dx <= std::min(c.dx + half, reach_); dx += half)
          children.push_back({c.rotation, dx, dy, bound(c.rotation, dx, dy, level - 1)});
      descend(children, level - 1);
    }
  }

  const LikelihoodPyramid& pyramid_;
  const std::vector<Rotated>& rotations_;
  int reach_;
  Candidate best_{};
  long evaluations_ = 0;
};

}  // namespace

std::optional<CorrelativeMatch> search(const ScanPoints& points, const LikelihoodPyramid& pyramid, const Pose2& around,
                                       const SearchWindow& window, double min_score, int max_points) {
  if (points.size() == 0) return std::nullopt;
  const std::size_t stride = (points.size() + static_cast<std::size_t>(max_points) - 1) / static_cast<std::size_t>(max_points);
  double far2 = 0;
  for (std::size_t i = 0; i < points.size(); i += stride)
    far2 = std::max<double>(far2, points.x[i] * points.x[i] + points.y[i] * points.y[i]);
  const double step = pyramid.cell() / std::max(std::sqrt(far2), 1.0);
  const int turns = static_cast<int>(std::ceil(window.rotation / step));
  std::vector<Rotated> rotations;
  for (int k = -turns; k <= turns; ++k) {
    Rotated r;
    r.theta = around.theta + k * step;
    const double c = std::cos(r.theta), s = std::sin(r.theta);
    for (std::size_t i = 0; i < points.size(); i += stride) {
      r.column.push_back(pyramid.column(around.x + c * points.x[i] - s * points.y[i]));
      r.row.push_back(pyramid.row(around.y + s * points.x[i] + c * points.y[i]));
    }
    rotations.push_back(std::move(r));
  }
  const double full = 255.0 * static_cast<double>(rotations[0].column.size());
  BranchAndBound engine(pyramid, rotations, static_cast<int>(std::ceil(window.translation / pyramid.cell())));
  const Candidate best = engine.run(static_cast<int>(std::ceil(min_score * full)) - 1);
  if (best.rotation < 0) return std::nullopt;
  CorrelativeMatch match;
  match.T_map_robot = {around.x + best.dx * pyramid.cell(), around.y + best.dy * pyramid.cell(),
                       wrap_angle(rotations[static_cast<std::size_t>(best.rotation)].theta)};
  match.score = best.bound / full;
  match.evaluations = engine.evaluations();
  return match;
}

}  // namespace majak::match
