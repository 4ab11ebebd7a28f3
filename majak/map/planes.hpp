// SPDX-License-Identifier: Apache-2.0
// Flat surfaces among points in space, by expectation and maximization (Liu, Emery, Chakrabarti,
// Burgard, Thrun 2001): each point belongs to planes by shares, or to none; each plane is fitted to
// the points by their shares of it; how many planes there are decides a penalty for each. A plane
// is bounded: it holds points in blocks of space that hang together, so that what lies in one line
// in another room is not of it. MATH 22.2.
#pragma once

#include <cstdint>
#include <vector>

#include "majak/core/parallel.hpp"
#include "majak/map/solid_points.hpp"

namespace majak::map {

struct PlaneOptions {
  double sigma = 0.02;                ///< m, of a point's mean off its plane
  double normal_sigma = radians(15);  ///< rad, of a point's normal
  double gate = 3;                    ///< sigmas; a point farther off is of no plane, rather
  double min_area = 0.5;              ///< m^2, the penalty: a plane explains that much or is none
  double block = 0.5;                 ///< m, side of the blocks that bound a plane
  int min_count = 1;                  ///< returns; points of fewer are of no plane
  int max_rounds = 30;                ///< of expectation and maximization, at most
  int seed = 1;                       ///< the order in which points propose planes
};

inline void describe(OptionFields& fields, PlaneOptions& o) {
  fields.add("planes.sigma", o.sigma, {"m", "of a point off its plane", 1e-4, 1});
  fields.add("planes.normal_sigma", o.normal_sigma, {"rad", "of a point's normal", 0.01, 3});
  fields.add("planes.gate", o.gate, {"1", "sigmas; farther off is of no plane", 1, 10});
  fields.add("planes.min_area", o.min_area,
             {"m^2", "a plane explains as much, or is none", 0, 1e4});
  fields.add("planes.block", o.block, {"m", "side of the blocks that bound a plane", 0.05, 100});
  fields.add("planes.min_count", o.min_count,
             {"1", "returns; points of fewer are of none", 1, 1000});
  fields.add("planes.max_rounds", o.max_rounds, {"1", "of the iteration", 1, 1000});
  fields.add("planes.seed", o.seed, {"", "order in which points propose", 0, 2147483647});
}

/// normal . p = offset. Map frame.
struct Plane {
  Vec3 normal = Vec3::UnitZ();                      ///< unit, towards who saw it
  double offset = 0;                                ///< m
  Vec3 centre = Vec3::Zero();                       ///< m, mean of its points
  double support = 0;                               ///< points, by their shares
  double rms = 0;                                   ///< m, of its points off it
  std::vector<std::array<std::int32_t, 3>> blocks;  ///< where it is, in order
};

struct PlaneMap {
  std::vector<Plane> planes;           ///< the best supported first
  std::vector<std::int32_t> plane_of;  ///< a point: the plane that has most of it; -1: none
  int rounds = 0;                      ///< of expectation and maximization
  double log_likelihood = 0;           ///< over that of no planes at all, penalties taken off
};

/// Throws Error when an option is out of its range. Same result for any number of threads.
PlaneMap find_planes(const SolidCloud& cloud, const PlaneOptions& options = {},
                     Threads threads = {});

/// How well a plane explains a point, 0 ... 1: exp(-chi2 / 2) of distance and normal (22.3).
double explains(const Plane& plane, const SolidPoint& point, const PlaneOptions& options);

/// The block of space that holds a place.
std::array<std::int32_t, 3> block_of(const Vec3& p, double block);

}  // namespace majak::map
