// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/local_frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "majak/core/random.hpp"

#ifdef MAJAK_HAVE_GEOGRAPHICLIB
#include <GeographicLib/LocalCartesian.hpp>
#endif

namespace majak::beacon {
namespace {

TEST(LocalFrame, ItsOriginIsZero) {
  const LocalFrame frame({48.0, 7.85, 250});
  EXPECT_NEAR(frame.east_north({48.0, 7.85, 250}).norm(), 0, 1e-8);
}

TEST(LocalFrame, HeightDoesNotMoveTheOrigin) {
  const LocalFrame frame({48.0, 7.85, 250});
  EXPECT_NEAR(frame.east_north({48.0, 7.85, 900}).norm(), 0, 1e-6);
}

/// The slow twin: arcs with the radii of curvature of WGS 84, good to a centimetre over 100 m.
TEST(LocalFrame, SmallStepsFollowTheRadiiOfCurvature) {
  const double a = 6378137.0, b = 6356752.314245;
  for (const double latitude : {-60.0, -33.9, 0.0, 0.1, 48.0, 89.0}) {
    const double phi = radians(latitude), c = std::cos(phi), s = std::sin(phi);
    const double w = a * a * c * c + b * b * s * s;
    const double meridian = a * a * b * b / std::pow(w, 1.5), normal = a * a / std::sqrt(w);
    const LocalFrame frame({latitude, 151.2, 0});
    const double d = 1e-5;  // degrees, about a metre
    const Vec2 north = frame.east_north({latitude + d, 151.2, 0}),
               east = frame.east_north({latitude, 151.2 + d, 0});
    EXPECT_NEAR(north.y(), meridian * radians(d), 1e-5);
    EXPECT_NEAR(north.x(), 0, 1e-5);
    EXPECT_NEAR(east.x(), normal * c * radians(d), 1e-5);
    EXPECT_NEAR(east.y(), 0, 1e-5);
  }
}

TEST(LocalFrame, CrossesTheDateLine) {
  const LocalFrame frame({10, 179.9999, 0});
  EXPECT_NEAR(frame.east_north({10, -179.9999, 0}).x(), 21.93, 0.05);
}

TEST(LocalFrame, InverseIsTheInverse) {
  RandomStream random(1);
  for (int i = 0; i < 3000; ++i) {
    const Geodetic origin{random.uniform(-90, 90), random.uniform(-180, 180),
                          random.uniform(-50, 3000)};
    const LocalFrame frame(origin);
    const double far = std::pow(10, random.uniform(0, 5.5));
    const Vec2 p(far * random.uniform(-1, 1), far * random.uniform(-1, 1));
    const Geodetic place = frame.geodetic(p, 100);
    EXPECT_NEAR(place.altitude, 100, 1e-8);
    EXPECT_GE(place.latitude, -90);
    EXPECT_LE(place.latitude, 90);
    EXPECT_LT((frame.east_north(place) - p).norm(), 1e-7) << far;  // seen: 6e-9
  }
}

TEST(LocalFrame, AxesAreARotationAndStandOnTheOrigin) {
  RandomStream random(2);
  for (int i = 0; i < 300; ++i) {
    const Geodetic origin{random.uniform(-89, 89), random.uniform(-180, 180),
                          random.uniform(-50, 3000)};
    const LocalFrame frame(origin);
    const Geodetic again = geodetic_of(frame.origin());
    EXPECT_NEAR(again.latitude, origin.latitude, 1e-11);
    EXPECT_NEAR(again.longitude, origin.longitude, 1e-11);
    EXPECT_NEAR(again.altitude, origin.altitude, 1e-8);
    EXPECT_LT((frame.axes() * frame.axes().transpose() - Mat3::Identity()).norm(), 1e-14);
    EXPECT_NEAR(frame.axes().determinant(), 1, 1e-14);
    const Vec3 p = frame.origin() + frame.axes() * Vec3(30, -40, 7);
    EXPECT_LT((frame.east_north(geodetic_of(p)) - Vec2(30, -40)).norm(), 1e-7);
  }
}

TEST(FirstFixFrame, IsThatOfTheFirstFixOrTheOneThatItWasTold) {
  FirstFixFrame own, told;
  EXPECT_FALSE(own.begun());
  EXPECT_LT(own.east_north({48, 8, 0}).norm(), 1e-8);
  EXPECT_TRUE(own.begun());
  const LocalFrame frame({48.001, 8, 0});
  told.begin_at(frame);
  EXPECT_EQ(told.east_north({48, 8, 0}), frame.east_north({48, 8, 0}));
}

TEST(LocalFrame, AtAndAcrossThePoles) {
  for (const double pole : {90.0, -90.0}) {
    const LocalFrame frame({pole, 30, 0});
    EXPECT_LT(frame.east_north({pole, -77, 0}).norm(), 1e-8);  // one place, whatever the longitude
    // 100 m towards the meridian across, and back.
    const Geodetic place = frame.geodetic({0, 100}, 0);
    EXPECT_NEAR(std::abs(place.latitude), 90 - 100 / 111694.0, 1e-6);
    EXPECT_NEAR(std::abs(angle_diff(radians(place.longitude), radians(pole > 0 ? -150 : 30))), 0,
                1e-9);
  }
  // A walk over the pole is straight.
  const LocalFrame near_pole({89.9995, 0, 0});
  const double step = near_pole.east_north({90, 0, 0}).y();
  EXPECT_NEAR(step, 0.0005 * 111694, 1);
  EXPECT_NEAR(near_pole.east_north({89.9995, 180, 0}).y(), 2 * step, 1e-3);
  EXPECT_NEAR(near_pole.east_north({89.9995, 180, 0}).x(), 0, 1e-6);
}

TEST(LocalFrame, InverseCrossesTheDateLine) {
  const LocalFrame frame({10, 179.9999, 0});
  EXPECT_NEAR(frame.geodetic({21.93, 0}).longitude, -179.9999, 1e-6);
  EXPECT_NEAR(LocalFrame({10, -179.9999, 0}).geodetic({-21.93, 0}).longitude, 179.9999, 1e-6);
}

TEST(FirstFixFrame, IsSetByTheFirst) {
  FirstFixFrame frame;
  EXPECT_LT(frame.east_north({48, 7, 100}).norm(), 1e-8);
  EXPECT_NEAR(frame.east_north({48.001, 7, 100}).y(), 111.2, 0.1);
}

TEST(LocalFrame, AgreesWithGeographicLib) {
#ifndef MAJAK_HAVE_GEOGRAPHICLIB
  GTEST_SKIP() << "GeographicLib is not installed (libgeographiclib-dev)";
#else
  RandomStream random(2);
  for (int i = 0; i < 3000; ++i) {
    const Geodetic o{random.uniform(-90, 90), random.uniform(-180, 180), random.uniform(-50, 3000)};
    const Geodetic p{std::clamp(o.latitude + random.uniform(-1, 1), -90.0, 90.0),
                     o.longitude + random.uniform(-1, 1), random.uniform(-50, 3000)};
    const GeographicLib::LocalCartesian theirs(o.latitude, o.longitude, o.altitude);
    double x = 0, y = 0, z = 0, latitude = 0, longitude = 0, altitude = 0;
    theirs.Forward(p.latitude, p.longitude, p.altitude, x, y, z);
    const LocalFrame ours(o);
    EXPECT_LT((ours.east_north(p) - Vec2(x, y)).norm(), 1e-7);
    const Geodetic back = ours.geodetic({x, y}, p.altitude);
    theirs.Reverse(x, y, z, latitude, longitude, altitude);
    EXPECT_NEAR(back.latitude, latitude, 1e-12);
    EXPECT_NEAR(
        angle_diff(radians(back.longitude), radians(longitude)) * std::cos(radians(latitude)), 0,
        1e-14);
  }
#endif
}

}  // namespace
}  // namespace majak::beacon
