// SPDX-License-Identifier: Apache-2.0
// BlockCholesky: L L' of a sparse symmetric positive definite matrix of 3 x 3 blocks. Multifrontal
// over supernodes (Duff and Reid 1983; Liu 1992), ordered by approximate minimum degree on the
// graph of the blocks. The structure is analysed once; values are written straight into their
// slots.
//
//   BlockCholesky a;
//   const auto slots = a.analyze(n, pairs);       // one slot for each pair (i, j), i != j
//   a.set_zero();
//   add(a.diagonal(i), ...); add(a.block(slots[k]), ...);
//   if (a.factor()) a.solve(x);                   // x = A^-1 x
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::graph {

class BlockCholesky {
 public:
  using Pair = std::pair<int, int>;

  /// Where the block of pair (i, j) lives. Not transposed: it is stored as A(i, j), else as A(j,
  /// i). Equal pairs, either way round, share their block.
  struct Slot {
    int block = 0;
    bool transposed = false;
  };

  /// Structure of n x n blocks with the diagonal and the given pairs. A pair that names block n
  /// (one past the last) gets a slot that is written to but never read: a place for fixed
  /// variables. Called again with a little more of the same structure, it keeps the order and is
  /// quicker.
  std::vector<Slot> analyze(int n, std::span<const Pair> pairs);

  int size() const { return n_; }
  void set_zero();
  /// 9 numbers, column-major, of which the lower triangle counts. i == size() is the unread one.
  double* diagonal(int i) { return values_.data() + 9 * static_cast<std::size_t>(i); }
  const double* diagonal(int i) const { return values_.data() + 9 * static_cast<std::size_t>(i); }
  /// 9 numbers, column-major.
  double* block(Slot slot) { return diagonal(slot.block); }

  /// Factors A + damping * diag(A), where diagonal numbers below a millionth of the largest count
  /// as that. False where it is not positive definite; solve() is then void.
  bool factor(double damping = 0);
  /// x = A^-1 x, 3 * size() numbers.
  void solve(std::span<double> x) const;
  /// The diagonal blocks of A^-1 by Takahashi's recursion (Erisman and Tinney 1975): only the
  /// entries of the inverse inside the structure of L are made, no solves.
  std::vector<Mat3> inverse_diagonal() const;

  std::size_t factor_blocks() const;  ///< 3 x 3 blocks stored in L
  double factor_operations() const;   ///< multiply-adds of one factorisation

 private:
  /// Columns of L with (nearly) the same structure, kept as one dense panel.
  struct Supernode {
    int first = 0, width = 0;     ///< block columns, in elimination order
    int row_begin = 0, rows = 0;  ///< block rows in rows_, its own columns first
    int parent = -1, level = 0;
    int entry_begin = 0, entry_end = 0;  ///< entries of A, in entries_
    int child_begin = 0, child_end = 0;  ///< in children_
    std::size_t panel = 0;               ///< offset into factor_
    int below() const { return 3 * (rows - width); }
    int update_stride() const { return (below() + 3) & ~3; }
    int stride() const { return 3 * width + update_stride(); }
  };
  /// One block of A and its place in the front of its supernode.
  struct Entry {
    int block, row, column;
  };
  struct Adjacency;
  struct Tree;
  struct Draft;

  std::vector<Slot> number_blocks(std::span<const Pair> pairs);
  static Adjacency adjacency(int n, std::span<const Pair> pairs);
  bool extend_order(const Adjacency& a, Tree& tree);
  void find_order();
  Tree eliminate(const Adjacency& a);
  std::vector<Draft> draft_supernodes(const Tree& tree) const;
  void build_supernodes(const Tree& tree);
  void link_children();
  void place_entries();
  void assemble(const Supernode& s, double damping, double* panel) const;
  void add_child(const Supernode& child, const Supernode& s, const double* update, double* panel,
                 double* front) const;
  std::span<const int> rows(const Supernode& s) const {
    return {rows_.data() + s.row_begin, static_cast<std::size_t>(s.rows)};
  }

  int n_ = 0;
  std::vector<Pair> blocks_;        ///< distinct pairs (smaller, larger), natural order
  std::vector<int> order_, place_;  ///< order_[k]: k-th eliminated; place_ is its inverse
  int fresh_size_ = 0;              ///< variables and work when the order was last found afresh
  double fresh_operations_ = 0;
  std::vector<Supernode> supernodes_;  ///< in postorder
  std::vector<int> rows_, to_parent_;  ///< to_parent_: position of that row in the parent's rows
  std::vector<int> children_;
  std::vector<Entry> entries_;
  std::vector<double> values_, factor_;
  std::vector<double> stack_[2];  ///< update matrices of even and odd levels
  double smallest_ = 0;           ///< damping acts as if the diagonal were at least this
  mutable std::vector<double> work_, below_;
};

}  // namespace majak::graph
