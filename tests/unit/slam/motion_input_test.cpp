// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/motion_input.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include <algorithm>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::slam {
namespace {

using Motion = MotionInput::Motion;
using motion::WheelStep;
const motion::WheelRandom kRandom{0.02, 0.01, 0.005, 0.03};

Time at(double seconds) { return from_seconds(1000 + seconds); }
double apart(const Pose2& a, const Pose2& b) { return log(between(a, b)).norm(); }

/// Odometry that wanders, ten times a second.
std::vector<Odometry> wander(std::uint64_t seed, int records = 60) {
  RandomStream random(seed);
  std::vector<Odometry> all;
  Pose2 now{3, -2, 1};
  for (int i = 0; i < records; ++i) {
    all.push_back({at(0.1 * i), now, {}, {}});
    now = now * exp({random.uniform(0, 0.3), 0.02 * random.normal(), 0.1 * random.normal()});
  }
  return all;
}

MotionInput fresh() { return {kRandom, 2.7, 0.5}; }

/// The takes at these times among the records, put together.
template <class Record>
Motion driven(const std::vector<Record>& records, std::vector<double> times) {
  std::sort(times.begin(), times.end());
  MotionInput input = fresh();
  Motion all;
  all.at(WheelStep::kScale) = all.at(WheelStep::kTurnScale) = 1;
  auto next = times.begin();
  for (const Record& record : records) {
    for (; next != times.end() && at(*next) < record.time; ++next) all.then(input.take(at(*next)));
    input.add(record);
  }
  for (; next != times.end(); ++next) all.then(input.take(at(*next)));
  return all;
}

// ---- Odometry ---------------------------------------------------------------------------------

// However often it is asked, and in between guesses how it goes on.
TEST(MotionInput, TakesAddUpToTheOdometrysOwnDifference) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto records = wander(seed);
    const Pose2 whole = between(records.front().T_odom_robot, records.back().T_odom_robot);
    RandomStream random(seed, 1);
    const double last = to_seconds(records.back().time - at(0));
    std::vector<double> times{last};
    for (int i = 0; i < 40; ++i) times.push_back(random.uniform(0, last));
    EXPECT_LT(apart(driven(records, times).T_from_to, whole), 1e-12);
    EXPECT_LT(apart(driven(records, {last}).T_from_to, whole), 1e-12);
  }
}

TEST(MotionInput, BetweenRecordsTheLastStepGoesOnForHalfASecond) {
  MotionInput input = fresh();
  input.add(Odometry{at(0), {}, {}, {}});
  input.add(Odometry{at(0.1), exp({0.1, 0, 0.02}), {}, {}});
  EXPECT_LT((input.twist() - Vec3(1, 0, 0.2)).norm(), 1e-12);
  const Pose2 first = input.take(at(0.3)).T_from_to;
  EXPECT_LT(apart(first, exp(Vec3(0.3, 0, 0.06))), 1e-12);
  const Pose2 second = input.take(at(0.5)).T_from_to * input.take(at(9)).T_from_to;
  EXPECT_LT(apart(first * second, exp(Vec3(0.6, 0, 0.12))), 1e-12);  // 0.1 s and 0.5 s more
  EXPECT_EQ(input.take(at(10)).T_from_to, Pose2{});
  // The next record sets right what was guessed.
  input.add(Odometry{at(10.1), {2, 1, 0}, {}, {}});
  EXPECT_LT(apart(exp(Vec3(0.6, 0, 0.12)) * input.take(at(10.1)).T_from_to, {2, 1, 0}), 1e-12);
}

TEST(MotionInput, AStaleRecordIsDropped) {
  const auto records = wander(3, 10);
  MotionInput with = fresh(), without = fresh();
  for (const Odometry& o : records) {
    with.add(o), without.add(o);
    with.add(o);                                               // twice
    with.add(Odometry{o.time - 1000, {100, 100, 1}, {}, {}});  // late
  }
  const Motion a = with.take(at(2)), b = without.take(at(2));
  EXPECT_EQ(a.T_from_to, b.T_from_to);
  EXPECT_EQ(a.noise, b.noise);
  EXPECT_EQ(with.way(), without.way());
}

// A scan at 1.0 asks, and then a record of 0.95 arrives: no part of the way is lost.
TEST(MotionInput, ARecordThatArrivesAfterItWasAskedFor) {
  MotionInput input = fresh();
  const auto pose = [](double t) { return exp(t * Vec3(2, 0, 0.3)); };
  for (const double t : {0.75, 0.85}) input.add(Odometry{at(t), pose(t), {}, {}});
  Pose2 all = input.take(at(1)).T_from_to;
  input.add(Odometry{at(0.95), pose(0.95), {}, {}});
  all = all * input.take(at(1.1)).T_from_to;
  EXPECT_LT(apart(all, between(pose(0.75), pose(1.1))), 1e-12);
}

// ---- A car ------------------------------------------------------------------------------------

std::vector<WheelMotion> steer(std::uint64_t seed, int records = 60) {
  RandomStream random(seed);
  std::vector<WheelMotion> all;
  for (int i = 0; i < records; ++i)
    all.push_back({at(0.1 * i), random.uniform(-1, 4), random.uniform(-0.4, 0.4)});
  return all;
}

TEST(MotionInput, ACarGoesOnAsItsLastRecordSays) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto records = steer(seed);
    Pose2 twin;
    for (const WheelMotion& w : records)
      twin = twin * exp(0.1 * w.speed * Vec3(1, 0, std::tan(w.steering) / 2.7));
    RandomStream random(seed, 1);
    std::vector<double> times{6};
    for (int i = 0; i < 40; ++i) times.push_back(random.uniform(0, 6));
    const Motion once = driven(records, {6}), often = driven(records, times);
    EXPECT_LT(apart(once.T_from_to, twin), 1e-12);
    EXPECT_LT(apart(often.T_from_to, twin), 1e-12);
    // An arc that is cut spreads its noise along itself: the same but for that.
    EXPECT_LT((often.by_extra - once.by_extra).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_LT((often.noise - once.noise).norm(), 0.02 * once.noise.norm());
  }
}

// by_extra against the same drive with other numbers: what the filter makes of it.
TEST(MotionInput, WhatTheWheelsCountWronglyMovesTheCarAsItSays) {
  const auto records = steer(4, 30);
  const Motion motion = driven(records, {3});
  constexpr double kStep = 1e-4;
  for (int k = 0; k < MotionInput::kLag; ++k) {
    const auto end = [&](double by) {
      Eigen::Matrix<double, MotionInput::kNumbers, 1> n;
      n << 1, 1, 0, 0, 0, 0, 0;
      n(k) += by;
      Pose2 car;
      for (const WheelMotion& w : records) {
        const double way = 0.1 * w.speed * n(0);
        const double turn = std::tan(n(1) * w.steering) / 2.7 + n(2) +
                            (n(3) * std::pow(w.steering, 3) + n(4) * w.steering * w.steering) / 2.7;
        car = car * exp(Vec3(way, n(5) * 0.1 * w.speed, 0.1 * w.speed * n(0) * turn));
      }
      return car;
    };
    const Vec3 slope =
        (log(between(motion.T_from_to, end(kStep))) - log(between(motion.T_from_to, end(-kStep)))) /
        (2 * kStep);
    EXPECT_LT((slope - motion.by_extra.col(k)).norm(), 1e-5 * (1 + slope.norm())) << k;
  }
  EXPECT_EQ(motion.by_extra.rightCols<4>().norm(), 0);  // antenna and satellites
}

TEST(MotionInput, NoiseIsThatOfTheWayDriven) {
  MotionInput input = fresh();
  input.add(WheelMotion{at(0), 2, 0});
  const Motion m = input.take(at(3));
  EXPECT_NEAR(m.noise(0, 0), 0.02 * 0.02 * 6, 1e-12);
  EXPECT_NEAR(m.noise(2, 2), 0.005 * 0.005 * 6, 1e-12);
  EXPECT_NEAR(input.way(), 6, 1e-12);
  EXPECT_EQ(input.turned(), 0);
  EXPECT_EQ(input.take(at(3)).noise.norm(), 0);
}

TEST(MotionInput, BackwardCountsAsAWay) {
  MotionInput input = fresh();
  input.add(WheelMotion{at(0), 2, 0.1});
  input.add(WheelMotion{at(1), -2, 0.1});
  const Motion m = input.take(at(2));
  EXPECT_LT(apart(m.T_from_to, {}), 1e-12);
  EXPECT_NEAR(input.way(), 4, 1e-12);
  EXPECT_NEAR(input.turned(), 4 * std::tan(0.1) / 2.7, 1e-12);
}

// Both tell of the same motion; it is not made twice.
TEST(MotionInput, TheFirstKindToComeCounts) {
  MotionInput wheels = fresh(), poses = fresh();
  wheels.add(WheelMotion{at(0), 2, 0});
  poses.add(Odometry{at(0), {}, {}, {}});
  for (MotionInput* input : {&wheels, &poses})
    for (const double t : {1.0, 2.0}) {
      input->add(WheelMotion{at(t), 2, 0});
      input->add(Odometry{at(t), {2.2 * t, 0, 0}, {}, {}});
    }
  EXPECT_NEAR(wheels.take(at(2)).T_from_to.x, 4, 1e-12);
  EXPECT_NEAR(poses.take(at(2)).T_from_to.x, 4.4, 1e-12);
}

// ---- Nothing ----------------------------------------------------------------------------------

TEST(MotionInput, WithoutAnyWordTheDoubtGrows) {
  MotionInput input = fresh();
  EXPECT_FALSE(input.told());
  EXPECT_EQ(input.take(at(0)).noise.norm(), 0);  // where it begins
  const Motion m = input.take(at(4));
  EXPECT_EQ(m.T_from_to, Pose2{});
  EXPECT_NEAR((m.noise - 0.25 * 4 * Mat3::Identity()).norm(), 0, 1e-12);
  input.add(WheelMotion{at(4), 0, 0});
  EXPECT_TRUE(input.told());
  EXPECT_EQ(input.take(at(5)).noise.norm(), 0);
}

TEST(MotionInput, TimeDoesNotRunBack) {
  MotionInput input = fresh();
  input.add(WheelMotion{at(0), 1, 0});
  EXPECT_NEAR(input.take(at(2)).T_from_to.x, 2, 1e-12);
  EXPECT_EQ(input.take(at(1)).T_from_to.x, 0);
  EXPECT_NEAR(input.take(at(3)).T_from_to.x, 1, 1e-12);
}

TEST(MotionInput, TakenWithScalesOfOneAndNoOffsets) {
  MotionInput input = fresh();
  for (int i = 0; i < 3; ++i) {
    const Motion m = input.take(at(i));
    MotionInput::Motion::State from;
    from.extra(WheelStep::kScale) = from.extra(WheelStep::kTurnScale) = 1;
    EXPECT_EQ(m.at, from.extra);
    EXPECT_EQ(m.apply(from).extra, from.extra);
  }
}

// Of a sensor that never reads the same twice, until it is stuck.
TEST(MotionInput, HowFarTheSteeringStaysTheSame) {
  MotionInput input({}, 2.7, 1);
  for (int k = 0; k < 100; ++k) {
    if (k == 20) EXPECT_TRUE(std::isinf(input.steering_held_before()));
    input.add(WheelMotion{k * kSecond / 10, 2, 0.001 * std::min(k, 60)});
  }
  EXPECT_NEAR(input.steering_held_before(), 0.2, 1e-9);
  EXPECT_NEAR(input.steering_held(), 39 * 0.2, 1e-9);
  input.add(WheelMotion{10 * kSecond, 2, 0});
  EXPECT_EQ(input.steering_held(), 0);
}

TEST(MotionInput, TheCrabWandersByTheWay) {
  MotionInput input(kRandom, 2.7, 0.5, 2e-3);
  input.add(WheelMotion{at(0), 3, 0.1});
  EXPECT_EQ(input.take(at(0)).extra_noise.norm(), 0);
  const Motion motion = input.take(at(2));
  EXPECT_NEAR(motion.extra_noise(MotionInput::kCrab), 4e-6 * 6, 1e-12);
  EXPECT_EQ(motion.extra_noise.sum(), motion.extra_noise(MotionInput::kCrab));
}

}  // namespace
}  // namespace majak::slam
