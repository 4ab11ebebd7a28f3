// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/resection.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "majak/beacon/least_squares.hpp"
#include "majak/beacon/triangulation.hpp"
#include "majak/core/error.hpp"

namespace majak::beacon {
namespace {

struct Seen {
  Vec2 p_map;
  BeaconSighting sighting;
  bool whole() const { return sighting.range && sighting.bearing; }
};

/// Measurement 2 i is the range of sighting i, 2 i + 1 its bearing.
struct SightingModel {
  static constexpr int kDimension = 3, kMinimal = 3;
  std::span<const Seen> seen;
  Mask present;

  explicit SightingModel(std::span<const Seen> s) : seen(s), present(present_in(s)) {}

  int count() const { return 2 * static_cast<int>(seen.size()); }

  static Mask present_in(std::span<const Seen> seen) {
    Mask mask = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (seen[i].sighting.range) mask |= Mask{1} << (2 * i);
      if (seen[i].sighting.bearing) mask |= Mask{1} << (2 * i + 1);
    }
    return mask;
  }

  /// (MATH 7.12); of what is absent zero.
  double linearize(int k, const Vec3& x, Vec3& row) const {
    const Seen& m = seen[k / 2];
    row.setZero();
    if (!holds(present, k)) return 0;
    const Pose2 T_map_robot{x.x(), x.y(), x.z()};
    const Pose2 T_map_sensor = T_map_robot * m.sighting.T_robot_sensor;
    const Vec2 way = m.p_map - T_map_sensor.translation();
    const Vec2 arm = T_map_sensor.translation() - T_map_robot.translation();
    const double square = way.squaredNorm(), range = std::sqrt(square);
    if (!(range > 0)) return 0;
    if (k % 2 == 0) {
      row = Vec3(-way.x(), -way.y(), way.x() * arm.y() - way.y() * arm.x()) /
            (range * m.sighting.range_sigma);
      return (range - *m.sighting.range) / m.sighting.range_sigma;
    }
    row = Vec3(way.y() / square, -way.x() / square, -1 - way.dot(arm) / square) /
          m.sighting.bearing_sigma;
    const double direction = std::atan2(way.y(), way.x());
    return angle_diff(direction, T_map_sensor.theta + *m.sighting.bearing) /
           m.sighting.bearing_sigma;
  }
};

/// The pose that two sightings with range and bearing state; (MATH 7.13) for two points.
Vec3 pose_by_two(const Seen& a, const Seen& b) {
  const auto place = [](const Seen& m) {
    const double r = *m.sighting.range, angle = *m.sighting.bearing;
    return m.sighting.T_robot_sensor * Vec2(r * std::cos(angle), r * std::sin(angle));
  };
  const Vec2 robot = place(b) - place(a), map = b.p_map - a.p_map;
  const double turn = angle_diff(std::atan2(map.y(), map.x()), std::atan2(robot.y(), robot.x()));
  const Vec2 middle = 0.5 * (a.p_map + b.p_map);
  const Vec2 t = middle - Pose2{0, 0, turn} * Vec2(0.5 * (place(a) + place(b)));
  return {t.x(), t.y(), turn};
}

/// Calls body(pose) for what every two whole sightings and every three bearings of one sensor say.
template <class Body>
void for_each_start(std::span<const Seen> seen, const Body& body) {
  const int n = static_cast<int>(seen.size());
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; ++j) {
      const bool apart = (seen[i].p_map - seen[j].p_map).norm() > 1e-9;
      if (apart && seen[i].whole() && seen[j].whole()) body(pose_by_two(seen[i], seen[j]));
    }
  }
  if (n < 3) return;
  for_minimal_sets<3>(n, 300, [&](const std::array<int, 3>& set) {
    std::array<BearingTo, 3> bearings;
    for (std::size_t k = 0; k < 3; ++k) {
      const BeaconSighting& s = seen[set[k]].sighting;
      if (!s.bearing || s.T_robot_sensor != seen[set[0]].sighting.T_robot_sensor) return;
      bearings[k] = {seen[set[k]].p_map, *s.bearing, s.bearing_sigma};
    }
    const auto fix = triangulate(bearings);
    if (fix.used == 0) return;
    body((fix.T_map_sensor * seen[set[0]].sighting.T_robot_sensor.inverse()).vector());
  });
}

bool sound(const BeaconSighting& s) {
  const bool range = !s.range || (*s.range >= 0 && std::isfinite(*s.range) && s.range_sigma > 0);
  const bool bearing = !s.bearing || (std::isfinite(*s.bearing) && s.bearing_sigma > 0);
  return range && bearing && s.T_robot_sensor.finite();
}

}  // namespace

PoseFix resect(std::span<const BeaconSighting> sightings, const BeaconMap& map,
               const FixOptions& options) {
  PoseFix out;
  std::vector<Seen> seen;
  for (const BeaconSighting& s : sightings) {
    const Beacon* known = map.find(s.beacon);
    if (known != nullptr) seen.push_back({known->p_map, s});
    out.unknown += known == nullptr;
    if (!sound(s)) out.problem = FixProblem::bad_value;
  }
  if (2 * seen.size() > kMostMeasurements) throw Error("resection: more than 32 sightings");
  if (out.problem == FixProblem::bad_value) return out;
  const SightingModel model{seen};
  Agreed<3> best =
      best_agreement(model, options.gate, [&](const auto& body) { for_each_start(seen, body); });
  if (!std::isfinite(best.cost)) return out;
  best.used &= model.present;
  const auto fit = least_squares(model, best.used, best.x);
  const int used = std::popcount(best.used);
  out.gross = std::popcount(model.present) - used;
  out.T_map_robot = from_vector(fit.x);
  out.covariance = fit.covariance;
  out.chi2 = fit.chi2;
  out.dof = used - 3;
  out.nonlinearity = nonlinearity(model, best.used, fit);
  const bool agree = out.gross == 0 || (used > 3 && 2 * used > std::popcount(model.present));
  const bool straight = fit.converged && out.nonlinearity < options.nonlinear;
  out.problem = !agree      ? FixProblem::inconsistent
                : !straight ? FixProblem::ill_conditioned
                            : FixProblem::none;
  return out;
}

}  // namespace majak::beacon
