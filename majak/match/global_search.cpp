// SPDX-License-Identifier: Apache-2.0
#include "majak/match/global_search.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/simd.hpp"

namespace majak::match {
namespace {

constexpr double kUnit = 1.0 / 32;   // nat, of the costs
constexpr double kAngleCells = 1.5;  // cells by which nine returns of ten move in a step of heading

MAJAK_VECTORIZED void add_row(const std::uint8_t* costs, int n, std::uint16_t* sums) {
  for (int i = 0; i < n; ++i) sums[i] = static_cast<std::uint16_t>(sums[i] + costs[i]);
}

MAJAK_VECTORIZED void least_of(const std::uint8_t* a, const std::uint8_t* b, int n,
                               std::uint8_t* out) {
  for (int i = 0; i < n; ++i) out[i] = std::min(a[i], b[i]);
}

}  // namespace

struct GlobalSearch::Rotated {
  double heading = 0;
  std::vector<int> column, row;  // of each return, from the robot's cell
};

struct GlobalSearch::Block {
  std::uint16_t heading;
  std::uint8_t level;
  std::int32_t column, row;
};

/// Blocks by their bound, which is a small integer.
struct GlobalSearch::Queue {
  std::vector<std::vector<Block>> by_cost;
  std::size_t least = 0;

  explicit Queue(std::size_t highest) : by_cost(highest + 1) {}
  void push(std::uint32_t cost, const Block& block) { by_cost[cost].push_back(block); }
  bool pop(Block& block, std::uint32_t& cost) {
    while (least < by_cost.size() && by_cost[least].empty()) ++least;
    if (least == by_cost.size()) return false;
    cost = static_cast<std::uint32_t>(least);
    block = by_cost[least].back();
    by_cost[least].pop_back();
    return true;
  }
};

GlobalSearch::GlobalSearch(const map::KnownMap& map, const map::DistanceField& distances,
                           const GlobalSearchOptions& options)
    : options_(options) {
  const int n = std::max(1, static_cast<int>(std::lround(options.cell / map.resolution)));
  cell_ = n * map.resolution;
  x0_ = map.x0, y0_ = map.y0;
  columns_ = (map.width + n * kBlock - 1) / (n * kBlock);
  rows_ = (map.height + n * kBlock - 1) / (n * kBlock);
  width_ = columns_ * kBlock, height_ = rows_ * kBlock;
  margin_ = (static_cast<int>(std::ceil(options.reach / cell_)) / kBlock + 2) * kBlock;
  stride_ = static_cast<std::size_t>(width_ + 2 * margin_);

  const auto byte = [&](double distance) {
    const double d = distance / options.sigma;
    const double p = std::exp(-d * d / 2) * (1 - options.random) + options.random;
    return static_cast<std::uint8_t>(std::min(255.0, std::round(-std::log(p) / kUnit)));
  };
  outside_ = byte(1e9);
  const std::size_t padded_rows = static_cast<std::size_t>(height_ + 2 * margin_);
  least_[0].assign(stride_ * padded_rows, outside_);
  free_[0].assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  for (int iy = 0; iy < map.height; ++iy)
    for (int ix = 0; ix < map.width; ++ix) {
      const auto column = static_cast<std::size_t>(ix / n), row = static_cast<std::size_t>(iy / n);
      std::uint8_t& least = least_[0][(row + static_cast<std::size_t>(margin_)) * stride_ + column +
                                      static_cast<std::size_t>(margin_)];
      least = std::min(least, byte(distances.at(ix, iy)));
      free_[0][row * static_cast<std::size_t>(width_) + column] |=
          map.at(ix, iy) == map::CellState::free;
    }
  for (int l = 1; l < kLevels; ++l) {
    const std::size_t half = std::size_t{1} << (l - 1);
    least_[l] = least_[l - 1];
    std::vector<std::uint8_t> row(stride_);
    for (std::size_t r = 0; r < padded_rows; ++r) {
      const std::uint8_t* a = least_[l - 1].data() + r * stride_;
      const std::uint8_t* b = r + half < padded_rows ? a + half * stride_ : a;
      least_of(a, b, static_cast<int>(stride_), row.data());
      std::uint8_t* out = least_[l].data() + r * stride_;
      std::copy(row.begin(), row.end(), out);
      least_of(row.data(), row.data() + half, static_cast<int>(stride_ - half), out);
    }
    free_[l] = free_[l - 1];
    for (int r = 0; r < height_; r += 1 << l)
      for (int c = 0; c < width_; c += 1 << l) {
        bool any = false;
        for (const int dr : {0, static_cast<int>(half)})
          for (const int dc : {0, static_cast<int>(half)})
            any |= free_within(l - 1, c + dc, r + dr);
        free_[l][static_cast<std::size_t>(r) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(c)] = any;
      }
  }
  // Blocks lie eight cells apart; for one return all of them ask for the same offset within eight.
  const std::size_t wide = stride_ / kBlock, high = padded_rows / kBlock;
  by_phase_.resize(least_[kTop].size());
  for (std::size_t phase_y = 0; phase_y < kBlock; ++phase_y)
    for (std::size_t phase_x = 0; phase_x < kBlock; ++phase_x)
      for (std::size_t r = 0; r < high; ++r)
        for (std::size_t c = 0; c < wide; ++c)
          by_phase_[((phase_y * kBlock + phase_x) * high + r) * wide + c] =
              least_[kTop][(r * kBlock + phase_y) * stride_ + c * kBlock + phase_x];
}

std::size_t GlobalSearch::bytes() const {
  std::size_t sum = by_phase_.size();
  for (int l = 0; l < kLevels; ++l) sum += least_[l].size() + free_[l].size();
  return sum;
}

bool GlobalSearch::free_within(int level, int column, int row) const {
  return free_[level][static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(column)] != 0;
}

// The returns within reach, spread evenly, in all headings.
std::vector<GlobalSearch::Rotated> GlobalSearch::rotate(const Beams& beams) const {
  std::vector<std::size_t> within;
  std::vector<double> far;
  for (std::size_t i = 0; i < beams.returns; ++i)
    if (std::hypot(beams.x[i], beams.y[i]) < options_.reach) within.push_back(i);
  const std::size_t n = std::min(within.size(), static_cast<std::size_t>(options_.returns));
  if (n == 0) return {};
  std::vector<Vec2> points;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = within[(2 * k + 1) * within.size() / (2 * n)];
    points.emplace_back(beams.x[i], beams.y[i]);
    far.push_back(points.back().norm());
  }
  std::nth_element(far.begin(), far.begin() + static_cast<std::ptrdiff_t>(n * 9 / 10), far.end());
  const double step = kAngleCells * cell_ / std::max(1.0, far[n * 9 / 10]);
  const int headings = std::min(20000, static_cast<int>(std::ceil(2 * kPi / step)));
  std::vector<Rotated> all(static_cast<std::size_t>(headings));
  for (int h = 0; h < headings; ++h) {
    Rotated& rotated = all[static_cast<std::size_t>(h)];
    rotated.heading = wrap_angle(2 * kPi * h / headings);
    const double c = std::cos(rotated.heading), s = std::sin(rotated.heading);
    for (const Vec2& p : points) {
      // From the middle of the robot's cell.
      rotated.column.push_back(static_cast<int>(std::floor((c * p.x() - s * p.y()) / cell_ + 0.5)));
      rotated.row.push_back(static_cast<int>(std::floor((s * p.x() + c * p.y()) / cell_ + 0.5)));
    }
  }
  return all;
}

// Bounds of all blocks of the top level in one heading.
void GlobalSearch::bound_all(const Rotated& returns, std::uint16_t* sums) const {
  const std::size_t wide = stride_ / kBlock;
  const std::size_t high = by_phase_.size() / (static_cast<std::size_t>(kBlock * kBlock) * wide);
  std::fill(sums, sums + static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
            std::uint16_t{0});
  for (std::size_t k = 0; k < returns.column.size(); ++k) {
    const int x = returns.column[k] + margin_, y = returns.row[k] + margin_;
    const auto phase = static_cast<std::size_t>((y % kBlock) * kBlock + x % kBlock);
    const std::uint8_t* from = by_phase_.data() +
                               (phase * high + static_cast<std::size_t>(y / kBlock)) * wide +
                               static_cast<std::size_t>(x / kBlock);
    for (int r = 0; r < rows_; ++r)
      add_row(from + static_cast<std::size_t>(r) * wide, columns_,
              sums + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_));
  }
}

std::uint32_t GlobalSearch::cost(const Rotated& returns, int level, int column, int row) const {
  const std::uint8_t* at = least_[level].data() +
                           static_cast<std::size_t>(row + margin_) * stride_ +
                           static_cast<std::size_t>(column + margin_);
  const auto stride = static_cast<std::ptrdiff_t>(stride_);
  std::uint32_t sum = 0;
  for (std::size_t k = 0; k < returns.column.size(); ++k)
    sum += at[returns.row[k] * stride + returns.column[k]];
  return sum;
}

GlobalSearchResult GlobalSearch::find(const Beams& beams) const {
  GlobalSearchResult result;
  const std::vector<Rotated> headings = rotate(beams);
  if (headings.empty()) return result;
  const std::size_t n = headings.front().column.size();
  const auto worst = static_cast<std::uint32_t>(n * outside_);
  const auto fit = [&](std::uint32_t cost) {
    return std::exp(-kUnit * cost / static_cast<double>(n));
  };

  // Every block by its bound; those that are beyond the budget anyway are not kept.
  const std::size_t blocks = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  std::vector<std::uint16_t> sums(blocks * headings.size());
  std::vector<std::size_t> histogram(worst + 1);
  for (std::size_t h = 0; h < headings.size(); ++h) {
    std::uint16_t* of_heading = sums.data() + h * blocks;
    bound_all(headings[h], of_heading);
    for (std::size_t b = 0; b < blocks; ++b) {
      const int c = static_cast<int>(b) % columns_ * kBlock,
                r = static_cast<int>(b) / columns_ * kBlock;
      if (free_within(kTop, c, r)) ++histogram[of_heading[b]];
    }
  }
  std::uint32_t limit = 0;
  for (std::size_t kept = 0; limit < worst; ++limit) {
    kept += histogram[limit];
    if (kept > static_cast<std::size_t>(options_.blocks)) break;
  }
  Queue queue(worst);
  for (std::size_t h = 0; h < headings.size(); ++h)
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::uint16_t bound = sums[h * blocks + b];
      if (bound >= limit) continue;
      const int c = static_cast<int>(b) % columns_ * kBlock,
                r = static_cast<int>(b) / columns_ * kBlock;
      if (free_within(kTop, c, r)) queue.push(bound, {static_cast<std::uint16_t>(h), kTop, c, r});
    }

  const auto pose_of = [&](const Block& block) {
    const double half = 0.5 * (1 << block.level);
    return Pose2{x0_ + (block.column + half) * cell_, y0_ + (block.row + half) * cell_,
                 headings[block.heading].heading};
  };
  // Does all of a block belong to a place that is told already?
  const auto told = [&](const Block& block) {
    const Pose2 pose = pose_of(block);
    const double reach = std::sqrt(0.5) * ((1 << block.level) - 1) * cell_;
    return std::any_of(result.places.begin(), result.places.end(), [&](const FittingPlace& place) {
      return (place.T_map_robot.translation() - pose.translation()).norm() + reach <
                 options_.apart &&
             std::abs(angle_diff(place.T_map_robot.theta, pose.theta)) < options_.apart_turn;
    });
  };

  Block block{};
  std::uint32_t bound = 0;
  while (queue.pop(block, bound)) {
    if (!result.places.empty() && fit(bound) < result.places.front().fit - options_.worse) break;
    if (told(block)) continue;
    if (block.level == 0) {
      result.places.push_back({pose_of(block), fit(bound)});
      if (static_cast<int>(result.places.size()) == options_.most) break;
      continue;
    }
    if (result.evaluated > static_cast<std::size_t>(options_.blocks)) {
      result.complete = false;
      break;
    }
    const int half = 1 << (block.level - 1);
    for (const int dr : {0, half})
      for (const int dc : {0, half}) {
        Block child{block.heading, static_cast<std::uint8_t>(block.level - 1), block.column + dc,
                    block.row + dr};
        if (!free_within(child.level, child.column, child.row)) continue;
        ++result.evaluated;
        queue.push(cost(headings[child.heading], child.level, child.column, child.row), child);
      }
  }
  return result;
}

}  // namespace majak::match
