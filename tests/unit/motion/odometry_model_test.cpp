// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/odometry_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

/// A robot that winds its way, speeds up and slows down, and backs now and then; and what its
/// wheels and its laser say of that.
struct Robot {
  // What is wrong with it.
  double lag = 0;    ///< s, odometry stamped t shows where the robot was at t - lag
  double scale = 1;  ///< true way per way of the odometry
  double turn_scale = 1;
  Pose2 D = {};                       ///< the laser's true place against the nominal one
  bool backs = false;                 ///< drives backwards for a fifth of the time ...
  bool counts_backing_ahead = false;  ///< ... which the odometry takes for ahead
  double laser_noise = 0.002;         ///< m, and half of it in rad: of an observed step
  double wheel_noise = 0;             ///< m per sqrt(s), and twice of it in rad, a random walk
  bool steady = false;                ///< straight ahead, always at the same speed
  std::uint64_t seed = 7;
  // How it logs.
  double odometry_period = 0.05, scan_period = 0.1;  ///< s
  bool stream = true, records = false;
  bool bursts = false;  ///< five scans are stamped together when the last of them arrives

  static constexpr double kFine = 0.005;  // s

  static double speed(double t, bool backs) {
    const double v = 0.5 + 0.3 * std::sin(0.9 * t);
    return backs && std::fmod(t, 10.0) > 8.0 ? -v : v;
  }
  static double turn_rate(double t) {
    return 0.7 * std::sin(0.6 * t) + 0.4 * std::sin(2.3 * t + 1);
  }

  std::vector<Pose2> truth = {}, odometry = {};  // every kFine
  void drive(double seconds) {
    truth.assign(1, {});
    odometry.assign(1, {3, -2, 1});  // an odometry that did not start at zero
    RandomStream noise(seed, 1);
    for (double t = 0; t < seconds + 2; t += kFine) {
      const double v = steady ? 0.5 : speed(t, backs), w = steady ? 0 : turn_rate(t);
      const double slip = wheel_noise / std::sqrt(kFine);  // of a speed held for kFine
      const double seen = counts_backing_ahead ? std::abs(v) : v;
      truth.push_back(truth.back() * exp(kFine * Vec3(v, 0, w)));
      odometry.push_back(odometry.back() *
                         exp(kFine * Vec3(seen / scale + slip * noise.normal(), 0,
                                          w / turn_scale + 2 * slip * noise.normal())));
    }
  }
  static const Pose2& at(const std::vector<Pose2>& path, double t) {
    return path.at(static_cast<std::size_t>(std::lround(std::max(t, 0.0) / kFine)));
  }
  /// Motion of the laser's nominal robot from one scan to the next.
  Pose2 step(std::size_t scan) const {
    const double now = 1 + static_cast<double>(scan) * scan_period;
    return D.inverse() * between(at(truth, now - scan_period), at(truth, now)) * D;
  }
};

struct Outcome {
  OdometryModel model;
  double error = 0;  ///< m + rad, rms of the predictions of the last quarter
  int predicted = 0;
  int steps = 0;
};

/// Feeds a drive as graph SLAM does: events by arrival, every scan observed when its odometry is
/// in.
Outcome run(Robot robot, double seconds = 130, const OdometryModelOptions& options = {}) {
  Outcome out{OdometryModel(options)};
  robot.drive(seconds + 1);
  RandomStream noise(robot.seed);
  const auto scans = static_cast<std::size_t>(seconds / robot.scan_period);
  std::size_t next_odometry = 0, processed = 0;
  for (std::size_t i = 0; i < scans; ++i) {
    const double t = 1 + static_cast<double>(i) * robot.scan_period;
    for (; robot.stream && static_cast<double>(next_odometry) * robot.odometry_period <= t + 0.4;
         ++next_odometry) {
      const double stamp = static_cast<double>(next_odometry) * robot.odometry_period;
      Odometry o;
      o.time = from_seconds(stamp);
      o.T_odom_robot = Robot::at(robot.odometry, stamp - robot.lag);
      o.speed = Robot::speed(std::max(stamp - robot.lag, 0.0), robot.backs);
      out.model.add(o);
    }
    Scan scan;
    scan.time = from_seconds(t);
    if (robot.bursts)
      scan.time = from_seconds(t + static_cast<double>(4 - i % 5) * robot.scan_period) +
                  static_cast<Duration>(i % 5) * kSecond / 1000;
    if (robot.records) scan.T_odom_robot = Robot::at(robot.odometry, t - robot.lag);
    out.model.add(scan);
    for (; processed <= i && out.model.ready(processed); ++processed) {
      const auto predicted = out.model.predict(processed);
      if (processed == 0) continue;
      const Pose2 truly = robot.step(processed);
      if (processed > 3 * scans / 4) {
        ++out.steps;
        if (predicted) {
          const Pose2 off = between(truly, predicted->T_previous_robot);
          out.error += off.vector().squaredNorm();
          ++out.predicted;
        }
      }
      const Pose2 seen =
          truly * Pose2{robot.laser_noise * noise.normal(), robot.laser_noise * noise.normal(),
                        0.5 * robot.laser_noise * noise.normal()};
      out.model.observe(processed, seen, true);
    }
  }
  out.error = std::sqrt(out.error / std::max(out.predicted, 1));
  return out;
}

/// Within what the finding says of itself, and within a bound that says something too.
void expect_learnt(const Learnt& learnt, double truth, double bound) {
  EXPECT_TRUE(learnt.used);
  EXPECT_GT(learnt.sigma, 0);
  EXPECT_LT(std::abs(learnt.value - truth), 3 * learnt.sigma)
      << learnt.value << " +- " << learnt.sigma;
  EXPECT_NEAR(learnt.value, truth, bound);
}

TEST(OdometryModel, RightWheelsAreFoundRight) {
  const Outcome out = run({});
  const OdometryFindings& f = out.model.findings();
  expect_learnt(f.translation_scale, 1, 0.003);
  expect_learnt(f.rotation_scale, 1, 0.003);
  expect_learnt(f.laser_x_m, 0, 0.004);
  expect_learnt(f.laser_y_m, 0, 0.004);
  expect_learnt(f.laser_theta_rad, 0, 0.004);
  expect_learnt(f.lag_s, 0, 0.002);
  EXPECT_EQ(f.reversed_records, 0);
  EXPECT_EQ(out.predicted, out.steps);
  EXPECT_LT(out.error, 0.002);
}

TEST(OdometryModel, FindsALagOnEitherSide) {
  for (const double lag : {0.1, -0.1, 0.24}) {
    const Outcome out = run({.lag = lag});
    expect_learnt(out.model.findings().lag_s, lag, 0.003);
    EXPECT_LT(out.error, 0.003) << lag;  // before it is learnt: 0.03
  }
}

TEST(OdometryModel, FindsTheScale) {
  for (const double scale : {1.03, 0.95}) {
    const Outcome out = run({.scale = scale});
    expect_learnt(out.model.findings().translation_scale, scale, 0.003);
    EXPECT_LT(out.error, 0.002);
  }
}

TEST(OdometryModel, FindsTheScaleOfTurns) {
  const Outcome out = run({.turn_scale = 1.05});
  expect_learnt(out.model.findings().rotation_scale, 1.05, 0.003);
  EXPECT_LT(out.error, 0.002);
}

TEST(OdometryModel, FindsWhereTheLaserSits) {
  for (const Pose2& D : {Pose2{0.1, 0, 0}, Pose2{0, -0.1, 0}, Pose2{0, 0, radians(3)},
                         Pose2{0.3, 0.05, radians(-2)}}) {
    const Outcome out = run({.D = D});
    const OdometryFindings& f = out.model.findings();
    expect_learnt(f.laser_x_m, D.x, 0.005);
    expect_learnt(f.laser_y_m, D.y, 0.005);
    expect_learnt(f.laser_theta_rad, D.theta, 0.004);
    EXPECT_LT(out.error, 0.002);
  }
}

TEST(OdometryModel, FindsAWrongDirectionOfTravel) {
  const Outcome wrong = run({.backs = true, .counts_backing_ahead = true});
  EXPECT_GT(wrong.model.findings().reversed_records, 100);
  EXPECT_LT(wrong.error, 0.01);  // not mended: 0.05
  // Backing that is logged as backing is left alone.
  const Outcome right = run({.backs = true});
  EXPECT_EQ(right.model.findings().reversed_records, 0);
  EXPECT_LT(right.error, 0.002);
}

TEST(OdometryModel, FindsSeveralFaultsAtOnce) {
  const Outcome out = run({.lag = 0.1, .scale = 1.03, .turn_scale = 0.98, .D = {0.1, 0, 0}});
  const OdometryFindings& f = out.model.findings();
  expect_learnt(f.lag_s, 0.1, 0.01);
  EXPECT_NEAR(f.translation_scale.value, 1.03, 0.01);
  EXPECT_NEAR(f.rotation_scale.value, 0.98, 0.01);
  EXPECT_NEAR(f.laser_x_m.value, 0.1, 0.01);
  EXPECT_LT(out.error, 0.004);
}

/// Root mean square of the errors of drives with several seeds, in sigmas.
struct Honesty {
  double sum = 0;
  int n = 0;
  void add(const Learnt& learnt, double truth) {
    EXPECT_TRUE(learnt.used);
    const double z = (learnt.value - truth) / learnt.sigma;
    EXPECT_LT(std::abs(z), 3.5) << learnt.value << " +- " << learnt.sigma;
    sum += z * z, ++n;
  }
  double rms() const { return std::sqrt(sum / n); }
};

TEST(OdometryModel, SigmasAreTrueOverSeeds) {
  Honesty lag, scale, turn_scale, x, y, theta;
  double worst_lag = 0, worst_scale = 0, worst_turn_scale = 0;
  for (const double truth : {-0.15, 0.0, 0.03, 0.1}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const bool records = seed % 2 == 0;
      const Outcome out = run({.lag = truth,
                               .scale = 1.02,
                               .turn_scale = 0.97,
                               .D = {0.1, 0.03, 0.02},
                               .laser_noise = 0.004,
                               .wheel_noise = 0.01,
                               .seed = seed,
                               .odometry_period = 0.1,
                               .stream = !records,
                               .records = records},
                              65);
      const OdometryFindings& f = out.model.findings();
      lag.add(f.lag_s, truth), scale.add(f.translation_scale, 1.02),
          turn_scale.add(f.rotation_scale, 0.97);
      x.add(f.laser_x_m, 0.1), y.add(f.laser_y_m, 0.03), theta.add(f.laser_theta_rad, 0.02);
      worst_lag = std::max(worst_lag, f.lag_s.sigma);
      worst_scale = std::max(worst_scale, f.translation_scale.sigma);
      worst_turn_scale = std::max(worst_turn_scale, f.rotation_scale.sigma);
    }
  }
  for (const Honesty* h : {&lag, &scale, &turn_scale, &x, &y, &theta}) EXPECT_LT(h->rms(), 1.4);
  EXPECT_GT(x.rms(), 0.4);  // nor does it hide behind sigmas that are too large
  EXPECT_GT(theta.rms(), 0.4);
  EXPECT_LT(worst_lag, 0.02);
  EXPECT_LT(worst_scale, 0.012);
  EXPECT_LT(worst_turn_scale, 0.02);
}

TEST(OdometryModel, NoisyWheelsDoNotShortenTheTurns) {
  // Plain least squares of the laser's turns on such wheels' finds 0.9.
  Honesty turn_scale;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Outcome out = run({.laser_noise = 0.002, .wheel_noise = 0.03, .seed = seed});
    const Learnt& found = out.model.findings().rotation_scale;
    turn_scale.add(found, 1);
    EXPECT_NEAR(found.value, 1, 0.05);
  }
  EXPECT_LT(turn_scale.rms(), 1.5);
}

TEST(OdometryModel, SteadyStraightDrivesTellOnlyTheScale) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const double lag : {0.0, 0.1}) {
      const Outcome out =
          run({.lag = lag, .scale = 1.03, .wheel_noise = 0.003, .steady = true, .seed = seed});
      const OdometryFindings& f = out.model.findings();
      EXPECT_FALSE(f.lag_s.used) << f.lag_s.value << " +- " << f.lag_s.sigma;
      EXPECT_FALSE(f.rotation_scale.used)
          << f.rotation_scale.value << " +- " << f.rotation_scale.sigma;
      EXPECT_FALSE(f.laser_x_m.used);
      EXPECT_FALSE(f.laser_y_m.used);
      EXPECT_TRUE(f.translation_scale.used);
      EXPECT_LT(std::abs(f.translation_scale.value - 1.03), 3 * f.translation_scale.sigma);
      EXPECT_LT(out.error, 0.01);
    }
  }
}

TEST(OdometryModel, AStandingRobotTellsNothing) {
  OdometryModel model;
  RandomStream noise(3);
  for (std::size_t i = 0; i < 700; ++i) {
    Scan scan;
    scan.time = from_seconds(0.1 * static_cast<double>(i));
    scan.T_odom_robot = Pose2{1, 2, 3};
    model.add(scan);
    model.observe(i, {0.002 * noise.normal(), 0.002 * noise.normal(), 0.001 * noise.normal()},
                  true);
  }
  const OdometryFindings& f = model.findings();
  for (const Learnt& l : {f.lag_s, f.translation_scale, f.rotation_scale, f.laser_x_m, f.laser_y_m,
                          f.laser_theta_rad})
    EXPECT_FALSE(l.used) << l.value << " +- " << l.sigma;
  EXPECT_GT(f.translation_scale.sigma, 0.05);  // it says that it looked and found nothing
  EXPECT_NEAR(model.predict(699)->T_previous_robot.x, 0, 1e-9);
}

TEST(OdometryModel, StampsInBurstsTellNoLag) {
  for (const double lag : {0.0, 0.1}) {
    const Outcome out =
        run({.lag = lag, .scale = 1.03, .stream = false, .records = true, .bursts = true});
    const OdometryFindings& f = out.model.findings();
    EXPECT_FALSE(f.lag_s.used) << f.lag_s.value << " +- " << f.lag_s.sigma;
    EXPECT_TRUE(f.translation_scale.used);
    EXPECT_NEAR(f.translation_scale.value, 1.03, lag == 0 ? 0.005 : 0.03);
  }
}

TEST(OdometryModel, RecordsOfTheScansAreTurnedRoundToo) {
  const Outcome out =
      run({.backs = true, .counts_backing_ahead = true, .wheel_noise = 0.002, .records = true});
  EXPECT_GT(out.model.findings().reversed_records, 100);
  expect_learnt(out.model.findings().translation_scale, 1, 0.01);
  EXPECT_LT(out.error, 0.02);
}

TEST(OdometryModel, WithoutOdometryThereIsNothing) {
  const Outcome out = run({.stream = false, .records = false});
  EXPECT_EQ(out.predicted, 0);
  EXPECT_GT(out.steps, 0);  // and nobody waited for it
  EXPECT_FALSE(out.model.pose(0).has_value());
  const OdometryFindings& f = out.model.findings();
  for (const Learnt& l : {f.lag_s, f.translation_scale, f.rotation_scale, f.laser_x_m, f.laser_y_m,
                          f.laser_theta_rad})
    EXPECT_FALSE(l.used);
  EXPECT_EQ(f.translation_noise, 0);
}

TEST(OdometryModel, RecordsOfTheScansAreEnough) {
  const Outcome out = run({.scale = 1.03, .stream = false, .records = true});
  EXPECT_EQ(out.predicted, out.steps);
  expect_learnt(out.model.findings().translation_scale, 1.03, 0.003);
  EXPECT_LT(out.error, 0.002);
}

TEST(OdometryModel, RecordsOfTheScansMayLagToo) {
  const Outcome out = run({.lag = 0.1, .stream = false, .records = true});
  expect_learnt(out.model.findings().lag_s, 0.1, 0.01);
}

TEST(OdometryModel, ShortLogsKeepTheNominalValues) {
  const Outcome out = run({.scale = 1.03}, 20);  // 200 scans
  EXPECT_FALSE(out.model.findings().translation_scale.used);
  EXPECT_EQ(out.predicted, out.steps);
  EXPECT_GT(out.error, 0);
}

TEST(OdometryModel, UntrustedStepsTeachNothing) {
  OdometryModel model;
  for (std::size_t i = 0; i < 700; ++i) {
    Scan scan;
    scan.time = from_seconds(0.1 * static_cast<double>(i));
    scan.T_odom_robot = Pose2{0.05 * static_cast<double>(i), 0, 0};
    model.add(scan);
    model.observe(i, {0.06, 0, 0}, false);
  }
  EXPECT_FALSE(model.findings().translation_scale.used);
  EXPECT_NEAR(model.predict(699)->T_previous_robot.x, 0.05, 1e-12);
}

TEST(OdometryModel, PathIsTheOdometrysOwn) {
  OdometryModel model;
  for (int i = 0; i <= 4; ++i) model.add(Odometry{i * kSecond, {1.0 * i, 0, 0}, {}, {}});
  for (const double t : {0.0, 1.25, 4.0, 4.5, -1.0}) {
    Scan scan;
    scan.time = from_seconds(t);
    model.add(scan);
  }
  EXPECT_NEAR(model.pose(0)->x, 0, 1e-12);
  EXPECT_NEAR(model.pose(1)->x, 1.25, 1e-12);
  EXPECT_NEAR(model.pose(2)->x, 4, 1e-12);
  EXPECT_FALSE(model.pose(3).has_value());  // after the last record: not yet known
  EXPECT_FALSE(model.ready(3));
  EXPECT_TRUE(model.ready(2));
  EXPECT_FALSE(model.pose(4).has_value());  // before the first
  EXPECT_FALSE(model.predict(0).has_value());
  EXPECT_NEAR(model.predict(2)->T_previous_robot.x, 2.75, 1e-12);
  EXPECT_FALSE(model.predict(3).has_value());
}

TEST(OdometryModel, SpeedAndSteeringAddUpToArcs) {
  OdometryModel model({.wheelbase = 2});
  const double turn_rate = 1.5 * std::tan(0.3) / 2;
  for (int i = 0; i <= 40; ++i) {
    model.add(WheelMotion{i * kSecond / 20, 1.5, 0.3});
    model.add(Odometry{i * kSecond / 20, {1e3, 0, 1}, {}, {}});  // of another kind: not used
    Scan scan;
    scan.time = i * kSecond / 20;
    model.add(scan);
  }
  for (std::size_t i = 1; i <= 40; ++i) {
    const Pose2 expected = exp({1.5 / 20, 0, turn_rate / 20});
    EXPECT_LT(log(between(expected, model.predict(i)->T_previous_robot)).norm(), 1e-12);
  }
  EXPECT_LT(log(between(exp({3, 0, 2 * turn_rate}), *model.pose(40))).norm(), 1e-12);
}

TEST(OdometryModel, NobodyKnowsWhatTheWheelsDidInAGap) {
  OdometryModel model;
  for (const double t : {0.0, 0.5, 1.0, 9.0, 9.5}) {
    model.add(WheelMotion{from_seconds(t), 1, 0});
    Scan scan;
    scan.time = from_seconds(t);
    model.add(scan);
  }
  EXPECT_TRUE(model.predict(2).has_value());
  EXPECT_FALSE(model.predict(3).has_value());
  EXPECT_NEAR(model.predict(4)->T_previous_robot.x, 0.5, 1e-12);
  EXPECT_EQ(model.findings().jumps, 1);
}

TEST(OdometryModel, CountersThatBeginAnewMoveNobody) {
  // Straight ahead; then the counters are at zero again, or kilometres off, or turned round.
  for (const bool records : {true, false}) {
    for (const Pose2& offset : {Pose2{-37, 4, 0.3}, Pose2{1e4, 0, 0}, Pose2{0, 0, 3}}) {
      OdometryModel model;
      for (int i = 0; i < 40; ++i) {
        const Pose2 wheels = (i < 20 ? Pose2{} : offset) * Pose2{0.1 * i, 0, 0};
        Scan scan;
        scan.time = from_seconds(0.1 * i);
        if (records) scan.T_odom_robot = wheels;
        if (!records) model.add(Odometry{scan.time, wheels, {}, {}});
        model.add(scan);
      }
      for (std::size_t i = 1; i < 40; ++i) {
        const auto motion = model.predict(i);
        ASSERT_EQ(motion.has_value(), i != 20) << i;
        if (motion) {
          EXPECT_NEAR(motion->T_previous_robot.x, 0.1, 1e-9);
        }
      }
      EXPECT_NEAR(model.pose(39)->x, 3.8, 1e-9);  // the path goes on from where it was
      EXPECT_NEAR(model.pose(39)->y, 0, 1e-9);
      EXPECT_EQ(model.findings().jumps, 1);
    }
  }
}

TEST(OdometryModel, AFastCarAndALongPauseAreNoJumps) {
  OdometryModel model;
  double x = 0;
  for (int i = 0; i < 40; ++i) {
    x += i == 20 ? 150 : 3.5;  // 35 m/s; and ten seconds without a record
    model.add(Odometry{from_seconds(0.1 * i + (i >= 20 ? 10 : 0)), {x, 0, 0}, {}, {}});
  }
  EXPECT_EQ(model.findings().jumps, 0);
}

TEST(OdometryModel, StampsInBurstsAndBackwards) {
  // Records of the scans that come in bursts of equal stamps, one of them an hour back: the
  // records belong to their scans, whatever the stamps say.
  OdometryModel model;
  for (std::size_t i = 0; i < 40; ++i) {
    Scan scan;
    scan.time = from_seconds(i == 17 ? -3600.0 : 0.5 * std::floor(static_cast<double>(i) / 5));
    scan.T_odom_robot = Pose2{0.1 * static_cast<double>(i), 0, 0};
    model.add(scan);
  }
  for (std::size_t i = 1; i < 40; ++i) {
    ASSERT_TRUE(model.ready(i));
    ASSERT_TRUE(model.predict(i).has_value());
    EXPECT_NEAR(model.predict(i)->T_previous_robot.x, 0.1, 1e-12);
  }
  // A stream of such stamps: no prediction jumps farther than the burst is long.
  OdometryModel stream;
  for (std::size_t i = 0; i < 40; ++i) {
    const Time time =
        from_seconds(i % 7 == 5 ? -3600.0 : 0.5 * std::floor(static_cast<double>(i) / 5));
    stream.add(Odometry{time, {0.1 * static_cast<double>(i), 0, 0}, {}, {}});
  }
  for (std::size_t i = 0; i < 30; ++i) {
    Scan scan;
    scan.time = from_seconds(0.1 * static_cast<double>(i));
    stream.add(scan);
  }
  for (std::size_t i = 1; i < 30; ++i) {
    const auto predicted = stream.predict(i);
    ASSERT_TRUE(predicted.has_value());
    EXPECT_GT(predicted->T_previous_robot.x, -1e-9);
    // Never earlier than its own burst, nor later than the next one.
    EXPECT_NEAR(stream.pose(i)->x, 0.1 * static_cast<double>(i), 0.5 + 1e-9);
    EXPECT_LT(predicted->T_previous_robot.x, 0.6 + 1e-9);
  }
}

TEST(OdometryModel, AClockThatWasSetBackSpoilsNothingBefore) {
  OdometryModel model;
  const auto stamp = [](int i) { return from_seconds(0.1 * (i <= 20 ? i : i - 21)); };
  for (int i = 0; i <= 60; ++i) model.add(Odometry{stamp(i), {0.1 * i, 0, 0}, {}, {}});
  for (int i = 0; i < 20; ++i) {
    Scan scan;
    scan.time = from_seconds(0.1 * i + 0.05);
    model.add(scan);
  }
  for (int i = 0; i < 20; ++i)
    EXPECT_NEAR(model.pose(static_cast<std::size_t>(i))->x, 0.1 * i + 0.05, 1e-9);
}

TEST(OdometryModel, AScanWithoutARecordDoesNotShiftTheOthers) {
  OdometryModel model;
  for (std::size_t i = 0; i < 20; ++i) {
    Scan scan;
    scan.time = from_seconds(0.1 * static_cast<double>(i));
    if (i != 7) scan.T_odom_robot = Pose2{0.01 * static_cast<double>(i * i), 0, 0};
    model.add(scan);
  }
  EXPECT_FALSE(model.pose(7).has_value());
  EXPECT_FALSE(model.predict(7).has_value());
  EXPECT_FALSE(model.predict(8).has_value());
  for (std::size_t i = 0; i < 20; ++i) {
    if (i != 7) {
      ASSERT_TRUE(model.pose(i).has_value());
      EXPECT_NEAR(model.pose(i)->x, 0.01 * static_cast<double>(i * i), 1e-12);
    }
  }
}

TEST(OdometryModel, SigmaGrowsWithTheWay) {
  OdometryModel model;
  double x = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    Scan scan;
    scan.time = static_cast<Time>(i) * kSecond;
    scan.T_odom_robot = Pose2{x, 0, 0};
    x += static_cast<double>(i);
    model.add(scan);
  }
  const auto standing = model.predict(1), slow = model.predict(2), fast = model.predict(3);
  EXPECT_GT(standing->sigma_translation, 0);
  EXPECT_GT(standing->sigma_rotation, 0);
  EXPECT_GT(slow->sigma_translation, standing->sigma_translation);
  EXPECT_GT(fast->sigma_translation, slow->sigma_translation);
}

}  // namespace
}  // namespace majak::motion
