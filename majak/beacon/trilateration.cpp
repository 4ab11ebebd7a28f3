// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/trilateration.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "majak/beacon/least_squares.hpp"
#include "majak/core/error.hpp"

namespace majak::beacon {

Intersection intersect(const Circle& a, const Circle& b, double tolerance) {
  const Vec2 way = b.centre - a.centre;
  const double d = way.norm(), sum = a.radius + b.radius, difference = a.radius - b.radius;
  Intersection result;
  if (!(a.radius >= 0 && b.radius >= 0) || !std::isfinite(d)) return result;
  if (d <= 1e-12 * sum) {
    result.same = std::abs(difference) <= tolerance;
    return result;
  }
  const Vec2 u = way / d;
  const double outside = d - sum, inside = std::abs(difference) - d;
  const double apart = std::max(outside, inside);  // > 0: they do not meet
  if (apart > tolerance) return result;
  if (apart >= -tolerance) {
    // They touch from outside, or the smaller one from inside, on its side of the larger one.
    const bool b_in_a = inside > outside && difference > 0, a_in_b = inside > outside && !b_in_a;
    const double on_a = a_in_b ? -a.radius : a.radius;
    const double on_b = b_in_a ? d + b.radius : d - b.radius;
    result.count = 1;
    result.points[0] = result.points[1] = a.centre + 0.5 * (on_a + on_b) * u;
    return result;
  }
  // (MATH 7.3), the half chord by Heron's product, which does not cancel near a touch.
  const double along = 0.5 * (d + difference * (sum / d));
  const double half =
      0.5 * std::sqrt((sum + d) * (sum - d) * (d + difference) * (d - difference)) / d;
  const Vec2 left(-u.y(), u.x());
  result.count = 2;
  result.points = {a.centre + along * u + half * left, a.centre + along * u - half * left};
  return result;
}

namespace {

struct RangeModel {
  static constexpr int kDimension = 2, kMinimal = 2;
  std::span<const RangeTo> ranges;
  double gate;

  int count() const { return static_cast<int>(ranges.size()); }

  double linearize(int i, const Vec2& p, Vec2& row) const {
    const RangeTo& m = ranges[i];
    const Vec2 way = p - m.p_map;
    const double distance = way.norm();
    row = distance > 0 ? Vec2(way / (distance * m.sigma)) : Vec2::Zero();
    return (distance - m.range) / m.sigma;
  }

  int solve_minimal(const std::array<int, 2>& set, std::array<Vec2, 2>& out) const {
    const RangeTo &a = ranges[set[0]], &b = ranges[set[1]];
    // Noise may keep two circles apart that touch; it takes no intersection away.
    const Circle first{a.p_map, a.range}, second{b.p_map, b.range};
    auto met = intersect(first, second);
    if (met.count == 0) met = intersect(first, second, gate * (a.sigma + b.sigma));
    out = met.points;
    return met.count;
  }
};

/// Up to two starts for the ranges of `used`, and how flat the beacons' layout is.
struct Starts {
  int count = 0;
  std::array<Vec2, 2> points{};
};

/// (MATH 7.4, 7.5): the circles' equations less their mean are linear. Across beacons in (nearly)
/// one line they say nothing; there the mean itself gives the distance from the line, on either
/// side.
Starts closed_form(const RangeModel& model, Mask used) {
  constexpr double kFlat = 0.1;  // width of the layout over its length
  Vec2 centre = Vec2::Zero();
  double weights = 0;
  for (int i = 0; i < model.count(); ++i) {
    if (!holds(used, i)) continue;
    const double w = 1 / (model.ranges[i].sigma * model.ranges[i].sigma);
    centre += w * model.ranges[i].p_map;
    weights += w;
  }
  centre /= weights;
  Mat2 S = Mat2::Zero();
  Vec2 t = Vec2::Zero();
  double squares = 0;  // weighted mean of r^2 - |d|^2, which is |q|^2
  for (int i = 0; i < model.count(); ++i) {
    if (!holds(used, i)) continue;
    const RangeTo& m = model.ranges[i];
    const double w = 1 / (m.sigma * m.sigma);
    const Vec2 d = m.p_map - centre;
    const double b = d.squaredNorm() - m.range * m.range;
    S += w * d * d.transpose();
    t += 0.5 * w * b * d;
    squares -= w * b / weights;
  }
  const double half = 0.5 * (S(0, 0) - S(1, 1)), root = std::hypot(half, S(0, 1));
  const double mean = 0.5 * (S(0, 0) + S(1, 1)), large = mean + root, small = mean - root;
  const double smallest = 1e-9 * (std::sqrt(std::abs(squares)) + centre.norm());
  if (!(large > smallest * smallest * weights)) return {};
  if (small > kFlat * kFlat * large) return {1, {centre + S.inverse() * t, Vec2::Zero()}};
  const double turn = 0.5 * std::atan2(2 * S(0, 1), 2 * half);
  const Vec2 axis(std::cos(turn), std::sin(turn)), side(-axis.y(), axis.x());
  const double along = axis.dot(t) / large;
  const double across = std::sqrt(std::max(0.0, squares - along * along));
  return {2, {centre + along * axis + across * side, centre + along * axis - across * side}};
}

void fill(Trilateration& out, const RangeModel& model, const Fitted<2>& fit,
          const FixOptions& options) {
  out.p_map = fit.x;
  out.covariance = fit.covariance;
  out.chi2 = fit.chi2;
  out.iterations = fit.iterations;
  Mat2 directions = Mat2::Zero();
  for (int i = 0; i < model.count(); ++i) {
    if (!holds(out.used, i)) continue;
    Vec2 row;
    model.linearize(i, fit.x, row);
    row *= model.ranges[i].sigma;
    directions += row * row.transpose();
  }
  out.hdop = std::sqrt(directions.inverse().trace());
  out.nonlinearity = nonlinearity(model, out.used, fit);
  const bool sound = fit.converged && out.nonlinearity < options.nonlinear;
  if (out.problem == FixProblem::none && !sound) out.problem = FixProblem::ill_conditioned;
}

/// Two places: the prior's, else the one that fits better, and doubt where the other fits too.
void choose(Trilateration& out, const RangeModel& model, Fitted<2> first, Fitted<2> second,
            const std::optional<Vec2>& prior, const FixOptions& options) {
  if (second.chi2 < first.chi2) std::swap(first, second);
  const double apart = (first.x - second.x).norm();
  const double width = std::sqrt(first.covariance.trace());
  const bool doubt = second.chi2 - first.chi2 < options.gate * options.gate && apart > 1e-3 * width;
  if (doubt) {
    if (prior && (second.x - *prior).norm() < (first.x - *prior).norm()) std::swap(first, second);
    out.mirror = second.x;
    if (!prior) out.problem = FixProblem::ambiguous;
  }
  fill(out, model, first, options);
}

void fit_used(Trilateration& out, const RangeModel& model, const std::optional<Vec2>& prior,
              const FixOptions& options) {
  const Starts starts = closed_form(model, out.used);
  if (starts.count == 0) {
    out.problem = FixProblem::identical;
    return;
  }
  const Fitted<2> first = least_squares(model, out.used, starts.points[0]);
  if (starts.count == 1) return fill(out, model, first, options);
  choose(out, model, first, least_squares(model, out.used, starts.points[1]), prior, options);
}

Trilateration from_two(const RangeModel& model, const std::optional<Vec2>& prior,
                       const FixOptions& options) {
  Trilateration out{.problem = FixProblem::none, .used = all_of(2)};
  std::array<Vec2, 2> places;
  const int n = model.solve_minimal({0, 1}, places);
  if (n == 0) {
    const bool same = (model.ranges[0].p_map - model.ranges[1].p_map).norm() < 1e-9;
    out.problem = same ? FixProblem::identical : FixProblem::inconsistent;
    return out;
  }
  const auto at = [&](const Vec2& p) {
    const Normal<2> normal = normal_equations(model, out.used, p);
    return Fitted<2>{p, normal.H.inverse(), normal.chi2, 0, true};
  };
  choose(out, model, at(places[0]), at(places[1]), prior, options);
  return out;
}

bool sound(const RangeTo& m) {
  return m.p_map.allFinite() && std::isfinite(m.range) && m.range >= 0 && m.sigma > 0 &&
         std::isfinite(m.sigma);
}

}  // namespace

Trilateration trilaterate(std::span<const RangeTo> ranges, const std::optional<Vec2>& prior,
                          const FixOptions& options) {
  if (ranges.size() > kMostMeasurements) throw Error("trilateration: more than 64 ranges");
  if (!std::all_of(ranges.begin(), ranges.end(), sound)) return {.problem = FixProblem::bad_value};
  if (ranges.size() < 2) return {};
  const RangeModel model{ranges, options.gate};
  if (ranges.size() == 2) return from_two(model, prior, options);
  Trilateration out{.problem = FixProblem::none, .used = all_of(model.count())};
  fit_used(out, model, prior, options);
  if (within(model, out.used, out.p_map, options.gate) != out.used &&
      out.problem != FixProblem::identical) {
    const Agreed<2> agreed = consensus(model, options);
    if (agreed.used == 0) {
      out.problem = FixProblem::inconsistent;
    } else {
      out = {.problem = FixProblem::none, .used = agreed.used};
      fit_used(out, model, prior, options);
    }
  }
  out.dof = std::popcount(out.used) - 2;
  return out;
}

}  // namespace majak::beacon
