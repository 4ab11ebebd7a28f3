// SPDX-License-Identifier: Apache-2.0
// Least squares over a handful of measurements, without allocation; and consensus over minimal sets
// where some of them are gross errors. A Model has
//   kDimension, kMinimal          unknowns; measurements that determine them
//   int count()                   of measurements, at most kMostMeasurements
//   double linearize(i, x, row)   residual of i over its sigma, `row` its gradient by x
//   int solve_minimal(set, out)   the 0, 1 or 2 solutions of kMinimal measurements
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "majak/beacon/fix.hpp"
#include "majak/core/random.hpp"

namespace majak::beacon {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;
template <int N>
using Square = Eigen::Matrix<double, N, N>;

constexpr Mask all_of(int count) { return count >= 64 ? ~Mask{0} : (Mask{1} << count) - 1; }
constexpr bool holds(Mask mask, int i) { return (mask >> i & 1) != 0; }

/// Normal equations H dx = -g at x (MATH 7.1).
template <int N>
struct Normal {
  Square<N> H = Square<N>::Zero();
  Vector<N> g = Vector<N>::Zero();
  double chi2 = 0;
};

template <class Model>
Normal<Model::kDimension> normal_equations(const Model& model, Mask used,
                                           const Vector<Model::kDimension>& x) {
  Normal<Model::kDimension> n;
  Vector<Model::kDimension> row;
  for (int i = 0; i < model.count(); ++i) {
    if (!holds(used, i)) continue;
    const double r = model.linearize(i, x, row);
    n.H.noalias() += row * row.transpose();
    n.g += r * row;
    n.chi2 += r * r;
  }
  return n;
}

template <int N>
struct Fitted {
  Vector<N> x = Vector<N>::Zero();
  Square<N> covariance = Square<N>::Zero();  ///< H^-1 at x
  double chi2 = std::numeric_limits<double>::infinity();
  int iterations = 0;
  bool converged = false;
};

/// Gauss-Newton from `x`; a step that makes it worse is damped (Levenberg 1944).
template <class Model>
Fitted<Model::kDimension> least_squares(const Model& model, Mask used,
                                        Vector<Model::kDimension> x) {
  constexpr int kN = Model::kDimension;
  constexpr double kSmallStep = 1e-14;  // squared, in sigmas
  Fitted<kN> fit;
  Normal<kN> now = normal_equations(model, used, x);
  double damping = 0;
  while (fit.iterations++ < 30) {
    Square<kN> damped = now.H;
    damped.diagonal() *= 1 + damping;
    const Vector<kN> step = damped.inverse() * -now.g;
    const double size = step.dot(now.H * step);
    if (!std::isfinite(size)) break;
    fit.converged = size < kSmallStep;
    const Normal<kN> next = normal_equations(model, used, x + step);
    if (next.chi2 <= now.chi2) {
      x += step;
      now = next;
      damping = damping > 1e-6 ? damping / 10 : 0;
    } else if (!fit.converged) {
      damping = std::max(10 * damping, 1e-3);
    }
    if (fit.converged) break;
  }
  fit.x = x;
  fit.covariance = now.H.inverse();
  fit.chi2 = now.chi2;
  return fit;
}

/// Those of `among` whose residual lies within `gate` sigmas.
template <class Model>
Mask within(const Model& model, Mask among, const Vector<Model::kDimension>& x, double gate) {
  Mask mask = 0;
  Vector<Model::kDimension> row;
  for (int i = 0; i < model.count(); ++i) {
    if (holds(among, i) && std::abs(model.linearize(i, x, row)) <= gate) mask |= Mask{1} << i;
  }
  return mask;
}

/// Sum of squared residuals, each cut off at the gate (MSAC; Torr and Zisserman 2000).
template <class Model>
double truncated_cost(const Model& model, const Vector<Model::kDimension>& x, double gate) {
  double cost = 0;
  Vector<Model::kDimension> row;
  for (int i = 0; i < model.count(); ++i) {
    const double r = model.linearize(i, x, row);
    cost += std::min(r * r, gate * gate);
  }
  return cost;
}

/// The next set of indices below n in lexicographic order; false after the last.
template <std::size_t K>
bool next_set(std::array<int, K>& set, int n) {
  int i = static_cast<int>(K) - 1;
  while (i >= 0 && set[i] == n - static_cast<int>(K) + i) --i;
  if (i < 0) return false;
  ++set[i];
  for (std::size_t j = i + 1; j < K; ++j) set[j] = set[j - 1] + 1;
  return true;
}

template <std::size_t K>
std::array<int, K> random_set(RandomStream& random, int n) {
  std::array<int, K> set;
  for (std::size_t i = 0; i < K;) {
    set[i] = static_cast<int>(random.below(n));
    if (std::find(set.begin(), set.begin() + i, set[i]) == set.begin() + i) ++i;
  }
  return set;
}

/// Calls body(set) for all minimal sets, or for `most` drawn ones if there are more.
template <std::size_t K, class Body>
void for_minimal_sets(int n, int most, const Body& body) {
  double sets = 1;
  for (std::size_t i = 0; i < K; ++i)
    sets *= static_cast<double>(n - i) / static_cast<double>(i + 1);
  std::array<int, K> set;
  if (sets <= most) {
    for (std::size_t i = 0; i < K; ++i) set[i] = static_cast<int>(i);
    do body(set);
    while (next_set(set, n));
  } else {
    RandomStream random(1);
    for (int i = 0; i < most; ++i) body(random_set<K>(random, n));
  }
}

template <int N>
struct Agreed {
  Vector<N> x = Vector<N>::Zero();
  double cost = std::numeric_limits<double>::infinity();
  Mask used = 0;
};

/// Fits and chooses again, until the same measurements are used.
template <class Model>
Agreed<Model::kDimension> refine(const Model& model, const Vector<Model::kDimension>& start,
                                 double gate) {
  const Mask all = all_of(model.count());
  Agreed<Model::kDimension> best{start, truncated_cost(model, start, gate),
                                 within(model, all, start, gate)};
  for (int i = 0; i < 5 && std::popcount(best.used) > Model::kMinimal; ++i) {
    const auto fit = least_squares(model, best.used, best.x);
    const double cost = truncated_cost(model, fit.x, gate);
    if (!(cost < best.cost)) break;
    best = {fit.x, cost, within(model, all, fit.x, gate)};
  }
  return best;
}

/// Of the starts that `for_each_start(body)` hands to body(x), what the most measurements agree on:
/// a start that is better than those before it is refined (LO-RANSAC, Chum and others 2003).
template <class Model, class ForEachStart>
Agreed<Model::kDimension> best_agreement(const Model& model, double gate,
                                         const ForEachStart& for_each_start) {
  Agreed<Model::kDimension> best;
  double best_start = std::numeric_limits<double>::infinity();
  for_each_start([&](const Vector<Model::kDimension>& x) {
    const double cost = truncated_cost(model, x, gate);
    if (!(cost < best_start)) return;
    best_start = cost;
    const Agreed<Model::kDimension> refined = refine(model, x, gate);
    if (refined.cost < best.cost) best = refined;
  });
  return best;
}

/// The same over minimal sets (RANSAC; Fischler and Bolles 1981). `used` is empty where there are
/// not one measurement more than the unknowns need and more than half of all.
template <class Model>
Agreed<Model::kDimension> consensus(const Model& model, const FixOptions& options) {
  const auto for_each_start = [&](const auto& body) {
    for_minimal_sets<Model::kMinimal>(model.count(), options.most_sets, [&](const auto& set) {
      std::array<Vector<Model::kDimension>, 2> candidates;
      const int n = model.solve_minimal(set, candidates);
      for (int i = 0; i < n; ++i) body(candidates[i]);
    });
  };
  Agreed<Model::kDimension> best = best_agreement(model, options.gate, for_each_start);
  const int used = std::popcount(best.used);
  if (used <= Model::kMinimal || 2 * used <= model.count()) best.used = 0;
  return best;
}

/// Does the covariance hold? Two sigmas from x along the longest axis of the position's ellipse, to
/// both sides: how far, in sigmas, the residuals lie from the straight line that the covariance
/// takes them for (MATH 7.2; Bates and Watts 1980). Infinite where there is no covariance. The
/// position is the first two unknowns.
template <class Model>
double nonlinearity(const Model& model, Mask used, const Fitted<Model::kDimension>& fit) {
  constexpr int kN = Model::kDimension;
  const Mat2 c = fit.covariance.template topLeftCorner<2, 2>();
  const double half = 0.5 * (c(0, 0) - c(1, 1)), root = std::hypot(half, c(0, 1));
  const double largest = 0.5 * (c(0, 0) + c(1, 1)) + root;
  const double turn = 0.5 * std::atan2(c(0, 1), half);
  const Vec2 axis(std::cos(turn), std::sin(turn));
  const Vector<kN> shift = fit.covariance.template leftCols<2>() * axis * (2 / std::sqrt(largest));
  Vector<kN> row, ignored;
  double worst = 0;
  for (const double side : {-1.0, 1.0}) {
    double squares = 0;
    for (int i = 0; i < model.count(); ++i) {
      if (!holds(used, i)) continue;
      const double here = model.linearize(i, fit.x, row);
      const double there = model.linearize(i, fit.x + side * shift, ignored);
      const double bend = there - here - side * row.dot(shift);
      squares += bend * bend;
    }
    worst = std::max(worst, squares);
    if (!std::isfinite(squares)) return std::numeric_limits<double>::infinity();
  }
  return std::sqrt(worst);
}

}  // namespace majak::beacon
