// SPDX-License-Identifier: Apache-2.0
#include "majak/match/likelihood_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define MAJAK_X86
#endif

namespace majak::match {
namespace {

/// What the inner loop needs, in cells of the grid with its margin.
struct Field {
  const std::uint8_t* costs;
  int width;
  float last_x, last_y;  // the last column and row
};
/// Where a pose moves points to: p -> (x + c px - s py, y + s px + c py), all in cells.
struct Placed {
  float x, y, c, s;
};

std::uint32_t sum_of(const Field& f, const float* px, const float* py, std::size_t n,
                     const Placed& at) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float x = at.x + (at.c * px[i] - at.s * py[i]);
    const float y = at.y + (at.s * px[i] + at.c * py[i]);
    const int ix = static_cast<int>(std::min(std::max(x, 0.0F), f.last_x));
    const int iy = static_cast<int>(std::min(std::max(y, 0.0F), f.last_y));
    sum += f.costs[iy * f.width + ix];
  }
  return sum;
}

#ifdef MAJAK_X86
// The same with the cells of eight returns worked out at a time. They are then looked up one by
// one, which on many processors is faster than the gather instruction.
__attribute__((target("avx2"))) std::uint32_t sum_by_eights(const Field& f, const float* px,
                                                            const float* py, std::size_t n,
                                                            const Placed& at) {
  const __m256 c = _mm256_set1_ps(at.c), s = _mm256_set1_ps(at.s), zero = _mm256_setzero_ps();
  const __m256 x0 = _mm256_set1_ps(at.x), y0 = _mm256_set1_ps(at.y);
  const __m256 last_x = _mm256_set1_ps(f.last_x), last_y = _mm256_set1_ps(f.last_y);
  const __m256i width = _mm256_set1_epi32(f.width);
  // Cells of eight returns from i on; those past the last are not to be looked at.
  alignas(32) std::uint32_t cells[8];
  const auto find_cells = [&](__m256 bx, __m256 by) __attribute__((target("avx2"))) {
    const __m256 x = _mm256_add_ps(x0, _mm256_sub_ps(_mm256_mul_ps(c, bx), _mm256_mul_ps(s, by)));
    const __m256 y = _mm256_add_ps(y0, _mm256_add_ps(_mm256_mul_ps(s, bx), _mm256_mul_ps(c, by)));
    const __m256i ix = _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(x, zero), last_x));
    const __m256i iy = _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(y, zero), last_y));
    _mm256_store_si256(reinterpret_cast<__m256i*>(cells),
                       _mm256_add_epi32(_mm256_mullo_epi32(iy, width), ix));
  };
  std::uint32_t even = 0, odd = 0;
  std::size_t i = 0;
  for (; i + 8 <= n; i += 8) {
    find_cells(_mm256_loadu_ps(px + i), _mm256_loadu_ps(py + i));
    for (int k = 0; k < 8; k += 2) {
      even += f.costs[cells[k]];
      odd += f.costs[cells[k + 1]];
    }
  }
  const int rest = static_cast<int>(n - i);
  const __m256i mask =
      _mm256_cmpgt_epi32(_mm256_set1_epi32(rest), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  find_cells(_mm256_maskload_ps(px + i, mask), _mm256_maskload_ps(py + i, mask));
  for (int k = 0; k < rest; ++k) even += f.costs[cells[k]];
  return even + odd;
}
#endif

using SumOf = std::uint32_t (*)(const Field&, const float*, const float*, std::size_t,
                                const Placed&);

SumOf fastest() {
#ifdef MAJAK_X86
  if (__builtin_cpu_supports("avx2")) return sum_by_eights;
#endif
  return sum_of;
}

}  // namespace

void PoseArrays::set(std::size_t i, const Pose2& p) {
  x[i] = static_cast<float>(p.x);
  y[i] = static_cast<float>(p.y);
  cos[i] = static_cast<float>(std::cos(p.theta));
  sin[i] = static_cast<float>(std::sin(p.theta));
}

LikelihoodField::LikelihoodField(const map::KnownMap& map, const map::DistanceField& distances,
                                 const LikelihoodFieldOptions& options)
    : options_(options),
      x0_(static_cast<float>(map.x0 - map.resolution)),
      y0_(static_cast<float>(map.y0 - map.resolution)),
      inverse_resolution_(static_cast<float>(1 / map.resolution)),
      width_(map.width + 2),
      height_(map.height + 2) {
  const double peak = options.hit / (options.sigma * std::sqrt(2 * std::numbers::pi));
  const double floor = options.random / options.range;
  const auto byte = [&](double distance) {
    const double d = std::max(0.0, distance - options.slack) / options.sigma;
    const double p = (peak * std::exp(-d * d / 2) + floor) / (peak + floor);
    return static_cast<std::uint8_t>(std::min(255.0, std::round(-std::log(p) / kUnit)));
  };
  outside_ = byte(1e9);
  costs_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), outside_);
  for (int iy = 0; iy < map.height; ++iy)
    for (int ix = 0; ix < map.width; ++ix)
      costs_[static_cast<std::size_t>(iy + 1) * static_cast<std::size_t>(width_) +
             static_cast<std::size_t>(ix + 1)] = byte(distances.at(ix, iy));
}

std::size_t LikelihoodField::cell(float x, float y) const {
  const auto within = [&](float v, int n) {
    return static_cast<std::size_t>(std::min(std::max(v, 0.0F), static_cast<float>(n - 1)));
  };
  return within((y - y0_) * inverse_resolution_, height_) * static_cast<std::size_t>(width_) +
         within((x - x0_) * inverse_resolution_, width_);
}

void LikelihoodField::costs(const Beams& beams, const PoseArrays& poses, std::size_t begin,
                            std::size_t end, std::uint32_t* sums) const {
  static const SumOf sum = fastest();
  const Field field{costs_.data(), width_, static_cast<float>(width_ - 1),
                    static_cast<float>(height_ - 1)};
  const float k = inverse_resolution_;
  for (std::size_t i = begin; i < end; ++i)
    sums[i] =
        sum(field, beams.x.data(), beams.y.data(), beams.returns,
            {(poses.x[i] - x0_) * k, (poses.y[i] - y0_) * k, poses.cos[i] * k, poses.sin[i] * k});
}

}  // namespace majak::match
