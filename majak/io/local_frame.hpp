// SPDX-License-Identifier: Apache-2.0
// LocalFrame: a plane that touches the Earth (WGS 84) at its origin, x east and y north.
#pragma once

#include "majak/core/pose2.hpp"

namespace majak::io {

class LocalFrame {
 public:
  /// Degrees, and metres above the ellipsoid.
  LocalFrame(double latitude, double longitude, double altitude);

  /// East and north of the origin in metres, exact (through Earth-centred coordinates).
  Vec2 east_north(double latitude, double longitude, double altitude) const;

 private:
  Vec3 origin_;
  double sin_lat_, cos_lat_, sin_lon_, cos_lon_;
};

}  // namespace majak::io
