// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/pose_histogram.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace majak::filter {
namespace {

constexpr int kSide = PoseLattice::kSide;
constexpr std::size_t kSlice = PoseLattice::kSlice;
constexpr float kNothing = 1e-30F;  // of a belief; smaller ones would only be slow

}  // namespace

PoseLattice::PoseLattice(double x, double y, double size, int width, int height, int turns)
    : x0(x),
      y0(y),
      cell(size),
      tiles_x((width + kSide - 1) / kSide),
      tiles_y((height + kSide - 1) / kSide),
      headings(turns),
      open(static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y)) {}

void PoseLattice::set_open(int ix, int iy) {
  open[tile(ix, iy)] |= std::uint64_t{1} << (iy % kSide * kSide + ix % kSide);
}

std::size_t PoseLattice::open_cells() const {
  return std::accumulate(
      open.begin(), open.end(), std::size_t{0},
      [](std::size_t n, std::uint64_t mask) { return n + std::size_t(std::popcount(mask)); });
}

Vec2 PoseLattice::corner(std::size_t tile) const {
  const auto wide = static_cast<std::size_t>(tiles_x);
  return {x0 + (static_cast<double>(tile % wide) * kSide + 0.5) * cell,
          y0 + (static_cast<double>(tile / wide) * kSide + 0.5) * cell};
}

PoseMotion PoseMotion::then(const PoseMotion& next) const {
  const Mat3 a = adjoint(next.T_from_to.inverse());
  return {T_from_to * next.T_from_to, a * covariance * a.transpose() + next.covariance};
}

/// A motion as kernels: along x and y for each heading that it starts from, and of the headings.
struct PoseHistogram::Shifts {
  struct Taps {
    int first;
    std::vector<float> taps;
    explicit Taps(const Kernel& kernel)
        : first(kernel.first), taps(kernel.taps.begin(), kernel.taps.end()) {}
    int size() const { return static_cast<int>(taps.size()); }
    int reach() const { return std::max(std::abs(first), std::abs(first + size() - 1)); }
  };
  std::vector<Taps> x, y;
  Taps heading;
  int reach = 0;  // cells, along x and y

  Shifts(const PoseMotion& motion, const PoseLattice& lattice)
      : heading(motion_kernel(motion.T_from_to.theta / lattice.turn(),
                              motion.covariance(2, 2) / std::pow(lattice.turn(), 2))) {
    const double k = 1 / lattice.cell;
    for (int h = 0; h < lattice.headings; ++h) {
      const Eigen::Rotation2Dd from(lattice.heading(h)),
          to(lattice.heading(h) + motion.T_from_to.theta);
      const Vec2 shift = k * (from * motion.T_from_to.translation());
      const Eigen::Matrix2d noise = k * k * to.toRotationMatrix() *
                                    motion.covariance.topLeftCorner<2, 2>() *
                                    to.toRotationMatrix().transpose();
      x.emplace_back(motion_kernel(shift.x(), noise(0, 0)));
      y.emplace_back(motion_kernel(shift.y(), noise(1, 1)));
      reach = std::max({reach, x.back().reach(), y.back().reach()});
    }
  }
};

PoseHistogram::PoseHistogram(std::shared_ptr<const PoseLattice> lattice)
    : lattice_(std::move(lattice)), tiles_(lattice_->tiles()) {}

void PoseHistogram::move(const PoseMotion& motion, Threads threads) {
  const Shifts shifts(motion, *lattice_);
  // Tiles that mass can come to.
  const int wide = lattice_->tiles_x, high = lattice_->tiles_y;
  const int reach = (shifts.reach + kSide - 1) / kSide;
  std::vector<std::uint8_t> reached(tiles_.size());
  for (const std::size_t i : held()) {
    const int tx = static_cast<int>(i) % wide, ty = static_cast<int>(i) / wide;
    for (int y = std::max(0, ty - reach); y <= std::min(high - 1, ty + reach); ++y)
      for (int x = std::max(0, tx - reach); x <= std::min(wide - 1, tx + reach); ++x)
        reached[static_cast<std::size_t>(y * wide + x)] = 1;
  }
  std::vector<std::size_t> to;
  for (std::size_t i = 0; i < tiles_.size(); ++i)
    if (reached[i] != 0 && lattice_->open[i] != 0) to.push_back(i);
  std::vector<std::vector<float>> moved(tiles_.size());
  parallel_for(threads, to.size(),
               [&](std::size_t i) { moved[to[i]] = moved_into(to[i], shifts); });
  tiles_ = std::move(moved);
}

// Columns x ... x + width of a heading, and as many rows; 0 where there is nothing.
void PoseHistogram::gather(std::size_t heading, int x, int y, int width, int height,
                           float* patch) const {
  std::fill(patch, patch + width * height, 0.0F);
  const int x_begin = std::max(x, 0), x_end = std::min(x + width, lattice_->tiles_x * kSide);
  const int y_begin = std::max(y, 0), y_end = std::min(y + height, lattice_->tiles_y * kSide);
  if (x_begin >= x_end || y_begin >= y_end) return;
  for (int ty = y_begin / kSide; ty * kSide < y_end; ++ty)
    for (int tx = x_begin / kSide; tx * kSide < x_end; ++tx) {
      const std::vector<float>& tile =
          tiles_[static_cast<std::size_t>(ty * lattice_->tiles_x + tx)];
      if (tile.empty()) continue;
      const float* slice = tile.data() + heading * kSlice;
      const int left = std::max(x_begin, tx * kSide), right = std::min(x_end, (tx + 1) * kSide);
      for (int row = std::max(y_begin, ty * kSide); row < std::min(y_end, (ty + 1) * kSide); ++row)
        std::copy(slice + (row % kSide) * kSide + left % kSide,
                  slice + (row % kSide) * kSide + left % kSide + (right - left),
                  patch + (row - y) * width + (left - x));
    }
}

std::vector<float> PoseHistogram::moved_into(std::size_t tile, const Shifts& shifts) const {
  const int x0 = static_cast<int>(tile) % lattice_->tiles_x * kSide;
  const int y0 = static_cast<int>(tile) / lattice_->tiles_x * kSide;
  const auto headings = static_cast<std::size_t>(lattice_->headings);
  std::vector<float> placed(headings * kSlice), patch, rows;
  for (std::size_t h = 0; h < headings; ++h) {
    const auto &kx = shifts.x[h], &ky = shifts.y[h];
    const int width = kSide + kx.size() - 1, height = kSide + ky.size() - 1;
    patch.resize(static_cast<std::size_t>(width * height));
    gather(h, x0 - kx.first - kx.size() + 1, y0 - ky.first - ky.size() + 1, width, height,
           patch.data());
    if (std::all_of(patch.begin(), patch.end(), [](float p) { return p == 0; })) continue;
    rows.assign(static_cast<std::size_t>(height * kSide), 0);
    for (int r = 0; r < height; ++r)
      for (int k = 0; k < kx.size(); ++k) {
        const float tap = kx.taps[static_cast<std::size_t>(k)];
        const float* from = patch.data() + r * width + kx.size() - 1 - k;
        float* out = rows.data() + r * kSide;
        for (int c = 0; c < kSide; ++c) out[c] += tap * from[c];
      }
    float* out = placed.data() + h * kSlice;
    for (int k = 0; k < ky.size(); ++k) {
      const float tap = ky.taps[static_cast<std::size_t>(k)];
      const float* from = rows.data() + (ky.size() - 1 - k) * kSide;
      for (std::size_t c = 0; c < kSlice; ++c) out[c] += tap * from[c];
    }
  }
  std::vector<float> moved(headings * kSlice);
  float most = 0;
  const int n = lattice_->headings;
  for (int h = 0; h < n; ++h) {
    float* out = moved.data() + static_cast<std::size_t>(h) * kSlice;
    for (int k = 0; k < shifts.heading.size(); ++k) {
      const float tap = shifts.heading.taps[static_cast<std::size_t>(k)];
      const int from = (((h - shifts.heading.first - k) % n) + n) % n;
      const float* in = placed.data() + static_cast<std::size_t>(from) * kSlice;
      for (std::size_t c = 0; c < kSlice; ++c) out[c] += tap * in[c];
    }
    for (std::size_t c = 0; c < kSlice; ++c) {
      if ((lattice_->open[tile] >> c & 1) == 0 || out[c] < kNothing) out[c] = 0;
      most = std::max(most, out[c]);
    }
  }
  if (most == 0) moved.clear();
  return moved;
}

void PoseHistogram::add_uniform(double mass) {
  const auto n = static_cast<std::size_t>(lattice_->headings);
  const auto p =
      static_cast<float>(mass / (static_cast<double>(lattice_->open_cells()) * lattice_->headings));
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const std::uint64_t open = lattice_->open[i];
    if (open == 0) continue;
    tiles_[i].resize(n * kSlice);
    for (std::size_t c = 0; c < tiles_[i].size(); ++c)
      if ((open >> c % kSlice & 1) != 0) tiles_[i][c] += p;
  }
}

void PoseHistogram::add(const PoseHistogram& other, double factor) {
  for (const std::size_t i : other.held()) {
    tiles_[i].resize(other.tiles_[i].size());
    for (std::size_t c = 0; c < tiles_[i].size(); ++c)
      tiles_[i][c] += static_cast<float>(factor) * other.tiles_[i][c];
  }
}

void PoseHistogram::scale(double factor) {
  for (std::vector<float>& tile : tiles_)
    for (float& p : tile) p *= static_cast<float>(factor);
}

double PoseHistogram::mass() const {
  double sum = 0;
  for (const std::vector<float>& tile : tiles_) {
    double lanes[kSide] = {};  // added up side by side
    for (std::size_t c = 0; c < tile.size(); c += kSide)
      for (std::size_t k = 0; k < kSide; ++k) lanes[k] += tile[c + k];
    sum = std::accumulate(lanes, lanes + kSide, sum);
  }
  return sum;
}

double PoseHistogram::entropy() const {
  const double all = mass();
  double sum = 0;
  for (const std::vector<float>& tile : tiles_)
    for (const float p : tile)
      if (p > 0) sum -= p / all * std::log(p / all);
  return sum;
}

float PoseHistogram::at(int ix, int iy, int heading) const {
  if (!lattice_->inside(ix, iy)) return 0;
  const std::vector<float>& tile = tiles_[lattice_->tile(ix, iy)];
  const int n = lattice_->headings, h = ((heading % n) + n) % n;
  return tile.empty() ? 0
                      : tile[static_cast<std::size_t>(h) * kSlice +
                             static_cast<std::size_t>(iy % kSide * kSide + ix % kSide)];
}

std::vector<std::size_t> PoseHistogram::held() const {
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < tiles_.size(); ++i)
    if (!tiles_[i].empty()) held.push_back(i);
  return held;
}

std::size_t PoseHistogram::bytes() const {
  return held().size() * static_cast<std::size_t>(lattice_->headings) * kSlice * sizeof(float);
}

}  // namespace majak::filter
