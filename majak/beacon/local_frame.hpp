// SPDX-License-Identifier: Apache-2.0
// LocalFrame: a plane that touches the Earth (WGS 84) at its origin, x east and y north.
#pragma once

#include <optional>

#include "majak/core/pose2.hpp"

namespace majak::beacon {

/// A place on the Earth.
struct Geodetic {
  double latitude = 0;   ///< degrees, north positive, -90 ... 90
  double longitude = 0;  ///< degrees, east positive; given out in (-180, 180]
  double altitude = 0;   ///< m above the ellipsoid
};

/// The place of a point in Earth-centred, Earth-fixed coordinates (m).
Geodetic geodetic_of(const Vec3& p_earth);

class LocalFrame {
 public:
  explicit LocalFrame(const Geodetic& origin);

  /// Where the frame stands in Earth-centred, Earth-fixed coordinates: origin (m) and axes, the
  /// columns being east, north and up.
  const Vec3& origin() const { return origin_; }
  Mat3 axes() const;

  /// East and north of the origin in metres, exact (through Earth-centred coordinates). At a pole
  /// north is where the origin's longitude says.
  Vec2 east_north(const Geodetic& place) const;

  /// The place at this altitude that is so far east and north; within 1000 km of the origin.
  Geodetic geodetic(const Vec2& east_north, double altitude = 0) const;

 private:
  Vec3 origin_;
  double sin_lat_, cos_lat_, sin_lon_, cos_lon_;
};

/// The frame that the first fix sets, unless it is told before.
class FirstFixFrame {
 public:
  void begin_at(const LocalFrame& frame) { frame_ = frame; }
  bool begun() const { return frame_.has_value(); }
  Vec2 east_north(const Geodetic& place) {
    if (!frame_) frame_.emplace(place);
    return frame_->east_north(place);
  }

 private:
  std::optional<LocalFrame> frame_;
};

}  // namespace majak::beacon
