// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/habit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

constexpr double kLeastSigma = 0.02, kMostSigma = 0.10;  // m, rad

/// What a habit foretold over a drive, counted from the 200th scan on.
struct Foretold {
  double rms_translation = 0, rms_rotation = 0;  // m of each axis, rad; against the truth
  double rms_of_last = 0;                        // m, had the last motion been foretold
  double sigma_translation = 0, sigma_rotation = 0;
};

struct Step {
  double time = 0.1;  // s since the scan before
  Vec3 truth, found;  // twist of the whole step
};

Foretold drive(const std::function<Step(int)>& step_of, int scans = 500) {
  Habit habit;
  Foretold f;
  Vec3 before = Vec3::Zero();
  int n = 0;
  for (int i = 0; i < scans; ++i) {
    const Step step = step_of(i);
    const Duration time = from_seconds(step.time);
    const Habit::Prediction p = habit.predict(time);
    if (i >= 200) {
      const Pose2 off = between(p.T_previous_robot, exp(step.truth));
      f.rms_translation += off.translation().squaredNorm() / 2, ++n;
      f.rms_rotation += off.theta * off.theta;
      f.rms_of_last += between(exp(before), exp(step.truth)).translation().squaredNorm() / 2;
    }
    f.sigma_translation = p.sigma_translation, f.sigma_rotation = p.sigma_rotation;
    habit.observe(exp(step.found), time, true);
    before = step.found;
  }
  for (double* square : {&f.rms_translation, &f.rms_rotation, &f.rms_of_last})
    *square = std::sqrt(*square / n);
  return f;
}

const Vec3 kVelocity(0.6, 0.05, 0.4);  // m/s, m/s, rad/s

TEST(Habit, ConstantVelocityGoesByTime) {
  RandomStream r(1);
  const Foretold f = drive([&](int) {
    const double time = r.uniform(0.06, 0.17);  // stamps come as they come
    return Step{time, time * kVelocity, time * kVelocity};
  });
  EXPECT_LT(f.rms_translation, 1e-9);
  EXPECT_LT(f.rms_rotation, 1e-9);
  EXPECT_GT(f.rms_of_last, 0.01);  // by scan one would be off
  EXPECT_NEAR(f.sigma_translation, kLeastSigma, 1e-12);
}

TEST(Habit, StampsInBurstsTellNoVelocity) {
  // Every scan is the same way on, whatever its stamp says.
  for (const double burst : {0.06, 0.04, 0.001}) {
    const Foretold f = drive([&](int i) {
      return Step{i % 2 == 0 ? burst : 0.2 - burst, 0.1 * kVelocity, 0.1 * kVelocity};
    });
    EXPECT_LT(f.rms_translation, 1e-9) << burst;
    EXPECT_LT(f.rms_rotation, 1e-9) << burst;
  }
}

TEST(Habit, OfNoisyMotionsTheMeanIsBest) {
  RandomStream r(2);
  const double sigma = 0.02;
  const Foretold f = drive([&](int) {
    const Vec3 noise(sigma * r.normal(), sigma * r.normal(), sigma * r.normal());
    return Step{0.1, 0.1 * kVelocity, 0.1 * kVelocity + noise};
  });
  EXPECT_NEAR(f.rms_of_last, sigma, 0.1 * sigma);
  EXPECT_NEAR(f.rms_translation, sigma / 2, 0.1 * sigma);  // of four
  EXPECT_NEAR(f.rms_rotation, sigma / 2, 0.1 * sigma);
  // Twice the rms error that it had against what was found: sigma of the motion and of the mean.
  EXPECT_NEAR(f.sigma_translation, 2 * sigma * std::sqrt(1.25), 0.3 * sigma);
  EXPECT_NEAR(f.sigma_rotation, 2 * sigma * std::sqrt(1.25), 0.3 * sigma);
}

TEST(Habit, TurnsAndWaysAreForetoldEachInItsOwnManner) {
  // The way goes by time and the turn by scan: no one manner foretells both.
  RandomStream r(3);
  const Foretold f = drive([&](int) {
    const double time = r.uniform(0.06, 0.17);
    const Vec3 twist(0.6 * time, 0, 0.04);
    return Step{time, twist, twist};
  });
  EXPECT_LT(f.rms_translation, 1e-9);
  EXPECT_LT(f.rms_rotation, 1e-9);
}

TEST(Habit, IsNeverSurerNorLessSureThanItsBounds) {
  RandomStream r(4);
  for (const double size : {0.0, 0.01, 0.1, 3.0}) {
    Habit habit;
    for (int i = 0; i < 300; ++i) {
      const Duration time = from_seconds(r.uniform(0, 0.3));
      const Habit::Prediction p = habit.predict(time);
      ASSERT_TRUE(p.T_previous_robot.finite());
      for (const double sigma : {p.sigma_translation, p.sigma_rotation}) {
        ASSERT_GE(sigma, kLeastSigma);
        ASSERT_LE(sigma, kMostSigma);
      }
      habit.observe({size * r.normal(), size * r.normal(), wrap_angle(size * r.normal())}, time,
                    i % 5 > 0);
    }
    const Habit::Prediction p = habit.predict(kSecond / 10);
    if (size == 0) {
      EXPECT_NEAR(p.sigma_translation, kLeastSigma, 1e-12);
    }
    if (size > 1) {
      EXPECT_NEAR(p.sigma_translation, kMostSigma, 0.01);
    }
  }
}

TEST(Habit, KnowingNothingItExpectsNothing) {
  for (const double time : {0.0, 0.1, 100.0, -1.0}) {
    const Habit::Prediction p = Habit{}.predict(from_seconds(time));
    EXPECT_EQ(p.T_previous_robot, Pose2{});
    EXPECT_DOUBLE_EQ(p.sigma_translation, kMostSigma);
    EXPECT_DOUBLE_EQ(p.sigma_rotation, kMostSigma);
  }
}

TEST(Habit, WhatIsForgottenIsNotGoneOnWith) {
  Habit habit;
  const Pose2 step = exp(0.1 * kVelocity), other{-0.02, 0.01, -0.03};
  for (int i = 0; i < 50; ++i) habit.observe(step, kSecond / 10, true);
  EXPECT_LT(between(step, habit.predict(kSecond / 10).T_previous_robot).vector().norm(), 1e-9);
  habit.forget();
  const Habit::Prediction p = habit.predict(kSecond / 10);
  EXPECT_EQ(p.T_previous_robot, Pose2{});
  EXPECT_DOUBLE_EQ(p.sigma_translation, kMostSigma);
  // Not even in the mean.
  habit.observe(other, kSecond / 10, true);
  EXPECT_LT(between(other, habit.predict(kSecond / 10).T_previous_robot).vector().norm(), 1e-9);
}

TEST(Habit, AnUntrustedMotionIsGoneOnWithButDoesNotTellHowGoodItWas) {
  Habit habit;
  const Pose2 step = exp(0.1 * kVelocity), jump{0.5, -0.3, 0.4};
  for (int i = 0; i < 200; ++i) habit.observe(step, kSecond / 10, true);
  const double sure = habit.predict(kSecond / 10).sigma_translation;
  Habit trusting = habit;
  habit.observe(jump, kSecond / 10, false);
  trusting.observe(jump, kSecond / 10, true);
  EXPECT_EQ(habit.predict(kSecond / 10).sigma_translation, sure);
  EXPECT_LT(between(jump, habit.predict(kSecond / 10).T_previous_robot).vector().norm(), 1e-9);
  for (int i = 0; i < 10; ++i) trusting.observe(i % 2 == 0 ? step : jump, kSecond / 10, true);
  EXPECT_GT(trusting.predict(kSecond / 10).sigma_translation, 1.2 * sure);
}

TEST(Habit, AClockThatStandsOrRunsBackIsNotStretchedBy) {
  const Pose2 step = exp(0.1 * kVelocity);
  for (const double time : {0.0, -0.1, 5.0, 1e-6}) {
    Habit habit;
    for (int i = 0; i < 5; ++i) habit.observe(step, kSecond / 10, true);
    const Habit::Prediction p = habit.predict(from_seconds(time));
    EXPECT_LT(between(step, p.T_previous_robot).vector().norm(), 1e-9) << time;
  }
}

}  // namespace
}  // namespace majak::motion
