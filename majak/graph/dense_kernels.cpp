// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/dense_kernels.hpp"

#include <cmath>
#include <cstring>
#include <limits>

// One source, two machine codes: the loader picks by processor. No fused multiply-add in either.
#if defined(__x86_64__) && defined(__linux__)
#define MAJAK_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define MAJAK_CLONES
#endif

namespace majak::graph {
namespace {

using Vec4 = double __attribute__((vector_size(32)));

[[gnu::always_inline]] inline void load(Vec4& v, const double* p) { std::memcpy(&v, p, sizeof v); }
[[gnu::always_inline]] inline void store(double* p, const Vec4& v) { std::memcpy(p, &v, sizeof v); }

/// One tile of 4 * kVectors rows and 3 columns.
template <int kVectors>
[[gnu::always_inline]] inline void tile(const double* a, int a_stride, const double* b,
                                        int b_stride, int depth, double* c, int c_stride) {
  Vec4 sum[kVectors][3] = {};
  for (int k = 0; k < depth; ++k, a += a_stride, b += b_stride) {
    for (int v = 0; v < kVectors; ++v) {
      Vec4 rows;
      load(rows, a + 4 * v);
      for (int j = 0; j < 3; ++j) sum[v][j] += rows * b[j];
    }
  }
  for (int j = 0; j < 3; ++j) {
    for (int v = 0; v < kVectors; ++v) {
      Vec4 old;
      load(old, c + j * c_stride + 4 * v);
      old -= sum[v][j];
      store(c + j * c_stride + 4 * v, old);
    }
  }
}

[[gnu::always_inline]] inline void product(Panel a, Panel b, int depth, double* c, int c_stride,
                                           int rows, int cols, bool lower) {
  for (int j = 0; j < cols; j += 3) {
    int i = lower ? j & ~3 : 0;
    double* column = c + static_cast<long>(j) * c_stride;
    for (; i + 8 <= rows; i += 8)
      tile<2>(a.data + i, a.stride, b.data + j, b.stride, depth, column + i, c_stride);
    for (; i < rows; i += 4)
      tile<1>(a.data + i, a.stride, b.data + j, b.stride, depth, column + i, c_stride);
  }
}

/// Three columns that all earlier ones have been subtracted from, rows [first, rows).
[[gnu::always_inline]] inline bool factor_three(double* p, int stride, int first, int rows) {
  double *c0 = p, *c1 = p + stride, *c2 = p + 2 * static_cast<long>(stride);
  const double d0 = c0[first];
  const double i0 = 1.0 / std::sqrt(d0), l10 = c0[first + 1] * i0, l20 = c0[first + 2] * i0;
  const double d1 = c1[first + 1] - l10 * l10;
  const double i1 = 1.0 / std::sqrt(d1), l21 = (c1[first + 2] - l20 * l10) * i1;
  const double d2 = c2[first + 2] - l20 * l20 - l21 * l21;
  const double i2 = 1.0 / std::sqrt(d2);
  const double largest = std::numeric_limits<double>::max();
  if (!(d0 > 0 && d1 > 0 && d2 > 0 && d0 <= largest && d1 <= largest && d2 <= largest))
    return false;
  // Whole vectors counted from the end; what they spoil of the three diagonal rows is put back.
  for (int i = rows - ((rows - first) & ~3); i < rows; i += 4) {
    Vec4 x0, x1, x2;
    load(x0, c0 + i), load(x1, c1 + i), load(x2, c2 + i);
    x0 *= i0;
    x1 = (x1 - x0 * l10) * i1;
    x2 = (x2 - x0 * l20 - x1 * l21) * i2;
    store(c0 + i, x0), store(c1 + i, x1), store(c2 + i, x2);
  }
  c0[first] = d0 * i0, c0[first + 1] = l10, c0[first + 2] = l20;
  c1[first + 1] = d1 * i1, c1[first + 2] = l21;
  c2[first + 2] = d2 * i2;
  return true;
}

}  // namespace

MAJAK_CLONES
void subtract_product(Panel a, Panel b, int depth, double* c, int c_stride, int rows, int cols) {
  product(a, b, depth, c, c_stride, rows, cols, false);
}

MAJAK_CLONES
void subtract_product_lower(Panel a, Panel b, int depth, double* c, int c_stride, int rows,
                            int cols) {
  product(a, b, depth, c, c_stride, rows, cols, true);
}

MAJAK_CLONES
bool factor_panel(double* panel, int rows, int width) {
  for (int j = 0; j < width; j += 3) {
    double* column = panel + static_cast<long>(j) * rows;
    if (j > 0) {
      // Whole vectors counted from the end: up to three rows above the diagonal are scratch.
      const int count = (rows - j + 3) & ~3, top = rows - count;
      product({panel + top, rows}, {panel + j, rows}, j, column + top, rows, count, 3, false);
    }
    if (!factor_three(column, rows, j, rows)) return false;
  }
  return true;
}

MAJAK_CLONES
void solve_lower(const double* panel, int stride, int width, double* top, double* below) {
  for (int k = 0; k < width; k += 3) {
    const double *c0 = panel + static_cast<long>(k) * stride, *c1 = c0 + stride, *c2 = c1 + stride;
    const double x0 = top[k] / c0[k], x1 = (top[k + 1] - c0[k + 1] * x0) / c1[k + 1];
    const double x2 = (top[k + 2] - c0[k + 2] * x0 - c1[k + 2] * x1) / c2[k + 2];
    top[k] = x0, top[k + 1] = x1, top[k + 2] = x2;
    for (int i = k + 3; i < width; ++i) top[i] -= c0[i] * x0 + c1[i] * x1 + c2[i] * x2;
    for (int i = width; i < stride; i += 4) {
      Vec4 l0, l1, l2, sum;
      load(l0, c0 + i), load(l1, c1 + i), load(l2, c2 + i), load(sum, below + i - width);
      sum += l0 * x0 + l1 * x1 + l2 * x2;
      store(below + i - width, sum);
    }
  }
}

MAJAK_CLONES
void solve_upper(const double* panel, int stride, int width, double* top, const double* below) {
  for (int k = width - 3; k >= 0; k -= 3) {
    const double *c0 = panel + static_cast<long>(k) * stride, *c1 = c0 + stride, *c2 = c1 + stride;
    Vec4 s0 = {}, s1 = {}, s2 = {};
    for (int i = width; i < stride; i += 4) {
      Vec4 l0, l1, l2, x;
      load(l0, c0 + i), load(l1, c1 + i), load(l2, c2 + i), load(x, below + i - width);
      s0 += l0 * x, s1 += l1 * x, s2 += l2 * x;
    }
    double y0 = top[k] - (s0[0] + s0[1] + s0[2] + s0[3]);
    double y1 = top[k + 1] - (s1[0] + s1[1] + s1[2] + s1[3]);
    double y2 = top[k + 2] - (s2[0] + s2[1] + s2[2] + s2[3]);
    for (int i = k + 3; i < width; ++i)
      y0 -= c0[i] * top[i], y1 -= c1[i] * top[i], y2 -= c2[i] * top[i];
    top[k + 2] = y2 /= c2[k + 2];
    top[k + 1] = y1 = (y1 - c1[k + 2] * y2) / c1[k + 1];
    top[k] = (y0 - c0[k + 1] * y1 - c0[k + 2] * y2) / c0[k];
  }
}

}  // namespace majak::graph
