// SPDX-License-Identifier: Apache-2.0
// The dense loops in which the sparse factorisation spends its time. Column-major. Every element
// is a sum in one fixed order, so the bytes do not depend on the width of the vector unit.
#pragma once

namespace majak::graph {

/// C -= A * B^T. A is rows x depth, B is cols x depth, C is rows x cols; rows is a multiple of 4,
/// cols of 3.
struct Panel {
  const double* data;
  int stride;
};
void subtract_product(Panel a, Panel b, int depth, double* c, int c_stride, int rows, int cols);

/// The same where only the lower triangle of C is wanted (entries above it may be written too).
void subtract_product_lower(Panel a, Panel b, int depth, double* c, int c_stride, int rows,
                            int cols);

/// Cholesky of a tall panel of `rows` x `width`: its upper square becomes L (lower triangle), the
/// rest becomes rest * L^-T. The strict upper triangle is scratch. `rows` is the stride too and
/// rows - width is a multiple of 4. False where a pivot is not positive.
bool factor_panel(double* panel, int rows, int width);

/// With L = [T; B] a factored panel of `stride` x `width`: top = T^-1 top, below += B top.
void solve_lower(const double* panel, int stride, int width, double* top, double* below);
/// top = T^-T (top - B' below).
void solve_upper(const double* panel, int stride, int width, double* top, const double* below);

}  // namespace majak::graph
