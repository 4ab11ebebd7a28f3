// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/trajectory.hpp"

#include <gtest/gtest.h>

#include "majak/core/error.hpp"
#include "majak/eval/statistics.hpp"

namespace majak::eval {
namespace {

TEST(ReadTum, TakesYawFromTheQuaternion) {
  auto in = io::open_bytes_in_memory(
      "# time x y z qx qy qz qw\n"
      "976052905.167303001 1 2 0 0 0 0.7071067811865476 0.7071067811865476\n"
      "2.5 1 2 0 0 0 -2 0\n"  // a turn of half a circle, not normalized
      "3.5 1 2 0 0 0 0 0\n"   // no rotation at all
      "3.5 1 2 0 0 0 0\n");
  Report report;
  const Trajectory t = read_tum(std::move(in.bytes), "test", report);
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].time, 976052905167303001);
  EXPECT_NEAR(t[0].pose.theta, kPi / 2, 1e-12);
  EXPECT_NEAR(std::abs(t[1].pose.theta), kPi, 1e-12);
  EXPECT_EQ(report.entries().size(), 2u);
  auto nothing = io::open_bytes_in_memory("hello\n");
  EXPECT_THROW(read_tum(std::move(nothing.bytes), "nothing", report), Error);
}

TEST(TrajectoryIndex, FindsEachOfItsOwnStamps) {
  Trajectory t;
  for (int i = 0; i < 50; ++i) t.push_back({(i * 37 % 50) * kSecond, {1.0 * i, 0, 0}});  // unsorted
  const TrajectoryIndex index(t);
  for (std::size_t i = 0; i < t.size(); ++i) {
    const auto found = index.at(t[i].time);
    ASSERT_TRUE(found && found->exact);
    EXPECT_EQ(found->index, i);
    EXPECT_EQ(found->pose, t[i].pose);
  }
}

TEST(TrajectoryIndex, InterpolatesAlongTheArcButNotOverGapsOrEnds) {
  const Pose2 end = exp({kPi / 2, 0, kPi / 2});  // a quarter of the unit circle
  const TrajectoryIndex index({{0, {}}, {kSecond, end}, {10 * kSecond, end}});
  const auto half = index.at(kSecond / 2);
  ASSERT_TRUE(half);
  EXPECT_FALSE(half->exact);
  EXPECT_NEAR(half->pose.x, std::sin(kPi / 4), 1e-12);
  EXPECT_NEAR(half->pose.y, 1 - std::cos(kPi / 4), 1e-12);
  EXPECT_FALSE(index.at(5 * kSecond));
  EXPECT_FALSE(index.at(-kSecond));
  EXPECT_FALSE(index.at(11 * kSecond));
  EXPECT_FALSE(TrajectoryIndex({}).at(0));
}

TEST(TrajectoryIndex, PrefersTheNearestOfCloseStamps) {
  const TrajectoryIndex index({{1000, {1, 0, 0}}, {4000, {2, 0, 0}}, {7000, {3, 0, 0}}});
  EXPECT_EQ(index.at(3900)->pose.x, 2);
  EXPECT_EQ(index.at(5600)->pose.x, 3);
  EXPECT_EQ(index.at(0)->pose.x, 1);
}

TEST(Associate, PairsEqualStampsOneToOneInTheirOrder) {
  const Trajectory estimate = {{5, {1, 0, 0}}, {5, {2, 0, 0}}, {5, {3, 0, 0}}};
  const Trajectory reference = {{5, {10, 0, 0}}, {5, {20, 0, 0}}};
  const auto a = associate(estimate, reference);
  ASSERT_EQ(a.pairs.size(), 2u);
  EXPECT_EQ(a.pairs[0].T_reference_robot.x, 10);
  EXPECT_EQ(a.pairs[1].T_reference_robot.x, 20);
  EXPECT_EQ(a.unmatched, 1u);
}

TEST(Associate, NeverUsesAReferencePoseTwice) {
  const Trajectory estimate = {{1000, {}}, {3000, {}}};  // both within the tolerance of one pose
  const auto a = associate(estimate, {{2000, {}}});
  EXPECT_EQ(a.pairs.size(), 1u);
  EXPECT_EQ(a.unmatched, 1u);
}

TEST(Associate, InterpolatesTheReference) {
  const Trajectory reference = {{0, {0, 0, 0}}, {kSecond, {1, 0, 0}}};
  const auto a = associate({{kSecond / 4, {}}}, reference);
  ASSERT_EQ(a.pairs.size(), 1u);
  EXPECT_NEAR(a.pairs[0].T_reference_robot.x, 0.25, 1e-12);
  EXPECT_EQ(a.interpolated, 1u);
}

TEST(ErrorStats, OfKnownNumbers) {
  const ErrorStats s = error_stats({4, 1, 3, 2});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.sigma, std::sqrt(5.0 / 3.0));
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.max, 4);
  EXPECT_EQ(error_stats({}).count, 0u);
  EXPECT_EQ(error_stats({7}).sigma, 0);
  EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.9), 9);
  EXPECT_DOUBLE_EQ(quantile({3}, 0.1), 3);
}

}  // namespace
}  // namespace majak::eval
