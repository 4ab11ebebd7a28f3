// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/tracking_errors.hpp"

#include <gtest/gtest.h>

namespace majak::localize {
namespace {

match::Jackknife shown(double place, double turn) {
  match::Jackknife j;
  j.claimed = Mat3::Identity();
  j.covariance = Vec3(place, place, turn).asDiagonal();
  return j;
}

TEST(TrackingErrors, BeginWithWhatIsClaimed) {
  const Mat3 claimed = Vec3(1, 2, 3).asDiagonal();
  EXPECT_EQ(TrackingErrors().of_scan(claimed), claimed);
  EXPECT_EQ(TrackingErrors().of_wheels(claimed), claimed);
  EXPECT_TRUE(TrackingErrors().of_ranges().isZero(0));
  EXPECT_EQ(TrackingErrors().returns().beam, 0);
}

TEST(TrackingErrors, SettleAtWhatTheScansShow) {
  TrackingErrors errors;
  for (int k = 0; k < 1000; ++k) {
    errors.learn_scan(shown(0.25, 4), 0);
    errors.learn_wheels({0.3, 0.4, 0.1}, Mat3::Identity());
  }
  EXPECT_NEAR(errors.of_scan(Mat3::Identity())(0, 0), 0.25, 1e-6);
  EXPECT_NEAR(errors.of_scan(Mat3::Identity())(2, 2), 4, 1e-6);
  EXPECT_NEAR(errors.of_wheels(Mat3::Identity())(0, 0), 0.125, 1e-6);
  EXPECT_NEAR(errors.of_wheels(Mat3::Identity())(2, 2), 0.01, 1e-6);
}

TEST(TrackingErrors, PartTheReturnsNoiseByIncidence) {
  for (const double surface : {0.1, 0.5, 1.0}) {
    TrackingErrors errors;
    match::Jackknife j = shown(1, 1);
    j.head_on = {100, 100 * ((1 - surface) * 0.9 + surface), 90};
    j.grazing = {100, 100 * ((1 - surface) * 0.1 + surface), 10};
    for (int k = 0; k < 10; ++k) errors.learn_scan(j, 0);
    EXPECT_NEAR(errors.returns().surface, surface, 1e-9);
    EXPECT_NEAR(errors.returns().beam, 1 - surface, 1e-9);
  }
}

TEST(TrackingErrors, AnOffsetThatChangesFromPlaceToPlaceIsAnError) {
  TrackingErrors same, changing;
  match::Jackknife j = shown(1, 1);
  j.by_step = Mat3::Identity();
  for (int k = 0; k < 400; ++k) {
    same.learn_scan(j, 0.01);
    changing.learn_scan(j, k / 50 % 2 == 0 ? 0.01 : -0.01);
  }
  EXPECT_LT(same.of_ranges()(0, 0), 1e-12);
  EXPECT_NEAR(changing.of_ranges()(0, 0), 1e-4, 1e-5);
  j.steps = 4, j.steps_weight = 1e5;
  for (int k = 0; k < 400; ++k) same.learn_scan(j, 0.01);
  EXPECT_NEAR(same.of_ranges()(0, 0), 4e-5, 1e-6);
}

}  // namespace
}  // namespace majak::localize
