// SPDX-License-Identifier: Apache-2.0
// A solid seen in perspective, as marks of a figure: surfaces that face the eye, painted from the
// farthest to the nearest.
#pragma once

#include <vector>

#include "majak/core/pose3.hpp"
#include "majak/draw/figure.hpp"
#include "majak/map/solid.hpp"

namespace majak::draw {

/// What is at a place is seen at two tangents, to the right and up.
class Camera {
 public:
  /// m; not straight down or up.
  Camera(const Vec3& eye, const Vec3& at);

  Point see(const Vec3& p) const;
  double distance(const Vec3& p) const { return (p - eye_).norm(); }
  /// Is the side of its normal seen?
  bool faces(const Vec3& normal, const Vec3& p) const { return normal.dot(eye_ - p) > 0; }

 private:
  Vec3 eye_, ahead_, right_, up_;
};

/// From the south and above, all of the solid in view.
Camera overlooking(const map::Solid& solid);

/// Rectangles larger than `tile` (m) are cut, so that nearer ones hide farther ones; where that
/// would be more than `most` pieces, into larger ones.
std::vector<Mark> view_of(const map::Solid& solid, const Camera& camera, double tile = 0.5,
                          int most = 12000);

}  // namespace majak::draw
