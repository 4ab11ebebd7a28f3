// SPDX-License-Identifier: Apache-2.0
// Histogram filter: a belief as one probability a cell (Thrun, Burgard, Fox, Probabilistic
// Robotics, 4.1 and 8.2). The thesis names Markov localization without its two formulas:
//
//   moved:  Bel-(l) = sum over l' of P(l | a, l') Bel(l')
//   seen:   Bel(l)  = alpha P(s | l) Bel-(l),   alpha so that it sums to 1
//
// Here for one axis; pose_histogram.hpp is the same over (x, y, heading).
#pragma once

#include <span>
#include <vector>

namespace majak::filter {

/// What a motion does along one axis: of a mass in cell i, taps[k] goes to cell i + first + k.
struct Kernel {
  int first = 0;
  std::vector<double> taps;  ///< they sum to 1
};

/// A motion by `shift` cells with `variance` cells^2: whole cells, and the remainder f shared out
/// between two cells. That alone has the variance f (1 - f); what is left to `variance` comes from
/// the discrete Gaussian exp(-t) I_n(t), whose variance is exactly t (Lindeberg 1990). So the mean
/// is `shift` and the variance max(variance, f (1 - f)).
Kernel motion_kernel(double shift, double variance);

/// nat; cells of probability 0 add nothing.
double entropy(std::span<const double> p);

/// A belief over cells in a row.
struct Histogram {
  std::vector<double> p;  ///< sums to 1
  bool cyclic = false;    ///< the last cell lies beside the first; else the ends are walls

  static Histogram uniform(std::size_t cells, bool cyclic);
  /// Bel-. What would leave through a wall stays in the cell before it.
  void move(double shift, double variance);
  /// Bel. Returns the evidence, the sum of P(s | l) Bel-(l); where that is 0 nothing is changed.
  double see(std::span<const double> likelihood);
};

}  // namespace majak::filter
