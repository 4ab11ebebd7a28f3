// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/split_maps.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "majak/core/random.hpp"
#include "majak/motion/wheel_step.hpp"

namespace majak::eval {
namespace {

const std::vector<Vec2> kTrunks = {{5, 3}, {12, -2}, {18, 6}, {9, 14}, {-3, 12}, {2, 20}, {16, 17}};

/// Six rounds of a circle of 10 m radius among trunks, 63 s each, as the graph would tell of it;
/// `noise`: m, of the sightings. The last trunk is seen in the first round alone.
slam::LandmarkMap rounds(double noise) {
  using motion::WheelStep;
  RandomStream random(1);
  const Vec3 twist(1, 0, 0.1);
  slam::LandmarkMap map;
  map.numbers.setZero();
  map.numbers(WheelStep::kScale) = map.numbers(WheelStep::kTurnScale) = 1;
  for (const Vec2& p : kTrunks) map.landmarks.push_back({.p_map = p, .sightings = 10});
  Pose2 at{8, -2, 0};
  for (std::size_t k = 0; k < 378; ++k) {
    if (k > 0) at = at * exp(twist);
    Estimate e;
    e.time = static_cast<Time>(k) * kSecond;
    e.T_map_robot = at;
    map.localization.estimates.push_back(e);
    slam::MotionInput::Motion step = slam::MotionInput::counted_right();
    step.T_from_to = exp(twist);
    step.by_extra.leftCols<WheelStep::kNumbers>() =
        right_jacobian(twist) * motion::wheel_step(twist).by_numbers;
    step.noise.diagonal() << 4e-4, 4e-4, 1e-4;
    map.steps.push_back(step);
    for (std::size_t i = 0; i < kTrunks.size(); ++i) {
      if (i + 1 == kTrunks.size() && k > 60) continue;
      const Vec2 q = at.inverse() * kTrunks[i] + noise * Vec2(random.normal(), random.normal());
      if (q.norm() < 12)
        map.observations.push_back({k, static_cast<int>(i), q, 1e-3 * Eigen::Matrix2d::Identity()});
    }
  }
  return map;
}

TEST(SplitMaps, OfExactSightingsAreTheSame) {
  const SplitHalf split = split_maps(rounds(0), {}, {});
  ASSERT_EQ(split.landmarks.size(), kTrunks.size() - 1);
  for (std::size_t i = 0; i < split.landmarks.size(); ++i) {
    EXPECT_EQ(split.landmarks[i].landmark, static_cast<int>(i));
    EXPECT_LT((split.landmarks[i].even - kTrunks[i]).norm(), 1e-6);
  }
  EXPECT_LT(split.error.max, 1e-6);
}

TEST(SplitMaps, NoiseShowsAndIsNotThatOfOnePath) {
  const slam::LandmarkMap map = rounds(0.05);
  const SplitHalf split = split_maps(map, {}, {});
  EXPECT_GT(split.error.mean, 0.01);
  EXPECT_LT(split.error.mean, 0.2);
  const SplitHalf shape = aligned(split);
  EXPECT_LT(shape.error.rms, split.error.rms);
}

TEST(SplitMaps, OfNothingAreNothing) {
  EXPECT_TRUE(split_maps({}, {}, {}).landmarks.empty());
  EXPECT_TRUE(aligned({}).landmarks.empty());
}

TEST(SplitMaps, AlignmentTakesARigidMotionAway) {
  const Pose2 T{3, -1, 0.4};
  SplitHalf split;
  for (std::size_t i = 0; i < kTrunks.size(); ++i)
    split.landmarks.push_back({static_cast<int>(i), kTrunks[i], T * kTrunks[i]});
  EXPECT_GT(split.landmarks[0].distance(), 1);
  const SplitHalf shape = aligned(split);
  EXPECT_EQ(shape.error.count, kTrunks.size());
  EXPECT_LT(shape.error.max, 1e-12);
  split.landmarks[2].odd += Vec2(1, 0);
  EXPECT_GT(aligned(split).error.max, 0.5);
}

}  // namespace
}  // namespace majak::eval
