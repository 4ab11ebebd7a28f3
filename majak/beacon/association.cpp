// SPDX-License-Identifier: Apache-2.0
// Which beacon is it? With a prior by the nearest neighbour, without by distances that agree.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "majak/beacon/reflectors.hpp"

#include "majak/core/rigid_fit.hpp"

namespace majak::beacon {
namespace {

/// A sighting that may be this beacon.
struct Pair {
  double distance = 0;  ///< squared Mahalanobis distance
  std::size_t sighting = 0, beacon = 0;
};

/// Squared Mahalanobis distance of what is seen from what this beacon would look like (MATH 7.12).
double mahalanobis(const BeaconSighting& s, const Vec2& beacon, const PosePrior& prior) {
  const Pose2 T_map_sensor = prior.T_map_robot * s.T_robot_sensor;
  const Vec2 way = beacon - T_map_sensor.translation();
  const double square = way.squaredNorm(), range = std::sqrt(square);
  if (!(range > 0)) return std::numeric_limits<double>::infinity();
  const Vec2 arm = T_map_sensor.translation() - prior.T_map_robot.translation();
  Eigen::Matrix<double, 2, 3> H;  // of range and bearing by the robot's pose
  H.row(0) << -way.x() / range, -way.y() / range, (way.x() * arm.y() - way.y() * arm.x()) / range;
  H.row(1) << way.y() / square, -way.x() / square, -1 - way.dot(arm) / square;
  Eigen::Matrix2d S = H * prior.covariance * H.transpose();
  S(0, 0) += s.range_sigma * s.range_sigma;
  S(1, 1) += s.bearing_sigma * s.bearing_sigma;
  const Vec2 v(*s.range - range,
               angle_diff(*s.bearing, std::atan2(way.y(), way.x()) - T_map_sensor.theta));
  const double d = v.dot(S.inverse() * v);
  return std::isfinite(d) ? d : std::numeric_limits<double>::infinity();
}

/// The nearest pairs first, each sighting and each beacon once.
std::vector<Pair> one_to_one(std::vector<Pair> pairs, std::size_t sightings, std::size_t beacons) {
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance, a.sighting, a.beacon) < std::tie(b.distance, b.sighting, b.beacon);
  });
  std::vector<bool> sighting_taken(sightings), beacon_taken(beacons);
  std::vector<Pair> chosen;
  for (const Pair& p : pairs) {
    if (sighting_taken[p.sighting] || beacon_taken[p.beacon]) continue;
    sighting_taken[p.sighting] = beacon_taken[p.beacon] = true;
    chosen.push_back(p);
  }
  return chosen;
}

std::vector<Pair> within_gate(std::span<const BeaconSighting> found, const BeaconMap& map,
                              const PosePrior& prior, double gate) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t b = 0; b < map.beacons.size(); ++b) {
      const double d = mahalanobis(found[i], map.beacons[b].p_map, prior);
      if (d <= gate) pairs.push_back({d, i, b});
    }
  }
  return one_to_one(std::move(pairs), found.size(), map.beacons.size());
}

/// A sighting as a point in the robot's frame.
Vec2 place(const BeaconSighting& s) {
  return s.T_robot_sensor * Vec2(*s.range * std::cos(*s.bearing), *s.range * std::sin(*s.bearing));
}

struct Guess {
  Pose2 T_map_robot;
  std::vector<Pair> pairs;
  double squares = 0;  ///< m^2
  bool better_than(const Guess& other) const {
    return pairs.size() != other.pairs.size() ? pairs.size() > other.pairs.size()
                                              : squares < other.squares;
  }
  bool near(const Guess& other, double distance) const {
    const Pose2 d = between(T_map_robot, other.T_map_robot);
    return d.translation().norm() < 3 * distance && std::abs(d.theta) < 0.1;
  }
};

/// What a pose explains.
Guess judge(const Pose2& T_map_robot, std::span<const Vec2> robot, const BeaconMap& map,
            double distance) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < robot.size(); ++i) {
    const Vec2 p = T_map_robot * robot[i];
    for (std::size_t b = 0; b < map.beacons.size(); ++b) {
      const double d = (map.beacons[b].p_map - p).squaredNorm();
      if (d <= distance * distance) pairs.push_back({d, i, b});
    }
  }
  Guess guess{T_map_robot, one_to_one(std::move(pairs), robot.size(), map.beacons.size()), 0};
  for (const Pair& p : guess.pairs) guess.squares += p.distance;
  return guess;
}

/// The same with the pose that fits all its pairs.
Guess refined(const Guess& guess, std::span<const Vec2> robot, const BeaconMap& map,
              double distance) {
  std::vector<Vec2> from, to;
  for (const Pair& p : guess.pairs) {
    from.push_back(robot[p.sighting]);
    to.push_back(map.beacons[p.beacon].p_map);
  }
  return judge(rigid_fit(from, to), robot, map, distance);
}

/// Every two reflectors that are as far apart as two beacons propose a pose; the pose with the most
/// agreement wins, unless another place agrees as well.
std::vector<Pair> by_distances(std::span<const Vec2> robot, const BeaconMap& map, double distance) {
  Guess best, rival;
  const auto propose = [&](std::size_t i, std::size_t j, std::size_t a, std::size_t b) {
    const std::array<Vec2, 2> from = {robot[i], robot[j]};
    const std::array<Vec2, 2> to = {map.beacons[a].p_map, map.beacons[b].p_map};
    Guess guess = judge(rigid_fit(from, to), robot, map, distance);
    if (guess.pairs.size() < 3 || guess.pairs.size() < rival.pairs.size()) return;
    guess = refined(guess, robot, map, distance);
    if (guess.near(best, distance) || best.pairs.empty()) {
      if (guess.better_than(best)) best = guess;
    } else if (guess.better_than(best)) {
      rival = std::exchange(best, guess);
    } else if (guess.better_than(rival)) {
      rival = guess;
    }
  };
  for (std::size_t i = 0; i < robot.size(); ++i) {
    for (std::size_t j = i + 1; j < robot.size(); ++j) {
      const double seen = (robot[i] - robot[j]).norm();
      for (std::size_t a = 0; a < map.beacons.size(); ++a) {
        for (std::size_t b = 0; b < map.beacons.size(); ++b) {
          const double stated = (map.beacons[a].p_map - map.beacons[b].p_map).norm();
          if (a != b && std::abs(seen - stated) <= distance) propose(i, j, a, b);
        }
      }
    }
  }
  if (best.pairs.size() < 3 || rival.pairs.size() == best.pairs.size()) return {};
  return best.pairs;
}

}  // namespace

std::vector<BeaconSighting> associate(std::span<const BeaconSighting> found, const BeaconMap& map,
                                      const std::optional<PosePrior>& prior,
                                      const ReflectorOptions& o) {
  std::vector<BeaconSighting> whole;
  for (const BeaconSighting& s : found) {
    if (s.range && s.bearing) whole.push_back(s);
  }
  std::vector<Pair> pairs;
  if (prior) {
    pairs = within_gate(whole, map, *prior, o.gate);
  } else {
    std::vector<Vec2> robot;
    robot.reserve(whole.size());
    for (const BeaconSighting& s : whole) robot.push_back(place(s));
    pairs = by_distances(robot, map, o.same_distance);
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return a.sighting < b.sighting; });
  std::vector<BeaconSighting> numbered;
  for (const Pair& p : pairs) {
    numbered.push_back(whole[p.sighting]);
    numbered.back().beacon = map.beacons[p.beacon].number;
  }
  return numbered;
}

}  // namespace majak::beacon
