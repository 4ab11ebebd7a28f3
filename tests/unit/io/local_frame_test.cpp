// SPDX-License-Identifier: Apache-2.0
#include "majak/io/local_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace majak::io {
namespace {

TEST(LocalFrame, ItsOriginIsZero) {
  const LocalFrame frame(48.0, 7.85, 250);
  EXPECT_NEAR(frame.east_north(48.0, 7.85, 250).norm(), 0, 1e-8);
}

TEST(LocalFrame, HeightDoesNotMoveTheOrigin) {
  const LocalFrame frame(48.0, 7.85, 250);
  EXPECT_NEAR(frame.east_north(48.0, 7.85, 900).norm(), 0, 1e-6);
}

/// The slow twin: arcs with the radii of curvature of WGS 84, good to a centimetre over 100 m.
TEST(LocalFrame, SmallStepsFollowTheRadiiOfCurvature) {
  const double a = 6378137.0, b = 6356752.314245;
  for (const double latitude : {-60.0, -33.9, 0.0, 0.1, 48.0, 89.0}) {
    const double phi = radians(latitude), c = std::cos(phi), s = std::sin(phi);
    const double w = a * a * c * c + b * b * s * s;
    const double meridian = a * a * b * b / std::pow(w, 1.5), normal = a * a / std::sqrt(w);
    const LocalFrame frame(latitude, 151.2, 0);
    const double d = 1e-5;  // degrees, about a metre
    const Vec2 north = frame.east_north(latitude + d, 151.2, 0),
               east = frame.east_north(latitude, 151.2 + d, 0);
    EXPECT_NEAR(north.y(), meridian * radians(d), 1e-5);
    EXPECT_NEAR(north.x(), 0, 1e-5);
    EXPECT_NEAR(east.x(), normal * c * radians(d), 1e-5);
    EXPECT_NEAR(east.y(), 0, 1e-5);
  }
}

TEST(LocalFrame, CrossesTheDateLine) {
  const LocalFrame frame(10, 179.9999, 0);
  EXPECT_NEAR(frame.east_north(10, -179.9999, 0).x(), 21.93, 0.05);
}

}  // namespace
}  // namespace majak::io
