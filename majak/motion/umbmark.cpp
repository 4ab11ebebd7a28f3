// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/umbmark.hpp"

#include <cmath>

#include "majak/core/error.hpp"

namespace majak::motion {
namespace {

struct Ends {
  Vec2 mean = Vec2::Zero();
  Vec2 variance = Vec2::Zero();  ///< of the mean
  int count = 0;
};

Ends ends_of(const std::vector<SquareRun>& runs, bool left) {
  Ends e;
  for (const SquareRun& r : runs)
    if (r.left == left) e.mean += Vec2(r.x, r.y), ++e.count;
  if (e.count == 0) return e;
  e.mean /= e.count;
  if (e.count < 2) return e;
  for (const SquareRun& r : runs)
    if (r.left == left) e.variance += (Vec2(r.x, r.y) - e.mean).cwiseAbs2();
  e.variance /= e.count * (e.count - 1);
  return e;
}

}  // namespace

// To first order a corner that turns too far by a and a side that bends by b end at
//   left squares (2 L (a + b), -2 L (a + b)),   right ones (2 L (a - b), 2 L (a - b))       (9.8)
Umbmark umbmark(const std::vector<SquareRun>& runs, double side, double track) {
  if (!(side > 0)) throw Error("a square has a side of more than 0 m");
  const Ends left = ends_of(runs, true), right = ends_of(runs, false);
  if (left.count == 0 || right.count == 0)
    throw Error("squares to the left and to the right are needed");
  Umbmark u;
  u.centre_left = left.mean, u.centre_right = right.mean;
  u.systematic = std::max(left.mean.norm(), right.mean.norm());
  const double sum = (left.mean.x() - left.mean.y()) / (4 * side);           // a + b
  const double difference = (right.mean.x() + right.mean.y()) / (4 * side);  // a - b
  const double corner = (sum + difference) / 2, bend = (sum - difference) / 2;
  const double sigma = std::sqrt(left.variance.sum() + right.variance.sum()) / (8 * side);
  u.turn_scale = {1 + corner / (kPi / 2), sigma / (kPi / 2), true};
  u.turn_per_metre = {bend / side, sigma / side, true};
  u.correction.turn_scale = u.turn_scale.value;
  u.correction.turn_per_metre = u.turn_per_metre.value;
  if (track > 0) {
    // The odometry's turn is (dR - dL) / track: a wider true track turns less.
    u.track = {track / u.turn_scale.value,
               track * u.turn_scale.sigma / (u.turn_scale.value * u.turn_scale.value), true};
    const double half = u.turn_per_metre.value * u.track.value / 2;
    u.wheel_ratio = {(1 + half) / (1 - half), u.turn_per_metre.sigma * u.track.value, true};
  }
  return u;
}

}  // namespace majak::motion
