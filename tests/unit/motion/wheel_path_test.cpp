// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/wheel_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "majak/core/random.hpp"
#include "majak/motion/seen_steps.hpp"

namespace majak::motion {
namespace {

constexpr Time kMs = kSecond / 1000;

void expect_pose_near(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(angle_diff(a.theta, b.theta), 0, tolerance);
}

// At 10 Hz from 1 s on, ahead and back.
std::vector<WheelSample> some_samples(int n = 30) {
  RandomStream random(8);
  std::vector<WheelSample> out{{kSecond, Vec3::Zero(), 0, false}};
  for (int i = 1; i < n; ++i)
    out.push_back(
        {kSecond + i * 100 * kMs,
         {random.uniform(-0.1, 0.2), random.uniform(-0.01, 0.01), random.uniform(-0.2, 0.2)},
         0,
         false});
  return out;
}

const DriveCorrection kPathWheels{
    .scale = 1.03, .turn_scale = 0.96, .turn_per_metre = 0.02, .way_per_turn = -0.01};

TEST(WheelPath, AtTheSamplesItIsTheSumOfTheirTwists) {
  const auto samples = some_samples();
  const WheelPath path(samples, kPathWheels);
  Pose2 pose;
  double way = 0, turn = 0;
  for (const WheelSample& s : samples) {
    const Vec3 twist = corrected(kPathWheels, s.twist);
    pose = pose * exp(twist), way += std::hypot(twist.x(), twist.y()), turn += std::abs(twist.z());
    const auto at = path.at(s.time);
    ASSERT_TRUE(at);
    expect_pose_near(at->pose, pose, 1e-14);
    EXPECT_NEAR(at->way, way, 1e-14);
    EXPECT_NEAR(at->turn, turn, 1e-14);
    EXPECT_EQ(at->jumps, 0);
    EXPECT_EQ(at->split_way, 0);
    EXPECT_EQ(at->split_turn, 0);
    EXPECT_EQ(at->doubt, Vec3::Zero());
  }
}

TEST(WheelPath, BetweenTheSamplesItFollowsTheArc) {
  const auto samples = some_samples();
  const WheelPath path(samples, {});
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const auto a = path.at(samples[i - 1].time), b = path.at(samples[i].time),
               m = path.at(samples[i - 1].time + 30 * kMs);
    ASSERT_TRUE(a && b && m);
    expect_pose_near(m->pose, interpolate(a->pose, b->pose, 0.3), 1e-14);
    EXPECT_NEAR(m->way, 0.7 * a->way + 0.3 * b->way, 1e-14);
    EXPECT_NEAR(m->turn, 0.7 * a->turn + 0.3 * b->turn, 1e-14);
    EXPECT_NEAR(m->split_way, 0.21 * (b->way - a->way), 1e-14);
    EXPECT_NEAR(m->split_turn, 0.21 * (b->turn - a->turn), 1e-14);
    const Vec3& after = samples[std::min(i + 1, samples.size() - 1)].twist;
    EXPECT_NEAR((m->doubt - 0.21 * (after - samples[i - 1].twist).cwiseAbs()).norm(), 0, 1e-14);
  }
}

TEST(WheelPath, OutsideTheSamplesIsNothing) {
  const WheelPath path(some_samples(11), {});
  EXPECT_TRUE(path.at(kSecond) && path.at(2 * kSecond));
  EXPECT_FALSE(path.at(kSecond - 1) || path.at(2 * kSecond + 1));
  EXPECT_FALSE(WheelPath({}, {}).at(0));
}

TEST(WheelPath, TheLagIsThatOfTheWheels) {
  DriveCorrection late = kPathWheels;
  late.lag = 0.25;
  const WheelPath path(some_samples(), kPathWheels), lagging(some_samples(), late);
  for (Time t = kSecond; t < 3 * kSecond; t += 37 * kMs)
    EXPECT_EQ(lagging.at(t - 250 * kMs)->pose, path.at(t)->pose);
  EXPECT_FALSE(lagging.at(kSecond - 251 * kMs));
}

// A stamp that runs back is taken for the latest so far, and no step is lost.
TEST(WheelPath, StampsThatRunBackLoseNoStep) {
  auto samples = some_samples(10);
  samples[5].time = samples[3].time;
  const WheelPath path(samples, {}), right(some_samples(10), {});
  for (const std::size_t i : {4U, 6U, 9U}) {
    const Time t = samples[i].time;
    expect_pose_near(path.at(t)->pose, right.at(t)->pose, 1e-14);
  }
  expect_pose_near(path.at(samples[4].time + 1)->pose, right.at(kSecond + 500 * kMs)->pose, 1e-6);
}

TEST(WheelPath, SteeringIsCorrectedBeforeItBendsTheWay) {
  const double wheelbase = 2.8;
  const DriveCorrection c{.scale = 1.02, .turn_scale = 0.97, .steering_offset = 0.05};
  const std::vector<WheelMotion> raw{{0, 3, 0.2}, {kSecond, -1, -0.1}, {3 * kSecond, 0, 0}};
  const WheelPath path(wheel_samples(raw, wheelbase), c, wheelbase);
  const Pose2 expected = exp(Vec3(1.02 * 3, 0, 0.97 * 3 * std::tan(0.25) / wheelbase)) *
                         exp(Vec3(1.02 * -2, 0, 0.97 * -2 * std::tan(-0.05) / wheelbase));
  expect_pose_near(path.at(3 * kSecond)->pose, expected, 1e-14);
  EXPECT_NEAR(path.at(3 * kSecond)->way, 1.02 * 5, 1e-14);
  // The same as the path of the mended records.
  std::vector<WheelMotion> mended;
  for (const WheelMotion& m : raw) mended.push_back(corrected(c, m));
  const WheelPath twin(wheel_samples(mended, wheelbase), {});
  expect_pose_near(twin.at(2 * kSecond)->pose, path.at(2 * kSecond)->pose, 1e-14);
}

TEST(WheelSamples, OfOdometryAreItsSteps) {
  const auto samples = some_samples();
  std::vector<Odometry> odometry;
  Pose2 pose{4, 5, -2};
  for (const WheelSample& s : samples) {
    pose = pose * exp(s.twist);
    odometry.push_back({s.time, pose, {}, {}});
  }
  const auto found = wheel_samples(odometry, false);
  ASSERT_EQ(found.size(), samples.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].time, samples[i].time);
    EXPECT_NEAR((found[i].twist - samples[i].twist).norm(), 0, 1e-13);
    EXPECT_FALSE(found[i].jump);
  }
}

TEST(WheelSamples, BackingAndJumps) {
  const std::vector<Odometry> odometry{{0, {}, {}, {}},
                                       {kSecond, {1, 0, 0}, -1.0, {}},
                                       {2 * kSecond, {900, 0, 0}, -1.0, {}},
                                       {3 * kSecond, {901, 0, 0}, 1.0, {}}};
  const auto asis = wheel_samples(odometry, false), turned = wheel_samples(odometry, true);
  EXPECT_EQ(asis[1].twist.x(), 1);
  EXPECT_EQ(turned[1].twist.x(), -1);
  for (const auto& found : {asis, turned}) {
    EXPECT_TRUE(!found[1].jump && found[2].jump && !found[3].jump);
    EXPECT_EQ(found[2].twist, Vec3::Zero());
    EXPECT_EQ(found[3].twist.x(), 1);
  }
}

// Seen steps.

// Where a laser at nominal * D sees the robot, at 5 Hz and between the samples.
std::vector<LaserPose> exact_poses(const WheelPath& path, const Pose2& D) {
  std::vector<LaserPose> out;
  for (Time t = 500 * kMs; t < 5 * kSecond; t += 170 * kMs)
    if (const auto at = path.at(t)) out.push_back({t, Pose2{7, 8, 2} * at->pose * D});
  return out;
}

TEST(SeenSteps, ExactDataLeaveNoErrorWhereverTheLaserIs) {
  DriveCorrection c = kPathWheels;
  c.lag = 0.13;
  const auto samples = some_samples();
  const WheelPath path(samples, c);
  for (const Pose2& D : {Pose2{}, Pose2{0.3, -0.2, 0.4}, Pose2{-1, 0, 3.1}}) {
    const auto laser = exact_poses(path, D);
    const auto steps = seen_steps(laser, samples, c, D, 0);
    ASSERT_EQ(steps.size(), laser.size() - 1);
    ASSERT_GT(steps.size(), 10U);
    double way = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      EXPECT_LT(steps[i].error().norm(), 1e-13);
      EXPECT_EQ(steps[i].end, i + 1);
      EXPECT_NEAR(steps[i].seconds, 0.17, 1e-12);
      EXPECT_FALSE(steps[i].broken);
      way += steps[i].way;
      if (i == 0) continue;
      EXPECT_EQ(steps[i].velocity_before, steps[i - 1].velocity_after);
      EXPECT_EQ(steps[i].split_way_before, steps[i - 1].split_way_after);
      EXPECT_EQ(steps[i].doubt_before, steps[i - 1].doubt_after);
    }
    EXPECT_NEAR(way, path.at(laser.back().time)->way - path.at(laser.front().time)->way, 1e-12);
  }
}

TEST(SeenSteps, WhereTheWheelsDoNotTellIsNone) {
  const auto samples = some_samples(11);  // 1 s ... 2 s
  std::vector<LaserPose> laser;
  for (int i = 0; i < 30; ++i) laser.push_back({i * 100 * kMs + 50 * kMs, {}});
  const auto steps = seen_steps(laser, samples, {}, {}, 0);
  ASSERT_EQ(steps.size(), 9U);
  EXPECT_EQ(steps.front().end, 11U);
  EXPECT_EQ(steps.back().end, 19U);
}

TEST(SeenSteps, TheVelocityIsThatOfBothSides) {
  std::vector<WheelSample> samples;
  std::vector<LaserPose> laser;
  for (int i = 0; i < 20; ++i) {
    samples.push_back({i * 100 * kMs, {i == 0 ? 0 : 0.05, 0, 0}, 0, false});
    laser.push_back({i * 100 * kMs, {0.05 * i, 0, 0}});
  }
  for (const SeenStep& s : seen_steps(laser, samples, {}, {}, 0)) {
    EXPECT_NEAR((s.velocity_before - Vec3(0.5, 0, 0)).norm(), 0, 1e-13);
    EXPECT_NEAR((s.velocity_after - Vec3(0.5, 0, 0)).norm(), 0, 1e-13);
  }
}

// Every step that touches the lost motion is broken, also one that begins within it.
TEST(SeenSteps, AJumpBreaksTheStepsThatTouchIt) {
  auto samples = some_samples(11);
  samples[5].jump = true;  // from 1.4 s to 1.5 s
  samples[5].twist.setZero();
  std::vector<LaserPose> laser;
  for (int t = 1050; t < 2000; t += 40) laser.push_back({t * kMs, {}});
  for (const SeenStep& s : seen_steps(laser, samples, {}, {}, 0)) {
    const Time from = laser[s.end - 1].time, to = laser[s.end].time;
    EXPECT_EQ(s.broken, from < 1500 * kMs && to > 1400 * kMs) << from << ' ' << to;
  }
}

}  // namespace
}  // namespace majak::motion
