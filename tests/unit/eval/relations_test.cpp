// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/relations.hpp"

#include <gtest/gtest.h>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::eval {
namespace {

/// A robot that drives a wavy path, one pose a second.
Trajectory wavy_path(std::size_t n) {
  Trajectory path;
  Pose2 pose;
  for (std::size_t i = 0; i < n; ++i) {
    path.push_back({static_cast<Time>(i) * kSecond, pose});
    pose = pose * exp({0.4, 0.0, 0.3 * std::sin(0.2 * static_cast<double>(i))});
  }
  return path;
}

std::vector<Relation> relations_of(const Trajectory& path, std::size_t count) {
  RandomStream random(7);
  std::vector<Relation> relations;
  while (relations.size() < count) {
    const auto& a = path[random.below(path.size())];
    const auto& b = path[random.below(path.size())];
    relations.push_back({a.time, b.time, between(a.pose, b.pose), 0});
  }
  return relations;
}

TEST(Relations, OfATrajectoryWithItselfAreExact) {
  const Trajectory path = wavy_path(100);
  const auto result = evaluate_relations(path, relations_of(path, 200));
  EXPECT_EQ(result.exact, 200u);
  EXPECT_EQ(result.all.translation.count, 200u);
  EXPECT_LT(result.all.translation.max, 1e-12);
  EXPECT_LT(result.all.rotation.max, 1e-12);
}

TEST(Relations, DoNotChangeWhenEverythingMovesRigidly) {
  const Trajectory path = wavy_path(100);
  auto relations = relations_of(path, 50);
  for (auto& r : relations) r.T_from_to.x += 0.1;  // some error to look at
  const auto before = evaluate_relations(path, relations);
  Trajectory moved = path;
  for (auto& p : moved) p.pose = Pose2{100, -50, 2.5} * p.pose;
  const auto after = evaluate_relations(moved, relations);
  EXPECT_NEAR(before.all.translation.mean, 0.1, 1e-12);
  EXPECT_NEAR(after.all.translation.mean, before.all.translation.mean, 1e-10);
  EXPECT_NEAR(after.all.rotation.mean, before.all.rotation.mean, 1e-10);
}

TEST(Relations, GiveBackTheInjectedError) {
  const Trajectory path = wavy_path(100);
  auto relations = relations_of(path, 60);
  // The estimate is off by (3 cm, 4 cm, +-0.1 rad) in the frame of the second pose.
  for (std::size_t i = 0; i < relations.size(); ++i) {
    const Pose2 error{0.03, 0.04, i % 2 == 0 ? 0.1 : -0.1};
    relations[i].T_from_to = relations[i].T_from_to * error.inverse();
  }
  const auto result = evaluate_relations(path, relations);
  EXPECT_NEAR(result.all.translation.mean, 0.05, 1e-12);
  EXPECT_NEAR(result.all.translation.sigma, 0.0, 1e-12);
  EXPECT_NEAR(result.all.rotation.mean, 0.1, 1e-12);
  EXPECT_NEAR(result.residuals[1].T_truth_estimate.x, 0.03, 1e-12);
  EXPECT_NEAR(result.residuals[1].T_truth_estimate.theta, -0.1, 1e-12);
}

TEST(Relations, AreShortUpToTwentySecondsAndLoopsBeyond) {
  const Trajectory path = wavy_path(60);
  std::vector<Relation> relations;
  for (const Time span : {5, 20, 21, 50}) {
    const auto i = static_cast<std::size_t>(span);
    const Pose2 off{span <= 20 ? 0.01 : 0.07, 0, 0};
    relations.push_back({0, span * kSecond, between(path[0].pose, path[i].pose) * off, 0});
  }
  std::swap(relations[3].from, relations[3].to);  // backwards in time is a span too
  relations[3].T_from_to = relations[3].T_from_to.inverse();
  const auto result = evaluate_relations(path, relations);
  EXPECT_EQ(result.near.translation.count, 2u);
  EXPECT_EQ(result.loop.translation.count, 2u);
  EXPECT_NEAR(result.near.translation.mean, 0.01, 1e-12);
  EXPECT_NEAR(result.loop.translation.mean, 0.07, 1e-12);
}

TEST(Relations, BetweenStampsAreInterpolatedAndCounted) {
  Trajectory line;
  for (int i = 0; i <= 10; ++i) line.push_back({i * kSecond, {1.0 * i, 0, 0}});
  const std::vector<Relation> relations = {
      {kSecond / 2, 4 * kSecond, {3.5, 0, 0}, 0},   // interpolated
      {kSecond, 4 * kSecond + 5000, {3, 0, 0}, 0},  // 5 microseconds off: the same stamp
      {kSecond, 11 * kSecond, {10, 0, 0}, 0},       // beyond the end
  };
  const auto result = evaluate_relations(line, relations);
  EXPECT_EQ(result.interpolated, 1u);
  EXPECT_EQ(result.exact, 1u);
  EXPECT_EQ(result.unmatched, 1u);
  EXPECT_LT(result.all.translation.max, 1e-12);
}

TEST(Relations, InTheFrameOfTheLaserAreToldApart) {
  const Trajectory robot = wavy_path(80);
  const Pose2 T_robot_laser{0.3, 0.05, 0.0};
  Trajectory laser = robot;
  for (auto& p : laser) p.pose = p.pose * T_robot_laser;
  const auto of_laser =
      evaluate_relations_in_both_frames(robot, T_robot_laser, relations_of(laser, 50));
  EXPECT_EQ(of_laser.better, BodyFrame::laser);
  EXPECT_LT(of_laser.best().all.translation.max, 1e-12);
  EXPECT_GT(of_laser.robot.all.translation.mean, 0.01);
  const auto of_robot =
      evaluate_relations_in_both_frames(robot, T_robot_laser, relations_of(robot, 50));
  EXPECT_EQ(of_robot.better, BodyFrame::robot);
  const auto centred = evaluate_relations_in_both_frames(robot, {}, relations_of(robot, 50));
  EXPECT_FALSE(centred.laser.has_value());
}

TEST(ReadRelations, TakesLinesAndCountsDamage) {
  auto in = io::open_bytes_in_memory(
      "# a comment\n"
      "976052905.167303 976052911.885496 -0.056990 -0.128430 0.0 0.0 0.0 -1.682210\r\n"
      "\n"
      "1.0 2.0 0.5 nan 0 0 0 0\n"
      "1.0 2.0 0.5 0 0 0 0\n"
      "1.5 2.5 0.5 0 0.2 0 0 7.0\n");
  Report report;
  const auto relations = read_relations(std::move(in.bytes), "test", report);
  ASSERT_EQ(relations.size(), 2u);
  EXPECT_EQ(relations[0].from, 976052905167303000);
  EXPECT_EQ(relations[0].to, 976052911885496000);
  EXPECT_DOUBLE_EQ(relations[0].T_from_to.theta, -1.68221);
  EXPECT_NEAR(relations[1].T_from_to.theta, 7.0 - 2 * kPi, 1e-15);
  EXPECT_EQ(relations[1].line, 6);
  const auto& damage = report.entries().at("relations: line is not `t1 t2 x y z roll pitch yaw`");
  EXPECT_EQ(damage.count, 2);
  EXPECT_EQ(damage.first_line, 4);
  EXPECT_EQ(report.entries().at("relations: z, roll or pitch of a relation dropped").count, 1);
}

TEST(ReadRelations, RefusesAFileWithoutAny) {
  auto in = io::open_bytes_in_memory("\n# nothing\n");
  Report report;
  EXPECT_THROW(read_relations(std::move(in.bytes), "empty.relations", report), Error);
  EXPECT_THROW(read_relations(std::string("/no/such/file"), report), Error);
}

}  // namespace
}  // namespace majak::eval
