// SPDX-License-Identifier: Apache-2.0
// How far apart two places are by the way that was driven, loop closures being short cuts. The
// error between two places grows with that way: it bounds by how much they may be off against each
// other.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace majak::slam {

class Ways {
 public:
  /// The next place, `way` m on from the one before; the first place has none.
  void add_place(double way);
  /// Two places recognised as neighbours: from now on there is this way between them, m.
  void add_short_cut(std::size_t a, std::size_t b, double way);

  std::size_t size() const { return driven_.size(); }
  /// m driven up to a place, without short cuts.
  double driven(std::size_t place) const { return driven_[place]; }
  /// Shortest way from a place to each place (Dijkstra 1959).
  std::vector<double> from(std::size_t place) const;

 private:
  std::vector<double> driven_;
  std::vector<std::vector<std::pair<std::size_t, double>>> neighbours_;
};

}  // namespace majak::slam
