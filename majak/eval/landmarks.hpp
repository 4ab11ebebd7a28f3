// SPDX-License-Identifier: Apache-2.0
// How good a map of landmarks is: against the true ones, sighting by sighting, and where there is
// no truth against itself.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "majak/core/pose2.hpp"
#include "majak/core/time.hpp"
#include "majak/eval/consistency.hpp"
#include "majak/eval/statistics.hpp"

namespace majak::eval {

// ---- Against the true ones -------------------------------------------------------------------

struct PlacedLandmark {
  Vec2 p = Vec2::Zero();                      ///< m
  std::optional<Eigen::Matrix2d> covariance;  ///< m^2, in the axes of p; none: not known
};

struct LandmarkMatchOptions {
  double reach = 1;    ///< m, that a pair may be apart
  bool align = false;  ///< the map is first brought onto the truth, rigidly, by its pairs
};

struct LandmarkMatch {
  struct Pair {
    std::size_t mapped = 0, truth = 0;  ///< indices into what was given
    Vec2 error = Vec2::Zero();          ///< m, mapped less true, in the truth's axes
    std::optional<double> nees;         ///< 2 expected; where a covariance is known
  };
  std::vector<Pair> pairs;            ///< by `mapped`
  std::vector<std::size_t> missed;    ///< true ones without a pair
  std::vector<std::size_t> mistaken;  ///< mapped ones without a pair
  Pose2 T_truth_map;                  ///< the alignment
  ErrorStats error;                   ///< m, distances of the pairs
  /// Of the pairs that have one. The landmarks of one map err together: for the band take one of
  /// each of many maps. After an alignment what all have in common is gone from the errors but not
  /// from the covariances: honest ones come out below 2.
  NeesSummary nees;
};

/// Pairs are those that are each other's nearest, and within reach. With `align` they are sought
/// twice: for the alignment and after it.
LandmarkMatch match_landmarks(std::span<const PlacedLandmark> mapped,
                              std::span<const PlacedLandmark> truth,
                              const LandmarkMatchOptions& options = {});

// ---- Sighting by sighting --------------------------------------------------------------------

/// How wrong a landmark is placed by one sighting, were the robot's place right: what is left is
/// the heading's and the laser's.
struct SightingError {
  double range = 0;           ///< m, from the laser, true
  Vec2 error = Vec2::Zero();  ///< m: along the beam, and across it to the left
  double by_heading = 0;      ///< m, of that across: range times the heading's error
  double by_laser() const { return error.y() - by_heading; }  ///< m, the rest of that across
};

/// q_robot: the landmark as seen, in the robot's frame; p_true: where it is, in the frame of both
/// poses.
SightingError sighting_error(const Vec2& q_robot, const Pose2& T_map_robot,
                             const Pose2& T_map_truth, const Vec2& p_true,
                             const Pose2& T_robot_laser);

/// Roots of the mean squares of sightings at about one range.
struct RangeBin {
  double range = 0;  ///< m, the bin's middle
  std::size_t count = 0;
  double along = 0, across = 0;         ///< m
  double by_heading = 0, by_laser = 0;  ///< m, of that across
};

/// In bins of `width` m; those of fewer than `least` sightings are left out.
std::vector<RangeBin> errors_over_range(std::span<const SightingError> sightings, double width,
                                        std::size_t least);

// ---- Against itself --------------------------------------------------------------------------

/// That a landmark was seen, from a pose as the run knows it at last.
struct LandmarkSeen {
  Time time = 0;
  Pose2 T_map_robot;
  Vec2 q_robot = Vec2::Zero();  ///< m, the landmark in the robot's frame
  int landmark = 0;
};

struct SplitHalfOptions {
  double block = 60;  ///< s, from the first sighting on: even and odd ones by turns
  int least = 8;      ///< sightings in each half
};

struct SplitHalf {
  struct Landmark {
    int landmark = 0;
    Vec2 even = Vec2::Zero(), odd = Vec2::Zero();  ///< m, mean of the sightings of each half
    double distance() const { return (even - odd).norm(); }
  };
  std::vector<Landmark> landmarks;  ///< seen often enough in both halves, by number
  ErrorStats error;                 ///< m, of the distances
};

/// Split-half repeatability: where each landmark stands by the sightings of even blocks of time
/// alone and by those of odd ones alone. Needs no truth. It judges path and sightings together: the
/// poses are those of the whole run, which saw both halves, so what all of them have wrong alike,
/// such as the scale, does not show.
SplitHalf split_half(std::span<const LandmarkSeen> seen, const SplitHalfOptions& options = {});

}  // namespace majak::eval
