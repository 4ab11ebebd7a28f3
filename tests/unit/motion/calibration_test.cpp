// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/calibration.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "majak/core/chi_square.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

struct Faults {
  double scale = 1, turn_scale = 1, uneven = 0, lag = 0;
  Pose2 T_robot_laser{0.13, -0.02, 0.02};
};

struct Log {
  std::vector<LaserPose> laser;
  std::vector<WheelSample> wheels;
};

enum class Way { bends, straight, constant_bend };

// What the robot does at a time: m/s and rad/s.
Vec3 velocity(Way way, double t) {
  if (way == Way::straight) return {0.4 + 0.2 * std::sin(0.9 * t), 0, 0};
  if (way == Way::constant_bend) return {0.5, 0, 0.3};
  return {0.4 + 0.25 * std::sin(0.7 * t), 0, 0.5 * std::sin(0.31 * t) + 0.4 * std::sin(1.3 * t)};
}

// Wheels at 20 Hz and a laser at 5 Hz with the usual noise; nominally the laser is at (0.1, 0, 0).
const Pose2 kNominal{0.1, 0, 0};
Log drive(Way way, const Faults& faults, std::uint64_t seed, double seconds = 200) {
  const StepNoise usual;
  RandomStream random(seed);
  Log log;
  Pose2 truth;
  const double dt = 0.05;
  for (int i = 0; i * dt < seconds; ++i) {
    const double t = i * dt;
    if (i % 4 == 0) {
      const Vec3 noise(usual.laser_translation * random.normal(),
                       usual.laser_translation * random.normal(),
                       usual.laser_rotation * random.normal());
      // A robot that carries the laser where it is said to be.
      const Pose2 seen = truth * faults.T_robot_laser * kNominal.inverse() * exp(noise);
      log.laser.push_back({from_seconds(t), seen});
    }
    const Vec3 u = dt * velocity(way, t);
    truth = truth * exp(u);
    const double d = std::abs(u.x()), turn = std::abs(u.z());
    Vec3 counted;
    counted.x() = u.x() / faults.scale;
    counted.y() = 0;
    counted.z() = (u.z() - faults.uneven * counted.x()) / faults.turn_scale;
    counted += Vec3(usual.ahead * std::sqrt(d) * random.normal(), 0,
                    std::sqrt(usual.turn_of_way * usual.turn_of_way * d +
                              usual.turn_of_turn * usual.turn_of_turn * turn) *
                        random.normal());
    log.wheels.push_back({from_seconds(t + dt + faults.lag), counted, 0, false});
  }
  return log;
}

Calibration calibrated(const Log& log, double track = 0) {
  return calibrate(log.laser, log.wheels, {.track = track, .T_robot_laser = kNominal});
}

Vec7 truth_of(const Faults& f) {
  Vec7 v;
  v << f.scale, f.turn_scale, f.uneven, f.T_robot_laser.x, f.T_robot_laser.y, f.T_robot_laser.theta,
      f.lag;
  return v;
}

Vec7 values_of(const Calibration& c) {
  Vec7 v;
  for (std::size_t i = 0; i < kUnknowns; ++i) v(static_cast<int>(i)) = c.values[i].value;
  return v;
}

const Faults kFaults{1.01, 0.98, 0.02, 0.05, {0.13, -0.02, 0.0175}};

TEST(Calibration, FaultsAreFoundWithinTheirSigmas) {
  double nees = 0;
  constexpr int kRuns = 40;
  Vec7 worst = Vec7::Zero();
  for (int seed = 0; seed < kRuns; ++seed) {
    const Calibration c =
        calibrated(drive(Way::bends, kFaults, 100 + static_cast<std::uint64_t>(seed)));
    for (const Learnt& v : c.values) EXPECT_TRUE(v.used);
    const Vec7 error = values_of(c) - truth_of(kFaults);
    nees += error.dot(c.covariance.inverse() * error);
    worst = worst.cwiseMax(error.cwiseAbs().cwiseQuotient(c.covariance.diagonal().cwiseSqrt()));
  }
  // Cautious rather than too sure: floors and scatter widen the covariance.
  EXPECT_LT(nees, chi_square_quantile(0.999, 7 * kRuns));
  EXPECT_GT(nees, 0.4 * 7 * kRuns);
  for (int i = 0; i < 7; ++i) EXPECT_LT(worst(i), 3.5) << i;
}

TEST(Calibration, RightWheelsStayRight) {
  const Faults none{1, 1, 0, 0, kNominal};
  const Calibration c = calibrated(drive(Way::bends, none, 1));
  const Vec7 off = values_of(c) - truth_of(none);
  for (int i = 0; i < 7; ++i) EXPECT_LT(std::abs(off(i)), 3 * std::sqrt(c.covariance(i, i))) << i;
  EXPECT_NEAR(c.mean_nis, 3, 0.3);
}

TEST(Calibration, TheTrackMakesWheelsOfTheBend) {
  const double track = 0.4;
  const Calibration c = calibrated(drive(Way::bends, kFaults, 3), track);
  ASSERT_TRUE(c.wheel_difference.used && c.length.used);
  // A bend of 0.02 rad/m over 0.4 m of track is 0.8 % of radius; 2 % too many turns, a wider track.
  EXPECT_NEAR(c.wheel_difference.value, 0.008, 3 * c.wheel_difference.sigma + 4e-4);
  EXPECT_GT(c.length.value, track);
  EXPECT_LT(c.wheel_difference.sigma, 0.002);
}

TEST(Calibration, AStraightWayTellsNoTurns) {
  const Calibration c = calibrated(drive(Way::straight, {}, 4));
  EXPECT_TRUE(c[Unknown::scale].used);
  EXPECT_FALSE(c[Unknown::turn_scale].used);
  EXPECT_FALSE(c[Unknown::laser_x].used);
  EXPECT_FALSE(c[Unknown::laser_y].used);
  EXPECT_EQ(c.correction.turn_scale, 1);  // the nominal value
  EXPECT_FALSE(c.not_told.empty());
}

TEST(Calibration, AConstantBendTellsNoLag) {
  const Calibration c = calibrated(drive(Way::constant_bend, {}, 5));
  EXPECT_FALSE(c[Unknown::lag].used);
  EXPECT_GT(c[Unknown::lag].sigma, 0.03);
}

TEST(Calibration, StampsThatTellOnlyTheOrderTellNoLag) {
  const Log log = drive(Way::bends, {}, 6);
  const Calibration c =
      calibrate(log.laser, log.wheels, {.timed = false, .T_robot_laser = kNominal});
  EXPECT_FALSE(c[Unknown::lag].used);
  EXPECT_EQ(c.correction.lag, 0);
  EXPECT_TRUE(c[Unknown::scale].used);
}

// A push of the robot every 20 s.
TEST(Calibration, PushesAreLeftOut) {
  Log log = drive(Way::bends, kFaults, 7);
  Pose2 pushed;
  for (std::size_t i = 0; i < log.laser.size(); ++i) {
    if (i % 100 == 50) pushed = pushed * Pose2{0.2, 0.1, 0.1};
    log.laser[i].T_map_robot = pushed * log.laser[i].T_map_robot;
  }
  const Calibration c = calibrated(log);
  EXPECT_GE(c.left_out, 8U);
  const Vec7 off = values_of(c) - truth_of(kFaults);
  for (int i = 0; i < 7; ++i) EXPECT_LT(std::abs(off(i)), 3.5 * std::sqrt(c.covariance(i, i))) << i;
}

// A laser that jumps about: nothing is taken from it.
TEST(Calibration, PosesThatContradictTheWheelsTellNothing) {
  Log log = drive(Way::bends, kFaults, 7, 800);
  Pose2 lost;
  for (std::size_t i = 0; i < log.laser.size(); ++i) {
    if (i % 8 == 0) lost = lost * Pose2{0.5, 0.3, 0.4};
    log.laser[i].T_map_robot = lost * log.laser[i].T_map_robot;
  }
  const Calibration c = calibrated(log);
  for (const Learnt& v : c.values) EXPECT_FALSE(v.used);
  EXPECT_FALSE(c.correction.mounting);  // its place stays that of the log
  EXPECT_EQ(corrected(c.correction, Vec3(1, 2, 3)), Vec3(1, 2, 3));
  EXPECT_EQ(c.correction.lag, 0);
  ASSERT_EQ(c.not_told.size(), 1U);
  EXPECT_EQ(c.not_told.front().rfind("anything", 0), 0U);
}

TEST(Calibration, TooLittleIsAnError) {
  const Log log = drive(Way::bends, {}, 8, 5);
  EXPECT_THROW(calibrated(log), Error);
  EXPECT_THROW(calibrate({}, {}, {}), Error);
}

TEST(Calibration, SameLogSameNumbers) {
  const Log log = drive(Way::bends, kFaults, 9);
  const Calibration a = calibrated(log), b = calibrated(log);
  EXPECT_EQ(values_of(a), values_of(b));
  EXPECT_EQ(a.covariance, b.covariance);
}

}  // namespace
}  // namespace majak::motion
