// SPDX-License-Identifier: Apache-2.0
#include "majak/io/local_frame.hpp"

#include <cmath>

namespace majak::io {

namespace {

/// Earth-centred, Earth-fixed coordinates on WGS 84; radians and metres in, metres out.
Vec3 earth_centred(double latitude, double longitude, double altitude) {
  constexpr double kEquator = 6378137.0;
  constexpr double kFlattening = 1.0 / 298.257223563;
  constexpr double kSquaredEccentricity = kFlattening * (2.0 - kFlattening);
  const double s = std::sin(latitude), c = std::cos(latitude);
  const double normal = kEquator / std::sqrt(1.0 - kSquaredEccentricity * s * s);
  return {(normal + altitude) * c * std::cos(longitude),
          (normal + altitude) * c * std::sin(longitude),
          (normal * (1.0 - kSquaredEccentricity) + altitude) * s};
}

}  // namespace

LocalFrame::LocalFrame(double latitude, double longitude, double altitude)
    : origin_(earth_centred(radians(latitude), radians(longitude), altitude)),
      sin_lat_(std::sin(radians(latitude))),
      cos_lat_(std::cos(radians(latitude))),
      sin_lon_(std::sin(radians(longitude))),
      cos_lon_(std::cos(radians(longitude))) {}

Vec2 LocalFrame::east_north(double latitude, double longitude, double altitude) const {
  const Vec3 d = earth_centred(radians(latitude), radians(longitude), altitude) - origin_;
  return {-sin_lon_ * d.x() + cos_lon_ * d.y(),
          -sin_lat_ * (cos_lon_ * d.x() + sin_lon_ * d.y()) + cos_lat_ * d.z()};
}

}  // namespace majak::io
