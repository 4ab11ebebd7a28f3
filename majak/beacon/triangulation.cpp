// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/triangulation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>

#include "majak/beacon/least_squares.hpp"
#include "majak/core/error.hpp"

namespace majak::beacon {
namespace {

Vec2 direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The circle through the sensor and two beacons, w (x^2 + y^2) - X x - Y y + K = 0 with the middle
/// beacon as origin: (w, -X, -Y). `turn` is the direction between the bearings, from a to b.
Vec3 circle(const Vec2& a, const Vec2& b, const Vec2& turn) {
  const Vec2 sum = a + b, way = a - b;
  return {turn.y(), -(turn.y() * sum.x() + turn.x() * way.y()),
          -(turn.y() * sum.y() - turn.x() * way.x())};
}

struct BearingModel {
  static constexpr int kDimension = 3, kMinimal = 3;
  std::span<const BearingTo> bearings;

  int count() const { return static_cast<int>(bearings.size()); }

  double linearize(int i, const Vec3& x, Vec3& row) const {
    const BearingTo& m = bearings[i];
    const Vec2 way = m.p_map - x.head<2>();
    const double square = way.squaredNorm();
    row = Vec3(way.y() / square, -way.x() / square, -1) / m.sigma;
    if (!(square > 0)) row = Vec3(0, 0, -1 / m.sigma);
    return angle_diff(std::atan2(way.y(), way.x()), x.z() + m.bearing) / m.sigma;
  }

  /// Three circles, one through each pair of beacons and the sensor, meet in the sensor: the power
  /// centre (Pierlot and Van Droogenbroeck, "A new three object triangulation algorithm for mobile
  /// robot positioning", IEEE Transactions on Robotics 30, 2014). Here with sines and cosines for
  /// their cotangents, so that no bearing needs a case of its own (MATH 7.7).
  int solve_minimal(const std::array<int, 3>& set, std::array<Vec3, 2>& out) const {
    const BearingTo &m1 = bearings[set[0]], &m2 = bearings[set[1]], &m3 = bearings[set[2]];
    const Vec2 to1 = m1.p_map - m2.p_map, to3 = m3.p_map - m2.p_map;
    const double scale = to1.norm() + to3.norm();
    const Vec2 b1 = to1 / scale, b3 = to3 / scale;
    const Vec2 t12 = direction(m2.bearing - m1.bearing), t23 = direction(m3.bearing - m2.bearing);
    const Vec2 t31 = direction(m1.bearing - m3.bearing);
    const Vec3 both = circle(b1, Vec2::Zero(), t12).cross(circle(Vec2::Zero(), b3, t23));
    const double power = t31.y() * b1.dot(b3) + t31.x() * cross(b1, b3);
    const double determinant = circle(b3, b1, t31).dot(both);
    if (!(std::abs(determinant) > 1e-14)) return 0;
    const Vec2 p = m2.p_map + both.tail<2>() * (-power / determinant * scale);
    out[0] << p, heading_at(p, set);
    return out[0].allFinite() ? 1 : 0;
  }

  /// The mean of what the bearings say of it.
  double heading_at(const Vec2& p, const std::array<int, 3>& set) const {
    Vec2 sum = Vec2::Zero();
    for (const int i : set) {
      const Vec2 way = (bearings[i].p_map - p).normalized(), ray = direction(bearings[i].bearing);
      sum += Vec2(ray.dot(way), cross(ray, way));
    }
    return std::atan2(sum.y(), sum.x());
  }
};

/// m of position a rad of bearing, were all bearings alike, and the mean distance over it.
void tell_geometry(Triangulation& out, const BearingModel& model, const Vec3& x) {
  Mat3 H = Mat3::Zero();
  double distance = 0;
  Vec3 row;
  for (int i = 0; i < model.count(); ++i) {
    if (!holds(out.used, i)) continue;
    model.linearize(i, x, row);
    row *= model.bearings[i].sigma;
    H += row * row.transpose();
    distance += (model.bearings[i].p_map - x.head<2>()).norm();
  }
  const double square = H.inverse().topLeftCorner<2, 2>().trace();
  if (!(square > 0)) return;
  out.dop = std::sqrt(square);
  out.conditioning = distance / std::popcount(out.used) / out.dop;
}

void fill(Triangulation& out, const BearingModel& model, const Fitted<3>& fit,
          const FixOptions& options) {
  out.T_map_sensor = from_vector(fit.x);
  out.covariance = fit.covariance;
  out.chi2 = fit.chi2;
  out.iterations = fit.iterations;
  out.dof = std::popcount(out.used) - 3;
  tell_geometry(out, model, fit.x);
  out.nonlinearity = nonlinearity(model, out.used, fit);
  const bool holds = fit.converged && out.nonlinearity < options.nonlinear;
  out.problem = holds ? FixProblem::none : FixProblem::ill_conditioned;
}

Triangulation from_three(const BearingModel& model, const FixOptions& options) {
  Triangulation out{.problem = FixProblem::ill_conditioned, .used = all_of(3)};
  std::array<Vec3, 2> places;
  if (model.solve_minimal({0, 1, 2}, places) == 0) return out;
  const auto normal = normal_equations(model, out.used, places[0]);
  fill(out, model, {places[0], normal.H.inverse(), normal.chi2, 0, true}, options);
  // The circles know lines, not rays: a beacon may come out behind.
  if (within(model, out.used, places[0], options.gate) != out.used)
    out.problem = FixProblem::inconsistent;
  return out;
}

/// The best of some minimal sets.
Agreed<3> start_of(const BearingModel& model, const FixOptions& options) {
  constexpr int kSets = 8;
  Agreed<3> best;
  const auto look = [&](const std::array<int, 3>& set) {
    std::array<Vec3, 2> places;
    if (model.solve_minimal(set, places) == 0) return;
    const double cost = truncated_cost(model, places[0], options.gate);
    if (cost < best.cost) best = {places[0], cost, all_of(model.count())};
  };
  for_minimal_sets<3>(model.count(), kSets, look);
  return best;
}

Triangulation from_many(const BearingModel& model, const FixOptions& options) {
  Triangulation out{.problem = FixProblem::ill_conditioned, .used = all_of(model.count())};
  const Agreed<3> start = start_of(model, options);
  if (start.used == 0) return out;
  Fitted<3> fit = least_squares(model, out.used, start.x);
  const bool agree = within(model, out.used, fit.x, options.gate) == out.used;
  if (!agree) {
    const Agreed<3> agreed = consensus(model, options);
    if (agreed.used == 0) {
      fill(out, model, fit, options);
      out.problem = FixProblem::inconsistent;
      return out;
    }
    out.used = agreed.used;
    fit = least_squares(model, out.used, agreed.x);
  }
  fill(out, model, fit, options);
  return out;
}

bool sound(const BearingTo& m) {
  return m.p_map.allFinite() && std::isfinite(m.bearing) && m.sigma > 0 && std::isfinite(m.sigma);
}

/// Are there three different places among the beacons?
bool three_places(std::span<const BearingTo> bearings) {
  const Vec2& first = bearings.front().p_map;
  const BearingTo* second = nullptr;
  for (const BearingTo& m : bearings) {
    const double near = 1e-9 * (1 + m.p_map.norm());
    if ((m.p_map - first).norm() <= near) continue;
    if (second == nullptr) second = &m;
    if ((m.p_map - second->p_map).norm() > near) return true;
  }
  return false;
}

}  // namespace

Triangulation triangulate(std::span<const BearingTo> bearings, const FixOptions& options) {
  if (bearings.size() > kMostMeasurements) throw Error("triangulation: more than 64 bearings");
  if (!std::all_of(bearings.begin(), bearings.end(), sound))
    return {.problem = FixProblem::bad_value};
  if (bearings.size() < 3) return {};
  if (!three_places(bearings)) return {.problem = FixProblem::identical};
  const BearingModel model{bearings};
  return bearings.size() == 3 ? from_three(model, options) : from_many(model, options);
}

}  // namespace majak::beacon
