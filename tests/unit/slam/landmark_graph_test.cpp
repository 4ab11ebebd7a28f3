// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/landmark_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/motion/wheel_step.hpp"

namespace majak::slam {
namespace {

using motion::WheelStep;

const std::vector<Vec2> kTrunks = {{5, 3}, {12, -2}, {18, 6}, {9, 14}, {-3, 12}, {2, 20}, {16, 17}};

/// Two rounds of a circle of 10 m radius among trunks, as EkfSlam::finish() would tell of it.
/// `scale`: of the way, as the wheels count it; `noise`: m, of the sightings.
struct Round {
  LandmarkMap seen;
  std::vector<Pose2> truth;

  explicit Round(double scale = 1, double noise = 0) {
    RandomStream random(1);
    Pose2 at{8, -2, 0};
    const Vec3 twist(1, 0, 0.1);
    seen.numbers.setZero();
    seen.numbers(WheelStep::kScale) = seen.numbers(WheelStep::kTurnScale) = 1;
    for (const Vec2& p : kTrunks) seen.landmarks.push_back({.p_map = p, .sightings = 10});
    for (std::size_t k = 0; k < 126; ++k) {
      if (k > 0) at = at * exp(twist);
      truth.push_back(at);
      Estimate e;
      e.time = static_cast<Time>(k) * kSecond;
      e.T_map_robot = at;
      seen.localization.estimates.push_back(e);
      seen.steps.push_back(step(twist / scale));
      for (std::size_t i = 0; i < kTrunks.size(); ++i)
        if (const Vec2 q = at.inverse() * kTrunks[i]; q.norm() < 12)
          seen.observations.push_back({k, static_cast<int>(i),
                                       q + noise * Vec2(random.normal(), random.normal()),
                                       1e-3 * Eigen::Matrix2d::Identity()});
    }
  }
  static MotionInput::Motion step(const Vec3& counted) {
    MotionInput::Motion motion = MotionInput::counted_right();
    motion.T_from_to = exp(counted);
    motion.by_extra.leftCols<WheelStep::kNumbers>() =
        right_jacobian(counted) * motion::wheel_step(counted).by_numbers;
    motion.noise.diagonal() << 4e-4, 4e-4, 1e-4;
    return motion;
  }
  double worst(const LandmarkMap& map) const {
    double worst = 0;
    for (std::size_t k = 0; k < truth.size(); ++k)
      worst = std::max(
          worst, (map.localization.estimates[k].T_map_robot.translation() - truth[k].translation())
                     .norm());
    return worst;
  }
};

TEST(LandmarkGraph, TheTruthStaysWhereItIs) {
  const Round round;
  const LandmarkMap map = optimize_landmarks(round.seen);
  EXPECT_LT(round.worst(map), 1e-6);
  for (std::size_t i = 0; i < kTrunks.size(); ++i)
    EXPECT_LT((map.landmarks[i].p_map - kTrunks[i]).norm(), 1e-6);
}

TEST(LandmarkGraph, BentPathsComeBack) {
  Round round;
  for (std::size_t k = 1; k < round.truth.size(); ++k) {
    Pose2& pose = round.seen.localization.estimates[k].T_map_robot;
    pose = pose * Pose2{0.4 * std::sin(0.3 * double(k)), 0.3, 0.1};
  }
  for (MappedLandmark& l : round.seen.landmarks) l.p_map += Vec2(0.5, -0.4);
  EXPECT_LT(round.worst(optimize_landmarks(round.seen)), 1e-4);
}

TEST(LandmarkGraph, WhatTheWheelsCountWronglyIsLearnt) {
  Round round(1.03);
  round.seen.localization.learnt = {{"scale of the way", "1", 7, 7}};  // by the filter
  const LandmarkMap map = optimize_landmarks(round.seen);
  EXPECT_NEAR(map.numbers(WheelStep::kScale), 1.03, 2e-3);
  ASSERT_EQ(map.localization.learnt.size(), 1u);
  EXPECT_EQ(map.localization.learnt[0].value, map.numbers(WheelStep::kScale));
  EXPECT_NEAR(map.localization.learnt[0].sigma, 0.02 / std::sqrt(125), 3e-4);
  EXPECT_LT(round.worst(map), 0.02);
}

TEST(LandmarkGraph, LandmarksThatAreOneBecomeOne) {
  Round round;
  const auto twin = static_cast<int>(round.seen.landmarks.size());
  round.seen.landmarks.push_back({.p_map = kTrunks[0] + Vec2(0.3, 0.2), .sightings = 5});
  int moved = 0;
  for (LandmarkObservation& o : round.seen.observations)
    if (o.landmark == 0 && o.scan > 60) o.landmark = twin, ++moved;
  ASSERT_GT(moved, 3);
  const LandmarkMap map = optimize_landmarks(round.seen);
  ASSERT_EQ(map.landmarks.size(), kTrunks.size());
  EXPECT_EQ(map.landmarks[0].sightings, 15);
  EXPECT_LT((map.landmarks[0].p_map - kTrunks[0]).norm(), 1e-6);
  for (const LandmarkObservation& o : map.observations) EXPECT_LT(o.landmark, twin);
  LandmarkGraphOptions apart;
  apart.merge_distance = 0;
  EXPECT_EQ(optimize_landmarks(round.seen, {}, apart).landmarks.size(), kTrunks.size() + 1);
}

// One sighting in forty is of something else.
TEST(LandmarkGraph, FalseSightingsAreDoubted) {
  Round round(1, 0.03);
  const double clean = round.worst(optimize_landmarks(round.seen));
  for (std::size_t i = 7; i < round.seen.observations.size(); i += 40)
    round.seen.observations[i].q_robot += Vec2(1.5, -1);
  const double disturbed = round.worst(optimize_landmarks(round.seen));
  EXPECT_LT(clean, 0.07);
  EXPECT_LT(disturbed, 0.10);
}

// The map is turned and moved to where the fixes say.
TEST(LandmarkGraph, FixesGiveTheFrame) {
  Round round;
  const Pose2 T_gps_map{100, -40, 1.2};
  const Vec2 antenna(1.5, 0.4);
  round.seen.numbers.segment<2>(MotionInput::kNumbers) = antenna;
  for (std::size_t k = 0; k < round.truth.size(); k += 2)
    round.seen.fixes.push_back({k, {}, T_gps_map * (round.truth[k] * antenna), k / 40});
  for (Estimate& e : round.seen.localization.estimates)
    e.T_map_robot = T_gps_map * Pose2{1, 0.5, 0.1} * e.T_map_robot;
  for (MappedLandmark& l : round.seen.landmarks) l.p_map = T_gps_map * l.p_map + Vec2(0.3, 0);
  for (Pose2& pose : round.truth) pose = T_gps_map * pose;
  const LandmarkMap map = optimize_landmarks(round.seen);
  EXPECT_LT(round.worst(map), 0.01);
}

// One piece of fixes is 6 m off: it is doubted, and pulls less than one that could be true.
TEST(LandmarkGraph, APieceOfFixesFarOffIsDoubted) {
  Round round;
  round.seen.numbers.segment<2>(MotionInput::kNumbers).setZero();
  for (std::size_t k = 0; k < round.truth.size(); k += 2)
    round.seen.fixes.push_back({k, {}, round.truth[k].translation(), k / 20});
  const auto pulled_by = [&](const Vec2& off) {
    Round disturbed = round;
    for (FixObservation& f : disturbed.seen.fixes)
      if (f.piece == 3) f.z += off;
    return disturbed.worst(optimize_landmarks(disturbed.seen));
  };
  EXPECT_LT(pulled_by({0, 0}), 1e-6);
  const double little = pulled_by({1, 0}), much = pulled_by({6, 0});
  EXPECT_GT(little, 0.05);
  EXPECT_LT(much, 1.5 * little);
}

TEST(LandmarkGraph, TellsWhatItLearnt) {
  Round round(1.03);
  round.seen.localization.learnt = {{"scale of the way", "1", 1.0, 0.03}};
  const LandmarkMap map = optimize_landmarks(round.seen);
  EXPECT_EQ(map.localization.learnt[0].value, map.numbers(WheelStep::kScale));
  EXPECT_LT(map.localization.learnt[0].sigma, 0.01);
}

TEST(LandmarkGraph, NothingGivesNothing) { EXPECT_TRUE(optimize_landmarks({}).landmarks.empty()); }

}  // namespace
}  // namespace majak::slam
