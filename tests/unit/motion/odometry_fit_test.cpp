// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/odometry_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

struct Drive {
  double turning = 0.1;  ///< rad a step, at most
  double changing = 1;   ///< share of its velocity that changes
  double noise = 0;      ///< m, and rad, of a step of the laser
  std::size_t steps = 400;
};

Vec3 velocity(double t, const Drive& d) {
  return {0.08 + 0.04 * d.changing * std::sin(t), 0, d.turning * std::sin(0.7 * t)};
}

/// Steps 0.3 apart in time of a robot with these faults; wheels at `supposed`.
std::vector<ComparedStep> steps_of(const OdometryFaults& truth, const Drive& drive,
                                   std::uint64_t seed = 1) {
  RandomStream random(seed);
  const auto wheels_at = [&](double t, double lag) {
    return exp(velocity(t - truth.lag + lag, drive));
  };
  const auto laser_at = [&](double t) {
    const Pose2 w = wheels_at(t, truth.lag);
    const Pose2 mended{truth.scale * w.x, truth.scale * w.y, truth.turn_scale * w.theta};
    return truth.D.inverse() * mended * truth.D;
  };
  std::vector<ComparedStep> out;
  for (std::size_t i = 0; i < drive.steps; ++i) {
    const double t = 0.3 * static_cast<double>(i), h = 0.01;
    ComparedStep s;
    s.laser = laser_at(t) *
              from_vector(drive.noise * Vec3(random.normal(), random.normal(), random.normal()));
    s.wheels = wheels_at(t, 0);
    s.wheels_per_lag = (wheels_at(t, h).vector() - wheels_at(t, -h).vector()) / (2 * h);
    const Vec3 before = laser_at(t - 0.3).vector(), after = laser_at(t + 0.3).vector();
    s.neighbours = 0.5 * (before + after);
    s.change = 0.5 * (after - before) / 0.3;
    out.push_back(s);
  }
  return out;
}

TEST(OdometryFit, FindsFaultsExactlyWithoutNoise) {
  const OdometryFaults truth{0.05, 1.04, 0.95, {0.2, -0.1, 0.03}};
  OdometryFit fit;
  // Newton steps: those of the lag are made by whoever makes the steps.
  OdometryFaults wanted = truth;
  for (int i = 0; i < 6; ++i) {
    fit = fit_odometry(steps_of(wanted, {}), fit.faults, true);
    wanted.lag -= fit.faults.lag;
  }
  EXPECT_NEAR(wanted.lag, 0, 1e-5);
  EXPECT_NEAR(fit.faults.scale, truth.scale, 1e-4);
  EXPECT_NEAR(fit.faults.turn_scale, truth.turn_scale, 1e-4);
  EXPECT_NEAR(fit.faults.D.x, truth.D.x, 1e-3);
  EXPECT_NEAR(fit.faults.D.y, truth.D.y, 1e-3);
  EXPECT_NEAR(fit.faults.D.theta, truth.D.theta, 1e-3);
}

TEST(OdometryFit, WhatIsNotDeterminedStaysNominalAndSaysSo) {
  // Straight ahead at one speed: no lag, no scale of turns, no place.
  const auto fit = fit_odometry(steps_of({0.1, 1.05, 0.9, {0.2, 0.1, 0}}, {0, 0, 0.001}), {}, true);
  EXPECT_NEAR(fit.faults.scale, 1.05, 0.005);
  EXPECT_NEAR(fit.faults.lag, 0, 1e-6);
  EXPECT_NEAR(fit.lag, 0.3, 1e-3);
  EXPECT_NEAR(fit.faults.turn_scale, 1, 1e-6);
  EXPECT_NEAR(fit.turn_scale, 0.1, 1e-3);
  EXPECT_NEAR(fit.D.x(), 0.1, 1e-3);
  EXPECT_NEAR(fit.D.y(), 0.1, 1e-3);
}

TEST(OdometryFit, SigmaIsTheScatterOverSeeds) {
  constexpr int kSeeds = 60;
  double sum = 0, squares = 0, sigma = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto fit = fit_odometry(steps_of({}, {.noise = 0.005}, seed), {}, true);
    sum += fit.faults.lag, squares += fit.faults.lag * fit.faults.lag, sigma += fit.lag / kSeeds;
  }
  const double scatter = std::sqrt(squares / kSeeds - sum * sum / kSeeds / kSeeds);
  EXPECT_GT(sigma, 0.8 * scatter);
  EXPECT_LT(sigma, 2 * scatter);
}

TEST(OdometryFit, SigmaKnowsCorrelatedNoise) {
  // The same noise ten steps long: a tenth of the information, three times the sigma.
  auto steps = steps_of({}, {.changing = 0, .steps = 1000});
  RandomStream random(5);
  auto alone = steps, together = steps;
  double held = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double e = 0.005 * random.normal();
    if (i % 10 == 0) held = e;
    alone[i].laser.x += e;
    together[i].laser.x += held;
  }
  const double a = fit_odometry(alone, {}, true).scale, b = fit_odometry(together, {}, true).scale;
  EXPECT_GT(b / a, 2);
  EXPECT_LT(b / a, 5);
}

TEST(OdometryFit, GrossErrorsDoNotCount) {
  auto steps = steps_of({0, 1.03, 1, {}}, {.noise = 0.001});
  const double before = fit_odometry(steps, {}, true).faults.scale;
  for (std::size_t i = 0; i < steps.size(); i += 10) steps[i].laser = Pose2{2, 1, 1};
  EXPECT_NEAR(fit_odometry(steps, {}, true).faults.scale, before, 0.002);
}

TEST(OdometryFit, NoStepsSayNothing) {
  const auto fit = fit_odometry({}, {0, 1, 1, {}}, true);
  EXPECT_NEAR(fit.faults.scale, 1, 1e-12);
  EXPECT_NEAR(fit.scale, 0.1, 1e-9);
  EXPECT_NEAR(fit.lag, 0.3, 1e-9);
}

}  // namespace
}  // namespace majak::motion
