// SPDX-License-Identifier: Apache-2.0
#include "majak/match/correlative.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "majak/core/simd.hpp"

namespace majak::match {
namespace {

MAJAK_VECTORIZED void max_of_four(const std::uint8_t* a, const std::uint8_t* b, int half, int n,
                                  std::uint8_t* out) {
  for (int c = 0; c < n; ++c)
    out[c] = std::max(std::max(a[c], a[c + half]), std::max(b[c], b[c + half]));
}

}  // namespace

LikelihoodPyramid::LikelihoodPyramid(const map::SurfelMap& map, const Vec2& centre,
                                     const LikelihoodPyramidOptions& options)
    : options_(options) {
  std::vector<map::Surfel> near;
  double x1 = -1e300, y1 = -1e300;
  x0_ = 1e300, y0_ = 1e300;
  for (const map::Surfel& s : map.surfels()) {
    if ((Vec2(s.x, s.y) - centre).norm() > options.radius) continue;
    near.push_back(s);
    x0_ = std::min<double>(x0_, s.x), x1 = std::max<double>(x1, s.x);
    y0_ = std::min<double>(y0_, s.y), y1 = std::max<double>(y1, s.y);
  }
  if (near.empty()) x0_ = x1 = centre.x(), y0_ = y1 = centre.y();
  // A point that may meet a surface lies up to `reach` cells off it and is moved by `reach` more.
  margin_ =
      2 * static_cast<int>(std::ceil(options.max_translation / options.cell)) + (1 << kLevels);
  x0_ -= margin_ * options.cell, y0_ -= margin_ * options.cell;
  width_ = column(x1) + margin_ + 1;
  height_ = row(y1) + margin_ + 1;
  values_.assign(static_cast<std::size_t>(kLevels) * static_cast<std::size_t>(width_) *
                     static_cast<std::size_t>(height_),
                 0);
  stamp_surfaces(near);
  for (int l = 1; l < kLevels; ++l) build_level(l);
}

void LikelihoodPyramid::stamp_surfaces(const std::vector<map::Surfel>& surfels) {
  constexpr int kRadius = 2, kSide = 2 * kRadius + 1;
  std::array<std::uint8_t, kSide * kSide> kernel{};
  for (int y = -kRadius; y <= kRadius; ++y)
    for (int x = -kRadius; x <= kRadius; ++x) {
      const double d = options_.cell * std::max(0.0, std::hypot(x, y) - 0.5) / options_.sigma;
      kernel[static_cast<std::size_t>((y + kRadius) * kSide + x + kRadius)] =
          static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * d * d)));
    }
  for (const map::Surfel& s : surfels) {
    const int cx = column(s.x), cy = row(s.y);
    for (int y = 0; y < kSide; ++y) {
      std::uint8_t* to =
          values_.data() +
          static_cast<std::size_t>(cy + y - kRadius) * static_cast<std::size_t>(width_) +
          (cx - kRadius);
      for (int x = 0; x < kSide; ++x)
        to[x] = std::max(to[x], kernel[static_cast<std::size_t>(y * kSide + x)]);
    }
  }
}

// Level l from level l-1: the maximum of four squares of half the size. The last rows and columns
// stay zero: they lie in the margin.
void LikelihoodPyramid::build_level(int l) {
  const int half = 1 << (l - 1);
  const auto w = static_cast<std::size_t>(width_);
  const std::uint8_t* from = level(l - 1);
  std::uint8_t* to =
      values_.data() + static_cast<std::size_t>(l) * w * static_cast<std::size_t>(height_);
  for (int r = 0; r + half < height_; ++r) {
    const std::size_t row = static_cast<std::size_t>(r) * w;
    max_of_four(from + row, from + row + static_cast<std::size_t>(half) * w, half, width_ - half,
                to + row);
  }
}

namespace {

// The points at one rotation, as indices into the pyramid's levels before they are moved.
struct Rotated {
  double theta = 0;
  std::vector<int> cell;
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
    constexpr int kTop = LikelihoodPyramid::kLevels - 1, kSide = 1 << kTop;
    std::vector<Candidate>& roots = levels_[kTop];
    for (int r = 0; r < static_cast<int>(rotations_.size()); ++r)
      for (int dy = -reach_; dy <= reach_; dy += kSide)
        for (int dx = -reach_; dx <= reach_; dx += kSide) consider(roots, r, dx, dy, kTop);
    descend(kTop, 0);
    return best_;
  }
  long evaluations() const { return evaluations_; }

 private:
  static constexpr std::size_t kRun = 16;  // points between two looks at the bound

  void consider(std::vector<Candidate>& list, int rotation, int dx, int dy, int level) {
    ++evaluations_;
    const std::uint8_t* values =
        pyramid_.level(level) + static_cast<std::ptrdiff_t>(dy) * pyramid_.width() + dx;
    const std::vector<int>& cells = rotations_[static_cast<std::size_t>(rotation)].cell;
    int sum = 0;
    for (std::size_t i = 0; i < cells.size();) {
      const std::size_t end = std::min(i + kRun, cells.size());
      for (; i < end; ++i) sum += values[cells[i]];
      // Full marks for all the others would not do any more.
      if (sum + 255 * static_cast<int>(cells.size() - i) <= best_.bound) return;
    }
    list.push_back({rotation, dx, dy, sum});
  }

  // Looks at levels_[level][begin ...], highest bound first; ties in a fixed order, so that the
  // answer does not depend on the sort. Children are kept in one list a level: no allocation.
  void descend(int level, std::size_t begin) {
    std::vector<Candidate>& list = levels_[static_cast<std::size_t>(level)];
    std::sort(list.begin() + static_cast<std::ptrdiff_t>(begin), list.end(),
              [](const Candidate& a, const Candidate& b) {
                if (a.bound != b.bound) return a.bound > b.bound;
                if (a.rotation != b.rotation) return a.rotation < b.rotation;
                return a.dy != b.dy ? a.dy < b.dy : a.dx < b.dx;
              });
    for (std::size_t i = begin; i < list.size() && list[i].bound > best_.bound; ++i) {
      if (level == 0) {
        best_ = list[i];
        break;
      }
      const Candidate c = list[i];
      const int half = 1 << (level - 1);
      std::vector<Candidate>& children = levels_[static_cast<std::size_t>(level - 1)];
      const std::size_t first = children.size();
      for (int dy = c.dy; dy <= std::min(c.dy + half, reach_); dy += half)
        for (int dx = c.dx; dx <= std::min(c.dx + half, reach_); dx += half)
          consider(children, c.rotation, dx, dy, level - 1);
      descend(level - 1, first);
    }
    list.resize(begin);
  }

  const LikelihoodPyramid& pyramid_;
  const std::vector<Rotated>& rotations_;
  int reach_;
  Candidate best_{};
  std::array<std::vector<Candidate>, LikelihoodPyramid::kLevels> levels_;
  long evaluations_ = 0;
};

// Indices of the points used, and the range below which nine of ten of them lie.
struct Selection {
  std::vector<std::size_t> index;
  double range = 1;
};

Selection select(const ScanPoints& points, double radius, int max_points) {
  Selection s;
  std::vector<float> ranges;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float range = std::sqrt(points.x[i] * points.x[i] + points.y[i] * points.y[i]);
    if (range > static_cast<float>(radius)) continue;
    s.index.push_back(i);
    ranges.push_back(range);
  }
  if (s.index.empty()) return s;
  const auto most = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() * 9 / 10);
  std::nth_element(ranges.begin(), most, ranges.end());
  s.range = std::max<double>(*most, 1.0);
  const std::size_t stride = (s.index.size() + static_cast<std::size_t>(max_points) - 1) /
                             static_cast<std::size_t>(max_points);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s.index.size(); i += stride) s.index[kept++] = s.index[i];
  s.index.resize(kept);
  return s;
}

}  // namespace

double likelihood(const ScanPoints& points, const LikelihoodPyramid& pyramid,
                  const Pose2& T_map_robot, int max_points) {
  const Selection used = select(points, pyramid.options().radius, max_points);
  const double c = std::cos(T_map_robot.theta), s = std::sin(T_map_robot.theta);
  int sum = 0;
  for (const std::size_t i : used.index) {
    const int column = pyramid.column(T_map_robot.x + c * points.x[i] - s * points.y[i]);
    const int row = pyramid.row(T_map_robot.y + s * points.x[i] + c * points.y[i]);
    if (pyramid.near(column, row, 1 << LikelihoodPyramid::kLevels))
      sum += pyramid.level(0)[row * pyramid.width() + column];
  }
  return used.index.empty() ? 0 : sum / (255.0 * static_cast<double>(used.index.size()));
}

std::optional<CorrelativeMatch> search(const ScanPoints& points, const LikelihoodPyramid& pyramid,
                                       const Pose2& around, const SearchWindow& window,
                                       double min_score, int max_points) {
  const Selection used = select(points, pyramid.options().radius, max_points);
  if (used.index.empty()) return std::nullopt;
  const int reach = static_cast<int>(
      std::ceil(std::min(window.translation, pyramid.options().max_translation) / pyramid.cell()));
  const double step = 1.5 * pyramid.cell() / used.range;
  const int turns = static_cast<int>(std::ceil(window.rotation / step));
  std::vector<Rotated> rotations(static_cast<std::size_t>(2 * turns + 1));
  for (int k = -turns; k <= turns; ++k) {
    Rotated& r = rotations[static_cast<std::size_t>(k + turns)];
    r.theta = around.theta + k * step;
    r.cell.reserve(used.index.size());
    const double c = std::cos(r.theta), s = std::sin(r.theta);
    for (const std::size_t i : used.index) {
      const int column = pyramid.column(around.x + c * points.x[i] - s * points.y[i]);
      const int row = pyramid.row(around.y + s * points.x[i] + c * points.y[i]);
      if (pyramid.near(column, row, reach + (1 << LikelihoodPyramid::kLevels)))
        r.cell.push_back(row * pyramid.width() + column);
    }
  }
  const double full = 255.0 * static_cast<double>(used.index.size());
  BranchAndBound engine(pyramid, rotations, reach);
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
