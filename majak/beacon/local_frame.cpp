// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/local_frame.hpp"

#include <cmath>

namespace majak::beacon {

namespace {

constexpr double kEquator = 6378137.0;  // m
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kSquaredEccentricity = kFlattening * (2.0 - kFlattening);

/// Earth-centred, Earth-fixed coordinates on WGS 84, m.
Vec3 earth_centred(const Geodetic& place) {
  const double latitude = radians(place.latitude), longitude = radians(place.longitude);
  const double s = std::sin(latitude), c = std::cos(latitude);
  const double normal = kEquator / std::sqrt(1.0 - kSquaredEccentricity * s * s);
  return {(normal + place.altitude) * c * std::cos(longitude),
          (normal + place.altitude) * c * std::sin(longitude),
          (normal * (1.0 - kSquaredEccentricity) + place.altitude) * s};
}

}  // namespace

// Bowring, "The accuracy of geodetic latitude and height equations", Survey Review 28, 1985, by
// the parametric latitude; three rounds leave less than a nanometre. Good at the poles too.
Geodetic geodetic_of(const Vec3& p) {
  constexpr double kPole = kEquator * (1.0 - kFlattening);
  constexpr double kSecond = kSquaredEccentricity / (1.0 - kSquaredEccentricity);
  const double from_axis = std::hypot(p.x(), p.y());
  double parametric = std::atan2(p.z(), from_axis * (1.0 - kFlattening)), latitude = 0;
  for (int round = 0; round < 3; ++round) {
    const double s = std::sin(parametric), c = std::cos(parametric);
    latitude = std::atan2(p.z() + kSecond * kPole * s * s * s,
                          from_axis - kSquaredEccentricity * kEquator * c * c * c);
    parametric = std::atan2((1.0 - kFlattening) * std::sin(latitude), std::cos(latitude));
  }
  const double s = std::sin(latitude), c = std::cos(latitude);
  const double altitude =
      from_axis * c + p.z() * s - kEquator * std::sqrt(1.0 - kSquaredEccentricity * s * s);
  return {degrees(latitude), degrees(std::atan2(p.y(), p.x())), altitude};
}

LocalFrame::LocalFrame(const Geodetic& origin)
    : origin_(earth_centred(origin)),
      sin_lat_(std::sin(radians(origin.latitude))),
      cos_lat_(std::cos(radians(origin.latitude))),
      sin_lon_(std::sin(radians(origin.longitude))),
      cos_lon_(std::cos(radians(origin.longitude))) {}

Mat3 LocalFrame::axes() const {
  Mat3 axes;
  axes.col(0) << -sin_lon_, cos_lon_, 0;
  axes.col(1) << -sin_lat_ * cos_lon_, -sin_lat_ * sin_lon_, cos_lat_;
  axes.col(2) << cos_lat_ * cos_lon_, cos_lat_ * sin_lon_, sin_lat_;
  return axes;
}

Vec2 LocalFrame::east_north(const Geodetic& place) const {
  const Vec3 d = earth_centred(place) - origin_;
  // (MATH 7.14)
  return {-sin_lon_ * d.x() + cos_lon_ * d.y(),
          -sin_lat_ * (cos_lon_ * d.x() + sin_lon_ * d.y()) + cos_lat_ * d.z()};
}

Geodetic LocalFrame::geodetic(const Vec2& east_north, double altitude) const {
  const Mat3 axes = this->axes();
  // How far below the plane the place lies: the Earth bends away slowly, so this settles fast.
  double height = 0;
  Geodetic place;
  for (int round = 0; round < 20; ++round) {
    place = geodetic_of(origin_ + axes * Vec3(east_north.x(), east_north.y(), height));
    const double missing = altitude - place.altitude;
    height += missing;
    if (std::abs(missing) < 1e-9) break;
  }
  return place;
}

}  // namespace majak::beacon
