// SPDX-License-Identifier: Apache-2.0
// Scan matching by point-to-line least squares against a surfel map (Censi 2008 has the metric; the
// nearest surfel comes from the map's grid instead of a search).
#pragma once

#include "majak/core/pose2.hpp"
#include "majak/map/surfel_map.hpp"
#include "majak/match/scan_points.hpp"

namespace majak::match {

// Map: SurfelMap, SharedSurfelMap or OlderSurfels.

/// Variance of a return off its surface, as shares of AlignOptions::sigma^2: the error along the
/// beam shows across the surface by the cosine of incidence, that of the surface fully.
struct ReturnNoise {
  double beam = 0;     ///< times cos^2
  double surface = 1;  ///< the same for all
  double spot = 0;     ///< 1/m^2, times sin^2 and the range squared: the spot has a width
};

/// Of a return that the laser saw along `way` (m, any frame that `normal`, unit, is in, too).
inline double return_variance(const ReturnNoise& noise, const Vec2& normal, const Vec2& way) {
  const double r2 = way.squaredNorm(), across = normal.dot(way), a2 = across * across;
  return noise.beam * a2 / (r2 + 1e-6) + noise.surface + noise.spot * (r2 - a2);
}

struct AlignOptions {
  int max_iterations = 12;
  double gate = 0.30;          ///< m, pairs farther apart do not count, first iteration
  double final_gate = 0.10;    ///< m, the same once the pose has settled
  double sigma = 0.02;         ///< m, of a return off its surface
  double first_cauchy = 0.04;  ///< m, residual at which a pair counts half, first iteration
  double cauchy = 0.04;        ///< m, the same once the pose has settled
  double full_range = 2.0;  ///< m, a return this far or farther counts fully, a nearer one by the
                            ///< square of its share
  ReturnNoise noise;
  double tolerance = 2e-4;  ///< m (and rad times 5 m), a smaller step ends the iteration
};

/// What is known before the scan: a pose and its information in the map's axes.
struct PosePrior {
  Pose2 T_map_robot;
  Mat3 information = Mat3::Zero();
};

struct Match {
  Pose2 T_map_robot;
  Mat3 information =
      Mat3::Zero();  ///< of the pairs alone, without the prior, axes of the map at the robot
  double rms = 0;    ///< m, of the inliers
  double score = 0;  ///< share of the points that lie on the map within final_gate
  int inliers = 0;
  int iterations = 0;
  bool converged = false;
};

/// Is the position held in every direction, or does a match of this information slide along
/// something, as in a corridor?
bool holds_all_round(const Mat3& information);

/// Share of the points within `gate` m of a surface of the map; 0 of none.
template <class Map>
double share_on(const ScanPoints& points, const Map& map, const Pose2& T_map_robot, double gate);

/// How many points lie within `gate` m of a surface that stands across `direction` (unit, map
/// frame): these tell how far a pose is along it.
int count_across(const ScanPoints& points, const map::SurfelMap& map, const Pose2& T_map_robot,
                 const Vec2& direction, double gate);

/// S, to be used as S * information * S: scales down the direction in which the information is
/// hardly more than what the noise of the surfaces' normals feigns. Along an empty corridor nothing
/// is left.
Mat3 without_normal_noise(const Mat3& information);

/// Least-squares pose of `points` on `map`, started at prior.T_map_robot and held by its
/// information where the pairs say nothing.
template <class Map>
Match align(const ScanPoints& points, const Map& map, const PosePrior& prior,
            const AlignOptions& options);

/// What align() climbs, without the prior: logarithm of the returns' likelihood at a pose, 0 where
/// all lie on surfaces; a return off the map costs as much as one at final_gate. As if returns were
/// independent of each other.
template <class Map>
double log_likelihood(const ScanPoints& points, const Map& map, const Pose2& T_map_robot,
                      const AlignOptions& options);

}  // namespace majak::match
