// SPDX-License-Identifier: Apache-2.0
// The numerical half of BlockCholesky: factor, solve, inverse.
#include "majak/graph/block_cholesky.hpp"

#include <Eigen/Core>
#include <algorithm>

#include "majak/graph/dense_kernels.hpp"

namespace majak::graph {

void BlockCholesky::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

void BlockCholesky::assemble(const Supernode& s, double damping, double* panel) const {
  const std::size_t stride = s.stride();
  std::fill_n(panel, stride * 3 * s.width, 0.0);
  for (int e = s.entry_begin; e < s.entry_end; ++e) {
    const Entry& entry = entries_[e];
    const double* from = values_.data() + 9 * static_cast<std::size_t>(entry.block);
    double* to = panel + 3 * entry.row + stride * 3 * entry.column;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) to[r + stride * c] = from[r + 3 * c];
    if (damping > 0 && entry.block < n_)
      for (int c = 0; c < 3; ++c)
        to[c + stride * c] += damping * std::max(to[c + stride * c], smallest_);
  }
}

/// Extend-add: the child's update matrix into the parent's panel and update matrix.
void BlockCholesky::add_child(const Supernode& child, const Supernode& s, const double* update,
                              double* panel, double* front) const {
  const int count = child.rows - child.width;
  const int* where = to_parent_.data() + child.row_begin + child.width;
  const std::size_t from_stride = child.update_stride();
  for (int j = 0; j < count; ++j) {
    const bool own = where[j] < s.width;
    const std::size_t stride = own ? s.stride() : s.update_stride();
    double* column = own ? panel + stride * 3 * where[j]
                         : front + stride * 3 * (where[j] - s.width) - 3 * s.width;
    for (int c = 0; c < 3; ++c, column += stride) {
      const double* from = update + from_stride * (3 * j + c) + 3 * j;
      for (int i = j; i < count; ++i, from += 3) {
        double* to = column + 3 * where[i];
        to[0] += from[0];
        to[1] += from[1];
        to[2] += from[2];
      }
    }
  }
}

bool BlockCholesky::factor(double damping) {
  // A node at level d leaves its update on stack d % 2 and takes its children's from the other:
  // whatever lies on either stack above the children has been taken by then.
  std::size_t top[2] = {0, 0};
  smallest_ = 0;
  for (int i = 0; damping > 0 && i < n_; ++i)
    for (int r = 0; r < 3; ++r) smallest_ = std::max(smallest_, 1e-6 * diagonal(i)[4 * r]);
  for (const Supernode& s : supernodes_) {
    double* panel = factor_.data() + s.panel;
    assemble(s, damping, panel);
    const std::size_t stride = s.update_stride(), size = stride * s.below();
    std::vector<double>& mine = stack_[s.level % 2];
    std::size_t& my_top = top[s.level % 2];
    if (mine.size() < my_top + size) mine.resize(2 * (my_top + size));
    double* front = mine.data() + my_top;
    std::fill_n(front, size, 0.0);

    std::size_t& their_top = top[(s.level + 1) % 2];
    for (int c = s.child_end - 1; c >= s.child_begin; --c) {
      const Supernode& child = supernodes_[children_[c]];
      their_top -= static_cast<std::size_t>(child.update_stride()) * child.below();
      add_child(child, s, stack_[child.level % 2].data() + their_top, panel, front);
    }
    if (!factor_panel(panel, s.stride(), 3 * s.width)) return false;
    const Panel below{panel + 3 * s.width, s.stride()};
    subtract_product_lower(below, below, 3 * s.width, front, static_cast<int>(stride),
                           static_cast<int>(stride), s.below());
    my_top += size;
  }
  return true;
}

void BlockCholesky::solve(std::span<double> x) const {
  work_.resize(3 * static_cast<std::size_t>(n_));
  double* y = work_.data();
  for (int k = 0; k < n_; ++k) std::copy_n(&x[3 * order_[k]], 3, y + 3 * k);
  std::vector<double>& below = below_;
  for (const Supernode& s : supernodes_) {
    below.assign(s.update_stride(), 0.0);
    solve_lower(factor_.data() + s.panel, s.stride(), 3 * s.width, y + 3 * s.first, below.data());
    const double* from = below.data();
    for (const int row : rows(s).subspan(s.width))
      for (int r = 0; r < 3; ++r) y[3 * row + r] -= *from++;
  }
  for (auto s = supernodes_.rbegin(); s != supernodes_.rend(); ++s) {
    below.assign(s->update_stride(), 0.0);
    double* to = below.data();
    for (const int row : rows(*s).subspan(s->width))
      for (int r = 0; r < 3; ++r) *to++ = y[3 * row + r];
    solve_upper(factor_.data() + s->panel, s->stride(), 3 * s->width, y + 3 * s->first,
                below.data());
  }
  for (int k = 0; k < n_; ++k) std::copy_n(y + 3 * k, 3, &x[3 * order_[k]]);
}

/// Top down. With L = [T; B] of a supernode, S the inverse in the rows of B (part of the parent's
/// rows, so known already) and Y = B T^-1, the inverse there is [T^-T T^-1 + Y' S Y, .; -S Y, S].
std::vector<Mat3> BlockCholesky::inverse_diagonal() const {
  std::vector<Mat3> result(n_);
  std::vector<Eigen::MatrixXd> inverse(supernodes_.size());  // over all rows of a supernode
  for (std::size_t index = supernodes_.size(); index-- > 0;) {
    const Supernode& s = supernodes_[index];
    const int width = 3 * s.width, below = s.below();
    const Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> panel(
        factor_.data() + s.panel, width + below, width, Eigen::OuterStride<>(s.stride()));
    const auto top = panel.topRows(width).triangularView<Eigen::Lower>();
    Eigen::MatrixXd& z = inverse[index];
    z.setZero(width + below, width + below);

    const Eigen::MatrixXd top_inverse = top.solve(Eigen::MatrixXd::Identity(width, width));
    z.topLeftCorner(width, width) = top_inverse.transpose().lazyProduct(top_inverse);
    if (below > 0) {
      const Eigen::MatrixXd& known = inverse[s.parent];
      const int* where = to_parent_.data() + s.row_begin + s.width;
      for (int c = 0; c < below; c += 3)
        for (int r = 0; r < below; r += 3)
          z.block<3, 3>(width + r, width + c) =
              known.block<3, 3>(3 * where[r / 3], 3 * where[c / 3]);
      const Eigen::MatrixXd y = panel.bottomRows(below).lazyProduct(top_inverse);
      const Eigen::MatrixXd sy = z.bottomRightCorner(below, below).lazyProduct(y);
      z.bottomLeftCorner(below, width) = -sy;
      z.topRightCorner(width, below) = -sy.transpose();
      z.topLeftCorner(width, width) += y.transpose().lazyProduct(sy);
    }
    for (int k = 0; k < s.width; ++k) result[order_[s.first + k]] = z.block<3, 3>(3 * k, 3 * k);
    // Children stand before their parent, so the parent's inverse goes with its first child.
    if (s.parent >= 0 && children_[supernodes_[s.parent].child_begin] == static_cast<int>(index))
      inverse[s.parent] = Eigen::MatrixXd();
    if (s.child_begin == s.child_end) z = Eigen::MatrixXd();
  }
  return result;
}

}  // namespace majak::graph
