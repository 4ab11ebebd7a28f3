// SPDX-License-Identifier: Apache-2.0
// The structural half of BlockCholesky: order, elimination tree, supernodes, where each block goes.
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cstdint>
#include <numeric>

#include "majak/graph/block_cholesky.hpp"

namespace majak::graph {
/// Rows of a symmetric structure, both triangles, without the diagonal.
struct BlockCholesky::Adjacency {
  std::vector<int> begin, list;
  std::span<const int> of(int i) const {
    return {list.data() + begin[i], static_cast<std::size_t>(begin[i + 1] - begin[i])};
  }
};

BlockCholesky::Adjacency BlockCholesky::adjacency(int n, std::span<const Pair> pairs) {
  Adjacency a;
  a.begin.assign(static_cast<std::size_t>(n) + 1, 0);
  for (const auto& [i, j] : pairs) ++a.begin[i + 1], ++a.begin[j + 1];
  std::partial_sum(a.begin.begin(), a.begin.end(), a.begin.begin());
  a.list.resize(2 * pairs.size());
  std::vector<int> next(a.begin.begin(), a.begin.end() - 1);
  for (const auto& [i, j] : pairs) a.list[next[i]++] = j, a.list[next[j]++] = i;
  return a;
}

namespace {

/// Liu 1986, with path compression. parent[k] > k or -1.
template <class Adjacency>
std::vector<int> elimination_tree(const Adjacency& a, const std::vector<int>& order,
                                  const std::vector<int>& place) {
  const int n = static_cast<int>(order.size());
  std::vector<int> parent(n, -1), ancestor(n, -1);
  for (int k = 0; k < n; ++k) {
    for (const int neighbour : a.of(order[k])) {
      for (int i = place[neighbour]; i != -1 && i < k;) {
        const int next = ancestor[i];
        ancestor[i] = k;
        if (next == -1) parent[i] = k;
        i = next;
      }
    }
  }
  return parent;
}

/// Children before parents, subtrees together. The child eliminated last, whose column is the
/// longest as a rule, comes last, so that it can join its parent's supernode.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> first_child(n, -1), sibling(n, -1), stack, post;
  for (int k = 0; k < n; ++k) {
    if (parent[k] < 0) continue;
    sibling[k] = first_child[parent[k]];
    first_child[parent[k]] = k;
  }
  post.reserve(n);
  for (int root = n - 1; root >= 0; --root) {
    if (parent[root] >= 0) continue;
    stack.push_back(root);
    while (!stack.empty()) {  // parents first and last child first, then reversed
      const int k = stack.back();
      stack.pop_back();
      post.push_back(k);
      const std::size_t mark = stack.size();
      for (int c = first_child[k]; c >= 0; c = sibling[c]) stack.push_back(c);
      std::reverse(stack.begin() + static_cast<std::ptrdiff_t>(mark), stack.end());
    }
  }
  std::reverse(post.begin(), post.end());
  return post;
}

}  // namespace

/// Structure of each column of L, by elimination order.
struct BlockCholesky::Tree {
  std::vector<int> parent;
  std::vector<int> begin;  ///< rows below the diagonal of column k: list[begin[k], begin[k + 1])
  std::vector<int> list;   ///< unsorted within a column
  int count(int k) const { return begin[k + 1] - begin[k]; }
  double operations() const {
    double sum = 0;
    for (std::size_t k = 0; k + 1 < begin.size(); ++k)
      sum += (count(static_cast<int>(k)) + 1.0) * (count(static_cast<int>(k)) + 1.0);
    return sum;
  }
};

std::vector<BlockCholesky::Slot> BlockCholesky::analyze(int n, std::span<const Pair> pairs) {
  n_ = n;
  std::vector<Slot> slots = number_blocks(pairs);
  const Adjacency a = adjacency(n, blocks_);
  Tree tree;
  if (!extend_order(a, tree)) {
    find_order();
    tree = eliminate(a);
    fresh_size_ = n;
    fresh_operations_ = tree.operations();
  }
  build_supernodes(tree);
  place_entries();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    if (i < n && j < n) slots[k].transposed = place_[i] < place_[j];
  }
  return slots;
}

/// Gives equal pairs one number, in order of their smaller index: counting sort, no comparisons.
std::vector<BlockCholesky::Slot> BlockCholesky::number_blocks(std::span<const Pair> pairs) {
  std::vector<int> begin(static_cast<std::size_t>(n_) + 2, 0), sorted(pairs.size());
  const auto low = [&](std::size_t k) { return std::min(pairs[k].first, pairs[k].second); };
  const auto high = [&](std::size_t k) { return std::max(pairs[k].first, pairs[k].second); };
  for (std::size_t k = 0; k < pairs.size(); ++k) ++begin[low(k) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  for (std::size_t k = 0; k < pairs.size(); ++k) sorted[begin[low(k)]++] = static_cast<int>(k);

  std::vector<int> seen(static_cast<std::size_t>(n_) + 1, -1), number(seen);
  std::vector<Slot> slots(pairs.size());
  blocks_.clear();
  for (const int k : sorted) {
    const int i = low(k), j = high(k);
    if (j >= n_) {
      slots[k].block = n_;
    } else {
      if (seen[j] != i) {
        seen[j] = i;
        number[j] = static_cast<int>(blocks_.size());
        blocks_.emplace_back(i, j);
      }
      slots[k].block = n_ + 1 + number[j];
    }
  }
  values_.assign(9 * (static_cast<std::size_t>(n_) + 1 + blocks_.size()), 0.0);
  return slots;
}

/// The old order with new variables behind it, as long as that costs little more than a fresh one.
bool BlockCholesky::extend_order(const Adjacency& a, Tree& tree) {
  const int old = static_cast<int>(order_.size());
  if (fresh_size_ == 0 || n_ < old || n_ > fresh_size_ + fresh_size_ / 4) return false;
  order_.resize(n_);
  std::iota(order_.begin() + old, order_.end(), old);
  tree = eliminate(a);
  return tree.operations() <= 1.3 * fresh_operations_ * n_ / fresh_size_;
}

void BlockCholesky::find_order() {
  const int n = n_;
  std::vector<int> begin(1, 0), list;  // lower triangle by columns, as blocks_ is sorted already
  list.reserve(n + blocks_.size());
  for (int k = 0, b = 0; k < n; ++k) {
    list.push_back(k);
    for (; b < static_cast<int>(blocks_.size()) && blocks_[b].first == k; ++b)
      list.push_back(blocks_[b].second);
    begin.push_back(static_cast<int>(list.size()));
  }
  const std::vector<double> ones(list.size(), 1.0);
  const Eigen::Map<const Eigen::SparseMatrix<double>> lower(
      n, n, static_cast<Eigen::Index>(list.size()), begin.data(), list.data(), ones.data());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), permutation);
  order_.assign(permutation.indices().data(), permutation.indices().data() + n);
}

/// Puts the order into postorder, which changes nothing but makes subtrees contiguous, and finds
/// the columns of L.
BlockCholesky::Tree BlockCholesky::eliminate(const Adjacency& a) {
  place_.resize(n_);
  for (int k = 0; k < n_; ++k) place_[order_[k]] = k;
  const std::vector<int> parent = elimination_tree(a, order_, place_);
  const std::vector<int> post = postorder(parent);
  std::vector<int> before = order_, position(n_);
  for (int k = 0; k < n_; ++k) {
    order_[k] = before[post[k]];
    place_[order_[k]] = k;
    position[post[k]] = k;
  }
  Tree tree;
  tree.parent.resize(n_);
  for (int k = 0; k < n_; ++k)
    tree.parent[k] = parent[post[k]] < 0 ? -1 : position[parent[post[k]]];
  tree.begin.assign(1, 0);
  tree.list.reserve(8 * blocks_.size());
  std::vector<int> seen(n_, -1), first_child(n_, -1), sibling(n_, -1);
  for (int k = 0; k < n_; ++k) {
    seen[k] = k;
    const auto add = [&](int row) {
      if (row > k && seen[row] != k) {
        seen[row] = k;
        tree.list.push_back(row);
      }
    };
    for (const int neighbour : a.of(order_[k])) add(place_[neighbour]);
    for (int c = first_child[k]; c >= 0; c = sibling[c])
      for (int i = tree.begin[c]; i < tree.begin[c + 1]; ++i) add(tree.list[i]);
    tree.begin.push_back(static_cast<int>(tree.list.size()));
    if (const int p = tree.parent[k]; p >= 0) {
      sibling[k] = first_child[p];
      first_child[p] = k;
    }
  }
  return tree;
}

/// Block columns [first, first + width) with `rows` block rows, while supernodes are being joined.
struct BlockCholesky::Draft {
  int first, width, rows;
  double zeros;  ///< blocks stored that are structurally zero
};

namespace {

/// Joining a child to its parent costs zeros and saves the overhead of a front. A narrow
/// front is mostly overhead, so it may be half zeros.
bool worth_joining(int width, int below, double zeros) {
  const double total = width * (width + 1) / 2.0 + width * static_cast<double>(below);
  const double share = width <= 4 ? 0.5 : width <= 16 ? 0.2 : 0.05;
  return zeros < share * total;
}

}  // namespace

/// Columns of equal structure first, then each with the child that stands right before it.
std::vector<BlockCholesky::Draft> BlockCholesky::draft_supernodes(const Tree& tree) const {
  std::vector<Draft> equal, joined;
  for (int k = 0; k < n_; ++k) {
    const bool follows = k > 0 && tree.parent[k - 1] == k && tree.count(k - 1) == tree.count(k) + 1;
    if (follows)
      ++equal.back().width;
    else
      equal.push_back({k, 1, tree.count(k) + 1, 0});
  }
  for (Draft d : equal) {
    while (!joined.empty()) {
      const Draft& c = joined.back();
      if (tree.parent[d.first - 1] != d.first) break;
      const double zeros = c.zeros + d.zeros + c.width * (d.rows + 0.0 - (c.rows - c.width));
      if (!worth_joining(c.width + d.width, d.rows - d.width, zeros)) break;
      d = {c.first, c.width + d.width, c.width + d.rows, zeros};
      joined.pop_back();
    }
    joined.push_back(d);
  }
  return joined;
}

void BlockCholesky::build_supernodes(const Tree& tree) {
  supernodes_.clear();
  rows_.clear();
  std::vector<int> owner(n_);
  std::size_t panel = 0;
  for (const Draft& d : draft_supernodes(tree)) {
    Supernode s;
    s.first = d.first;
    s.width = d.width;
    s.row_begin = static_cast<int>(rows_.size());
    const int last = d.first + d.width - 1;
    for (int k = d.first; k <= last; ++k) {
      rows_.push_back(k);
      owner[k] = static_cast<int>(supernodes_.size());
    }
    const auto list = tree.list.begin();
    rows_.insert(rows_.end(), list + tree.begin[last], list + tree.begin[last + 1]);
    std::sort(rows_.begin() + s.row_begin + d.width, rows_.end());
    s.rows = static_cast<int>(rows_.size()) - s.row_begin;
    s.panel = panel;
    panel += static_cast<std::size_t>(s.stride()) * 3 * s.width;
    supernodes_.push_back(s);
  }
  factor_.assign(panel, 0.0);
  for (Supernode& s : supernodes_) {
    const int parent = tree.parent[s.first + s.width - 1];
    if (parent >= 0) s.parent = owner[parent];
  }
  link_children();
}

/// Levels, lists of children, and where each row of a child lies in its parent.
void BlockCholesky::link_children() {
  const int count = static_cast<int>(supernodes_.size());
  std::vector<int> first_child(count, -1), sibling(count, -1);
  for (int i = count - 1; i >= 0; --i) {
    Supernode& s = supernodes_[i];
    if (s.parent < 0) continue;
    s.level = supernodes_[s.parent].level + 1;
    sibling[i] = first_child[s.parent];
    first_child[s.parent] = i;
  }
  children_.clear();
  to_parent_.assign(rows_.size(), -1);
  std::vector<int> position(n_, -1);
  for (int i = 0; i < count; ++i) {
    Supernode& s = supernodes_[i];
    const auto own = rows(s);
    for (int k = 0; k < s.rows; ++k) position[own[k]] = k;
    s.child_begin = static_cast<int>(children_.size());
    for (int c = first_child[i]; c >= 0; c = sibling[c]) {
      children_.push_back(c);
      const Supernode& child = supernodes_[c];
      for (int k = child.row_begin + child.width; k < child.row_begin + child.rows; ++k)
        to_parent_[k] = position[rows_[k]];
    }
    s.child_end = static_cast<int>(children_.size());
  }
}

void BlockCholesky::place_entries() {
  // Blocks by column of L (counting sort), then through each supernode in turn.
  std::vector<int> begin(static_cast<std::size_t>(n_) + 1, 0), sorted(blocks_.size());
  const auto column = [&](const Pair& p) { return std::min(place_[p.first], place_[p.second]); };
  for (const Pair& p : blocks_) ++begin[column(p) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int> next(begin.begin(), begin.end() - 1);
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    sorted[next[column(blocks_[b])]++] = static_cast<int>(b);

  entries_.clear();
  std::vector<int> position(n_, -1);
  for (Supernode& s : supernodes_) {
    const auto own = rows(s);
    for (int k = 0; k < s.rows; ++k) position[own[k]] = k;
    s.entry_begin = static_cast<int>(entries_.size());
    for (int c = 0; c < s.width; ++c) {
      entries_.push_back({order_[s.first + c], c, c});
      for (int i = begin[s.first + c]; i < begin[s.first + c + 1]; ++i) {
        const Pair& p = blocks_[sorted[i]];
        const int row = std::max(place_[p.first], place_[p.second]);
        entries_.push_back({n_ + 1 + sorted[i], position[row], c});
      }
    }
    s.entry_end = static_cast<int>(entries_.size());
  }
}

std::size_t BlockCholesky::factor_blocks() const {
  std::size_t sum = 0;
  for (const Supernode& s : supernodes_)
    sum += static_cast<std::size_t>(s.width) * (s.width + 1) / 2 +
           static_cast<std::size_t>(s.width) * (s.rows - s.width);
  return sum;
}

double BlockCholesky::factor_operations() const {
  double sum = 0;
  for (const Supernode& s : supernodes_)
    for (int k = 0; k < s.width; ++k) sum += 13.5 * (s.rows - k) * (s.rows - k);
  return sum;
}

}  // namespace majak::graph
