// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/obstacle_errors.hpp"

#include <cmath>

#include "majak/eval/trajectory.hpp"

namespace majak::eval {
namespace {

/// By number, the true one that a landmark is.
std::vector<std::optional<Vec2>> true_places(const slam::LandmarkMap& map,
                                             const LandmarkMatch& match,
                                             const std::vector<std::size_t>& standing,
                                             const std::vector<Vec2>& trunks) {
  std::vector<std::optional<Vec2>> places(map.landmarks.size());
  for (const LandmarkMatch::Pair& pair : match.pairs)
    places[standing[pair.mapped]] = trunks[pair.truth];
  return places;
}

int square_of(const Vec2& p) {
  constexpr double kSide = 50;  // m
  return static_cast<int>(std::floor(p.x() / kSide)) * 1000 +
         static_cast<int>(std::floor(p.y() / kSide));
}

}  // namespace

ObstacleErrors obstacle_errors(const slam::LandmarkMap& map, const Trajectory& truth,
                               const std::vector<Vec2>& trunks, const Pose2& T_robot_laser) {
  ObstacleErrors errors;
  const auto& estimates = map.localization.estimates;
  std::vector<std::optional<Vec2>> places;
  for (const slam::MappedLandmark& l : map.landmarks) places.emplace_back(l.p_map);
  if (!trunks.empty()) {
    std::vector<PlacedLandmark> mapped, placed;
    std::vector<std::size_t> standing;
    for (std::size_t i = 0; i < map.landmarks.size(); ++i)
      if (!map.landmarks[i].gone) {
        standing.push_back(i);
        mapped.push_back({map.landmarks[i].p_map, map.landmarks[i].covariance});
      }
    for (const Vec2& p : trunks) placed.push_back({p, {}});
    errors.match = match_landmarks(mapped, placed);
    errors.aligned = match_landmarks(mapped, placed, {.align = true});
    places = true_places(map, *errors.match, standing, trunks);
  }
  std::vector<LandmarkSeen> seen;
  const TrajectoryIndex index(truth);
  for (const slam::LandmarkObservation& o : map.observations) {
    const Estimate& e = estimates[o.scan];
    seen.push_back({e.time, e.T_map_robot, o.q_robot, o.landmark});
    const auto& place = places[static_cast<std::size_t>(o.landmark)];
    const auto truly = index.at(e.time);
    if (place && (truly || truth.empty()))
      errors.sightings.push_back(sighting_error(
          o.q_robot, e.T_map_robot, truly ? truly->pose : e.T_map_robot, *place, T_robot_laser));
  }
  errors.split = split_half(seen);
  return errors;
}

Headline headline(const LandmarkMatch& match, const std::vector<Vec2>& trunks) {
  std::vector<PlaceError> errors;
  for (const LandmarkMatch::Pair& pair : match.pairs)
    errors.push_back({0, pair.error, square_of(trunks[pair.truth]), true, pair.nees});
  return headline(errors);
}

Headline headline(const SplitHalf& split) {
  std::vector<PlaceError> errors;
  for (const SplitHalf::Landmark& l : split.landmarks)
    errors.push_back({0, l.even - l.odd, square_of(l.even), true, {}});
  return headline(errors);
}

}  // namespace majak::eval
