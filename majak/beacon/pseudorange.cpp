// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/pseudorange.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "majak/beacon/least_squares.hpp"
#include "majak/core/error.hpp"

namespace majak::beacon {
namespace {

/// Up to two places with their clock.
template <int D>
struct Roots {
  int count = 0;
  std::array<Vector<D + 1>, 2> points{};
};

template <int D>
struct PseudorangeModel {
  static constexpr int kDimension = D + 1, kMinimal = D + 1;
  std::span<const PseudorangeTo<D>> ranges;

  int count() const { return static_cast<int>(ranges.size()); }

  double linearize(int i, const Vector<D + 1>& x, Vector<D + 1>& row) const {
    const PseudorangeTo<D>& m = ranges[i];
    const Vector<D> way = x.template head<D>() - m.p_map;
    const double distance = way.norm();
    row << (distance > 0 ? Vector<D>(way / distance) : Vector<D>::Zero()), 1;
    row /= m.sigma;
    return (distance + x[D] - m.range) / m.sigma;
  }

  int solve_minimal(const std::array<int, D + 1>& set, std::array<Vector<D + 1>, 2>& out) const {
    Mask mask = 0;
    for (const int i : set) mask |= Mask{1} << i;
    const Roots<D> roots = bancroft(mask);
    out = roots.points;
    return roots.count;
  }

  /// The origin of (place, range): beside the beacons' middle, so that no layout that is flat
  /// through its middle makes the equations singular; and the layout's size.
  std::pair<Vector<D + 1>, double> origin(Mask used) const {
    Vector<D + 1> low = Vector<D + 1>::Constant(HUGE_VAL), high = -low;
    for (int i = 0; i < count(); ++i) {
      if (!holds(used, i)) continue;
      Vector<D + 1> s;
      s << ranges[i].p_map, ranges[i].range;
      low = low.cwiseMin(s);
      high = high.cwiseMax(s);
    }
    const double size = (high - low).template head<D>().norm();
    const Vector<D + 1> aside = Vector<D + 1>::LinSpaced(1, 0.4) * size;
    return {0.5 * (low + high) - aside, size};
  }

  /// Bancroft, "An algebraic solution of the GPS equations", IEEE Transactions on Aerospace and
  /// Electronic Systems 21, 1985 (MATH 7.9). Roots with a negative distance are left out.
  Roots<D> bancroft(Mask used) const {
    const auto [centre, size] = origin(used);
    Vector<D + 1> metric = Vector<D + 1>::Ones();
    metric[D] = -1;
    Square<D + 1> H = Square<D + 1>::Zero();
    Vector<D + 1> ones = Vector<D + 1>::Zero(), halves = ones;
    for (int i = 0; i < count(); ++i) {
      if (!holds(used, i)) continue;
      Vector<D + 1> s;
      s << ranges[i].p_map, ranges[i].range;
      s = (s - centre) / size;
      const Vector<D + 1> a = metric.cwiseProduct(s);
      H += a * a.transpose();
      ones += a;
      halves += 0.5 * s.dot(a) * a;
    }
    const Square<D + 1> inverse = H.inverse();
    const Vector<D + 1> u = inverse * halves, v = inverse * ones;
    const double vv = v.dot(metric.cwiseProduct(v)), uv = u.dot(metric.cwiseProduct(v)) - 1;
    const double uu = u.dot(metric.cwiseProduct(u));
    const double root = std::sqrt(std::max(0.0, uv * uv - vv * uu));
    const double q = uv > 0 ? -uv - root : -uv + root;  // the root that does not cancel
    Roots<D> roots;
    for (const double lambda : {q / vv, uu / q}) {
      const Vector<D + 1> x = centre + size * (u + lambda * v);
      if (x.allFinite() && ahead(used, x)) roots.points[roots.count++] = x;
    }
    return roots;
  }

  bool ahead(Mask used, const Vector<D + 1>& x) const {
    for (int i = 0; i < count(); ++i) {
      if (holds(used, i) && ranges[i].range - x[D] < -4 * ranges[i].sigma) return false;
    }
    return true;
  }
};

template <int D>
Dilution dilution_of(const PseudorangeModel<D>& model, Mask used, const Vector<D + 1>& x) {
  Square<D + 1> H = Square<D + 1>::Zero();
  for (int i = 0; i < model.count(); ++i) {
    if (!holds(used, i)) continue;
    Vector<D + 1> row;
    model.linearize(i, x, row);
    row *= model.ranges[i].sigma;
    H += row * row.transpose();
  }
  const Vector<D + 1> q = H.inverse().diagonal();
  Dilution out;
  if (!(q.minCoeff() > 0)) return out;
  out.gdop = std::sqrt(q.sum());
  out.pdop = std::sqrt(q.template head<D>().sum());
  out.hdop = std::sqrt(q[0] + q[1]);
  if (D == 3) out.vdop = std::sqrt(q[2]);
  out.tdop = std::sqrt(q[D]);
  return out;
}

/// Least squares from both roots: the one that fits, and whether the other does as well.
template <int D>
void fit_used(PseudorangeFix<D>& out, const PseudorangeModel<D>& model,
              const std::optional<Vector<D>>& prior, const FixOptions& options) {
  const Roots<D> roots = model.bancroft(out.used);
  if (roots.count == 0) {
    out.problem = FixProblem::inconsistent;
    return;
  }
  Fitted<D + 1> best = least_squares(model, out.used, roots.points[0]);
  if (roots.count == 2) {
    Fitted<D + 1> other = least_squares(model, out.used, roots.points[1]);
    if (other.chi2 < best.chi2) std::swap(best, other);
    const double apart = (best.x - other.x).norm();
    const bool doubt = other.converged && apart > 1e-3 * std::sqrt(best.covariance.trace()) &&
                       other.chi2 - best.chi2 < options.gate * options.gate;
    const auto away = [&](const Fitted<D + 1>& f) {
      return (f.x.template head<D>() - *prior).norm();
    };
    if (doubt && prior && away(other) < away(best)) std::swap(best, other);
    if (doubt) out.mirror = other.x.template head<D>();
    if (doubt && !prior) out.problem = FixProblem::ambiguous;
  }
  out.p_map = best.x.template head<D>();
  out.bias = best.x[D];
  out.covariance = best.covariance;
  out.chi2 = best.chi2;
  out.iterations = best.iterations;
  out.dilution = dilution_of(model, out.used, best.x);
  out.nonlinearity = nonlinearity(model, out.used, best);
  const bool holds = best.converged && out.nonlinearity < options.nonlinear;
  if (out.problem == FixProblem::none && !holds) out.problem = FixProblem::ill_conditioned;
}

template <int D>
bool sound(const PseudorangeTo<D>& m) {
  return m.p_map.allFinite() && std::isfinite(m.range) && m.sigma > 0 && std::isfinite(m.sigma);
}

template <int D>
bool one_place(std::span<const PseudorangeTo<D>> ranges) {
  return std::all_of(ranges.begin(), ranges.end(), [&](const auto& m) {
    return (m.p_map - ranges[0].p_map).norm() <= 1e-9 * (1 + m.p_map.norm());
  });
}

}  // namespace

template <int D>
PseudorangeFix<D> locate(std::span<const PseudorangeTo<D>> ranges,
                         const std::optional<Eigen::Matrix<double, D, 1>>& prior,
                         const FixOptions& options) {
  if (ranges.size() > kMostMeasurements) throw Error("pseudoranges: more than 64 of them");
  PseudorangeFix<D> out;
  if (!std::all_of(ranges.begin(), ranges.end(), sound<D>)) {
    out.problem = FixProblem::bad_value;
  } else if (ranges.size() < D + 1) {
    out.problem = FixProblem::too_few;
  } else if (one_place(ranges)) {
    out.problem = FixProblem::identical;
  } else {
    const PseudorangeModel<D> model{ranges};
    const auto fit = [&](Mask used) {
      out = {};
      out.problem = FixProblem::none;
      out.used = used;
      fit_used<D>(out, model, prior, options);
      out.dof = std::popcount(used) - D - 1;
    };
    fit(all_of(model.count()));
    Vector<D + 1> x;
    x << out.p_map, out.bias;
    if (within(model, out.used, x, options.gate) == out.used) return out;
    const Agreed<D + 1> agreed = consensus(model, options);
    if (agreed.used != 0) return fit(agreed.used), out;
    out.problem = FixProblem::inconsistent;
  }
  return out;
}

template PseudorangeFix<2> locate<2>(std::span<const PseudorangeTo<2>>, const std::optional<Vec2>&,
                                     const FixOptions&);
template PseudorangeFix<3> locate<3>(std::span<const PseudorangeTo<3>>, const std::optional<Vec3>&,
                                     const FixOptions&);

}  // namespace majak::beacon
