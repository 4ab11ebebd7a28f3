// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/dead_reckoning.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::localize {
namespace {

Localization run(const std::vector<Event>& events, const DeadReckoningOptions& options = {},
                 const Pose2& start = {}) {
  const Localizer localizer = dead_reckoning(options, start);
  for (const Event& event : events) localizer.add(event);
  return localizer.finish();
}

Odometry odometry(double seconds, const Pose2& pose) {
  return {.time = from_seconds(seconds), .T_odom_robot = pose, .speed = {}, .turn_rate = {}};
}

void expect_near(const Pose2& a, const Pose2& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(angle_diff(a.theta, b.theta), 0, tolerance);
}

std::int64_t skipped(const Localization& result) {
  std::int64_t n = 0;
  for (const auto& [what, entry] : result.report.entries()) n += entry.count;
  return n;
}

TEST(DeadReckoning, AddsUpFromTheStart) {
  const Pose2 start{3, -2, kPi / 2};
  const auto result = run({odometry(0, {5, 5, 1}), odometry(1, Pose2{5, 5, 1} * Pose2{0.5, 0, 0.2}),
                           odometry(2, Pose2{5, 5, 1} * Pose2{1, 0.2, 0.4})},
                          {}, start);
  ASSERT_EQ(result.estimates.size(), 3U);
  expect_near(result.estimates[0].T_map_robot, start);
  EXPECT_EQ(result.estimates[0].covariance, Mat3::Zero().eval());
  expect_near(result.estimates[2].T_map_robot, start * Pose2{1, 0.2, 0.4});
  EXPECT_EQ(result.estimates[2].time, 2 * kSecond);
  EXPECT_TRUE(result.report.empty());
}

TEST(DeadReckoning, AddReturnsTheNewestEstimate) {
  const Localizer localizer = dead_reckoning({});
  EXPECT_FALSE(localizer.add(Truth{}));
  EXPECT_TRUE(localizer.add(odometry(0, {})));
  const auto estimate = localizer.add(odometry(1, {0.3, 0, 0}));
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->T_map_robot.x, 0.3, 1e-15);
}

TEST(DeadReckoning, WheelsFollowExactArcs) {
  DeadReckoningOptions options;
  options.wheelbase = 2;
  std::vector<Event> events;
  for (int i = 0; i <= 100; ++i)
    events.push_back(WheelMotion{.time = i * kSecond / 20, .speed = 3, .steering = 0.3});
  const auto result = run(events, options);
  const double radius = 2 / std::tan(0.3), turn = 15 / radius;  // 5 s at 3 m/s
  expect_near(result.estimates.back().T_map_robot,
              {radius * std::sin(turn), radius * (1 - std::cos(turn)), wrap_angle(turn)}, 1e-9);
  EXPECT_GT(result.estimates.back().covariance(2, 2), 0);
}

TEST(DeadReckoning, ScansOwnOdometryServesUntilThereIsBetter) {
  Scan scan;
  scan.time = kSecond;
  scan.T_odom_robot = Pose2{1, 0, 0};
  Scan later = scan;
  later.time = 2 * kSecond;
  later.T_odom_robot = Pose2{1.5, 0, 0};
  EXPECT_EQ(run({scan, later}).estimates.size(), 2U);
  EXPECT_NEAR(run({scan, later}).estimates.back().T_map_robot.x, 0.5, 1e-15);
  const auto mixed = run({odometry(0.5, {0.8, 0, 0}), scan, odometry(2, {1.5, 0, 0}), later});
  EXPECT_EQ(mixed.estimates.size(), 2U);
  EXPECT_NEAR(mixed.estimates.back().T_map_robot.x, 0.7, 1e-15);
}

TEST(DeadReckoning, DamagedRecordsAreLeftOutAndCounted) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto jump = run({odometry(0, {}), odometry(0.1, {0.1, 0, 0}), odometry(0.2, {900, 0, 0}),
                         odometry(0.3, {900.1, 0, 0}), odometry(0.4, {nan, 0, 0})});
  EXPECT_NEAR(jump.estimates.back().T_map_robot.x, 0.2, 1e-9);
  EXPECT_EQ(skipped(jump), 2);
  const auto wheels =
      run({WheelMotion{0, 1, 0}, WheelMotion{kSecond / 2, nan, 0}, WheelMotion{kSecond / 2, 1, 2},
           WheelMotion{-kSecond, 1, 0}, WheelMotion{kSecond, 1, 0}, WheelMotion{9 * kSecond, 1, 0},
           odometry(9, {})});
  EXPECT_NEAR(wheels.estimates.back().T_map_robot.x, 2, 1e-12);  // of the pause one second
  EXPECT_EQ(skipped(wheels), 5);
}

/// A tour with many ways back.
std::vector<Event> tour(int seed) {
  static const sim::World world(sim::building());
  sim::TourOptions tour;
  tour.short_tour = true;
  static const sim::Path path = sim::plan_tour(world, tour);
  sim::SimulationOptions options;
  options.seed = seed;
  options.beams = 101;
  options.scan_rate = 0.5;
  return sim::simulate(world, path, options);
}

TEST(DeadReckoning, TraceNeverFalls) {
  double last = 0;
  for (const Estimate& e : run(tour(1)).estimates) {
    ASSERT_GE(e.covariance.trace(), last * (1 - 1e-12));
    ASSERT_TRUE(e.covariance.isApprox(e.covariance.transpose()));
    last = e.covariance.trace();
  }
  EXPECT_GT(last, 0);
}

TEST(DeadReckoning, HonestWithoutTheFloorAndCautiousWithIt) {
  // After some spins the heading is unsure; 10 m ahead and back again undo what that did.
  std::vector<Event> there_and_back;
  for (int i = 0; i <= 100; ++i) there_and_back.push_back(odometry(i, {0, 0, wrap_angle(0.5 * i)}));
  const Pose2 begin{0, 0, wrap_angle(50)};
  for (int i = 1; i <= 200; ++i)
    there_and_back.push_back(
        odometry(100 + i, begin * Pose2{i <= 100 ? 0.1 * i : 0.1 * (200 - i), 0, 0}));
  DeadReckoningOptions honest;
  honest.never_shrink = false;
  const auto a = run(there_and_back, honest), b = run(there_and_back);
  EXPECT_LT(a.estimates.back().covariance.trace(), a.estimates[200].covariance.trace());
  EXPECT_GE(b.estimates.back().covariance.trace(), b.estimates[200].covariance.trace());
  for (std::size_t i = 1; i < a.estimates.size(); ++i) {
    const Mat3 more = b.estimates[i].covariance - a.estimates[i].covariance;
    EXPECT_GE(more.diagonal().minCoeff(), 0);
  }
}

TEST(DeadReckoning, EllipsesHoldSimulatedRobots) {
  // 40 robots whose wheels are wrong, each in its own way; the end of each drive of 100 m.
  int inside = 0;
  constexpr int kRobots = 40;
  for (int seed = 1; seed <= kRobots; ++seed) {
    const auto events = tour(seed);
    Truth first{}, last{};
    bool any = false;
    for (const Event& event : events) {
      const auto* truth = std::get_if<Truth>(&event);
      if (truth == nullptr) continue;
      if (!any) first = *truth, any = true;
      last = *truth;
    }
    DeadReckoningOptions honest;
    honest.never_shrink = false;
    const Estimate end = run(events, honest).estimates.back();
    // In the robot's axes and exponential coordinates: after 100 m the banana is well bent.
    const Pose2 truth = between(first.T_world_robot, last.T_world_robot);
    const Vec2 error = log(between(end.T_map_robot, truth)).head<2>();
    const Mat3 P = motion::in_map_axes(end.covariance, -end.T_map_robot.theta);
    inside += error.dot(Eigen::Matrix2d(P.topLeftCorner<2, 2>()).llt().solve(error)) < 5.991;
  }
  // 95 % of 40 would be 38; the defaults are for the simulator's own robots, a little cautious.
  EXPECT_GE(inside, 35);
}

}  // namespace
}  // namespace majak::localize
