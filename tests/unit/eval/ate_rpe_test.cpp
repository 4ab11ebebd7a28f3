// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/ate_rpe.hpp"

#include <gtest/gtest.h>

#include "majak/core/random.hpp"

namespace majak::eval {
namespace {

std::vector<PosePair> random_pairs(std::size_t n, double noise, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<PosePair> pairs;
  Pose2 truth;
  for (std::size_t i = 0; i < n; ++i) {
    truth = truth * exp({0.5, 0, random.uniform(-0.4, 0.4)});
    const Pose2 estimate{truth.x + noise * random.normal(), truth.y + noise * random.normal(),
                         wrap_angle(truth.theta + noise * random.normal())};
    pairs.push_back({static_cast<Time>(i) * kSecond, estimate, truth, true});
  }
  return pairs;
}

double squared_distance(const std::vector<PosePair>& pairs, const Pose2& T) {
  double sum = 0;
  for (const auto& p : pairs) {
    sum += (T * p.T_map_robot.translation() - p.T_reference_robot.translation()).squaredNorm();
  }
  return sum;
}

TEST(Align, UndoesAnyRigidMotion) {
  RandomStream random(3);
  for (int round = 0; round < 50; ++round) {
    auto pairs = random_pairs(20, 0, 100 + static_cast<std::uint64_t>(round));
    const Pose2 T{random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-kPi, kPi)};
    for (auto& p : pairs) p.T_map_robot = T.inverse() * p.T_reference_robot;
    const Pose2 found = align(pairs);
    EXPECT_NEAR(found.x, T.x, 1e-9);
    EXPECT_NEAR(found.y, T.y, 1e-9);
    EXPECT_NEAR(angle_diff(found.theta, T.theta), 0, 1e-10);
  }
}

TEST(Align, IsTheLeastSquaresOptimum) {
  const auto pairs = random_pairs(40, 0.3, 5);
  const Pose2 best = align(pairs);
  const double least = squared_distance(pairs, best);
  for (const Vec3& step : {Vec3{1e-3, 0, 0}, Vec3{0, 1e-3, 0}, Vec3{0, 0, 1e-3}}) {
    EXPECT_GT(squared_distance(pairs, best * exp(step)), least);
    EXPECT_GT(squared_distance(pairs, best * exp(-step)), least);
  }
}

TEST(Align, OfARobotThatStoodUsesItsHeading) {
  const std::vector<PosePair> pairs(3, PosePair{0, {1, 2, 0.1}, {5, 6, 0.6}, true});
  const Pose2 T = align(pairs);
  EXPECT_NEAR(T.theta, 0.5, 1e-12);
  EXPECT_LT(absolute_error(pairs).translation.max, 1e-12);
}

TEST(AbsoluteError, OfATrajectoryWithItselfIsZero) {
  const auto pairs = random_pairs(30, 0, 1);
  for (const auto alignment : {Alignment::none, Alignment::first_pose, Alignment::best}) {
    const auto e = absolute_error(pairs, alignment);
    EXPECT_EQ(e.translation.count, 30u);
    EXPECT_LT(e.translation.max, 1e-9);
    EXPECT_LT(e.rotation.max, 1e-9);
  }
}

TEST(AbsoluteError, DoesNotChangeWhenTheEstimateMovesRigidly) {
  auto pairs = random_pairs(30, 0.2, 2);
  const auto before = absolute_error(pairs),
             before_first = absolute_error(pairs, Alignment::first_pose);
  for (auto& p : pairs) p.T_map_robot = Pose2{-7, 3, -2} * p.T_map_robot;
  EXPECT_NEAR(absolute_error(pairs).translation.rms, before.translation.rms, 1e-10);
  EXPECT_NEAR(absolute_error(pairs).rotation.mean, before.rotation.mean, 1e-10);
  EXPECT_NEAR(absolute_error(pairs, Alignment::first_pose).translation.rms,
              before_first.translation.rms, 1e-10);
}

TEST(AbsoluteError, GivesBackAnInjectedHeadingError) {
  auto pairs = random_pairs(30, 0, 4);
  for (auto& p : pairs) p.T_map_robot.theta = wrap_angle(p.T_map_robot.theta + 0.1);
  const auto e = absolute_error(pairs);
  EXPECT_NEAR(e.rotation.mean, 0.1, 1e-10);
  EXPECT_LT(e.translation.max, 1e-9);
}

TEST(AbsoluteError, FromTheFirstPoseShowsTheDrift) {
  // A straight drive of 10 m with a heading that is 0.01 rad wrong from the start of the map on.
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 10; ++i) {
    pairs.push_back({i * kSecond, Pose2{1.0 * i, 0.01 * i, 0}, Pose2{1.0 * i, 0, 0}, true});
  }
  EXPECT_NEAR(absolute_error(pairs, Alignment::first_pose).translation.max, 0.1, 1e-12);
  EXPECT_LT(absolute_error(pairs, Alignment::best).translation.max, 1e-3);
  EXPECT_EQ(absolute_error({}).translation.count, 0u);
}

TEST(RelativeErrors, OfAWrongScaleGrowWithTheDistance) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 100; ++i) {
    pairs.push_back({i * kSecond, Pose2{0.101 * i, 0, 0}, Pose2{0.1 * i, 0, 0}, true});
  }
  const auto errors = relative_errors(pairs, {1, 5, 1000});
  ASSERT_EQ(errors.size(), 2u);  // the path has 10 m only
  EXPECT_NEAR(errors[0].translation.mean, 0.01, 2e-3);
  EXPECT_NEAR(errors[1].translation.mean, 0.05, 2e-3);
  EXPECT_GE(errors[0].translation.count, 90u);
  EXPECT_LT(errors[1].rotation.max, 1e-12);
  EXPECT_NEAR(path_length(pairs), 10, 1e-9);
}

TEST(RelativeErrors, AgreeWithTheSlowTwin) {
  const auto pairs = random_pairs(60, 0.1, 9);
  std::vector<double> errors;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    double length = 0;
    for (std::size_t j = i + 1; j < pairs.size(); ++j) {
      length +=
          (pairs[j].T_reference_robot.translation() - pairs[j - 1].T_reference_robot.translation())
              .norm();
      if (length < 3) continue;
      const Pose2 e = between(between(pairs[i].T_reference_robot, pairs[j].T_reference_robot),
                              between(pairs[i].T_map_robot, pairs[j].T_map_robot));
      errors.push_back(e.translation().norm());
      break;
    }
  }
  const auto fast = relative_errors(pairs, {3});
  ASSERT_EQ(fast.size(), 1u);
  EXPECT_EQ(fast[0].translation.count, errors.size());
  EXPECT_NEAR(fast[0].translation.mean, error_stats(errors).mean, 1e-12);
}

}  // namespace
}  // namespace majak::eval
