// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/dense_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

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

/// Three columns that all earlier ones have been subtracted from.
[[gnu::always_inline]] inline bool factor_three(double* p, int stride, int first, int rows) {
  for (int k = 0; k < 3; ++k) {
    double* column = p + static_cast<long>(k) * stride;
    const double pivot = column[first + k];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    const double root = std::sqrt(pivot), inverse = 1.0 / root;
    column[first + k] = root;
    for (int i = first + k + 1; i < rows; ++i) column[i] *= inverse;
    for (int j = k + 1; j < 3; ++j) {
      double* other = p + static_cast<long>(j) * stride;
      const double factor = column[first + j];
      for (int i = first + j; i < rows; ++i) other[i] -= column[i] * factor;
    }
  }
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

}  // namespace majak::graph
