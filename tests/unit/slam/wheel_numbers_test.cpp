// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/wheel_numbers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/graph/optimize.hpp"
#include "majak/motion/wheel_step.hpp"

namespace majak::slam {
namespace {

using motion::WheelStep;
using Numbers = WheelNumbers::Numbers;

const Numbers kSigma = (Numbers() << 0.03, 0.05, 0.004, 0.3, 0.1, 0.02, 0.05).finished();

/// A car that weaves through 400 m, with a place that is measured all `every` steps; its crab is
/// 0.02 and comes and goes by `swing` rad with 120 m.
struct Drive {
  std::vector<MotionInput::Motion> steps;
  std::vector<double> crab;
  graph::PoseGraph graph;
  std::vector<Pose2> truth;

  Drive(double scale, double swing, std::size_t every, double noise = 0) {
    MotionInput input({0.02, 0.02, 0.003, 0.05}, 2.7, 1);
    RandomStream random(3);
    Pose2 at;
    double way = 0;
    for (std::size_t k = 0; k <= 400; ++k) {
      const Time time = static_cast<Time>(k) * kSecond / 2;
      input.add(WheelMotion{time, 2, 0.2 * std::sin(0.05 * static_cast<double>(k))});
      steps.push_back(input.take(time));
      way += k > 0 ? 1 : 0;
      crab.push_back(0.02 + swing * std::sin(2 * kPi * way / 120));
      MotionInput::Motion::State now{at, steps.back().at};
      now.extra(WheelStep::kScale) = scale, now.extra(MotionInput::kCrab) = crab.back();
      at = steps.back().apply(now).T_map_robot;
      truth.push_back(at);
    }
    graph.poses = truth;
    for (int k = 1; k <= 400; ++k) {
      const Mat3 spread = steps[static_cast<std::size_t>(k)].noise + 1e-9 * Mat3::Identity();
      graph.edges.push_back({k - 1, k, {}, spread.inverse(), false});
    }
    for (std::size_t k = every; k <= 400; k += every)  // as if satellites saw place and heading
      graph.edges.push_back(
          {0, static_cast<int>(k),
           truth[k] * exp(noise * Vec3(random.normal(), random.normal(), 0.1 * random.normal())),
           Vec3(1e4, 1e4, 1e6).asDiagonal(), false});
  }
  void follow(WheelNumbers& wheels) {
    for (std::size_t k = 1; k <= 400; ++k) graph.edges[k - 1].T_from_to = wheels.step(k);
    graph::optimize(graph, {.start = graph::Start::given});
    wheels.learn(graph, graph::Marginals(graph));
  }
  double worst() const {
    double worst = 0;
    for (std::size_t k = 0; k < truth.size(); ++k)
      worst = std::max(worst, (graph.poses[k].translation() - truth[k].translation()).norm());
    return worst;
  }
};

Numbers counted_right() { return MotionInput::counted_right().at.head<MotionInput::kNumbers>(); }

TEST(WheelNumbers, AStepIsThatOfTheNumbers) {
  const Drive drive(1, 0, 50);
  Numbers begin = counted_right();
  begin(WheelStep::kScale) = 1.02, begin(MotionInput::kCrab) = 0.01;
  const WheelNumbers wheels(drive.steps, begin, kSigma, {});
  filter::LandmarkFilter::Extra extra = drive.steps[7].at;
  extra.head<MotionInput::kNumbers>() = begin;
  EXPECT_EQ(wheels.step(7), drive.steps[7].apply({{}, extra}).T_map_robot);
  EXPECT_EQ(wheels.crab(7), 0.01);
}

// Numbers and poses move together: where wheels are trusted much more than places, taking turns
// would need hundreds of rounds.
TEST(WheelNumbers, TwoRoundsAreEnough) {
  Drive drive(1.02, 0, 20);
  for (std::size_t k = 0; k < 400; ++k) drive.graph.edges[k].information *= 1e4;
  WheelNumbers wheels(drive.steps, counted_right(), kSigma, {.crab = 0});
  drive.follow(wheels);
  drive.follow(wheels);
  EXPECT_NEAR(wheels.numbers()(WheelStep::kScale), 1.02, 1e-5);
  EXPECT_NEAR(wheels.numbers()(MotionInput::kCrab), 0.02, 1e-5);
  EXPECT_LT(drive.worst(), 2e-3);
}

// At the optimum no number can be changed for the better, with the poses where they are.
TEST(WheelNumbers, TheCostIsLeastThere) {
  Drive drive(1.01, 0, 40, 0.05);
  WheelNumbers wheels(drive.steps, counted_right(), kSigma, {.crab = 0});
  for (int round = 0; round < 4; ++round) drive.follow(wheels);
  const auto cost = [&](const Numbers& numbers) {
    const WheelNumbers other(drive.steps, numbers, kSigma, {.crab = 0});
    for (std::size_t k = 1; k <= 400; ++k) drive.graph.edges[k - 1].T_from_to = other.step(k);
    const Numbers off = (numbers - counted_right()).cwiseQuotient(kSigma);
    return graph::chi2(drive.graph) + off.squaredNorm();
  };
  for (int i = 0; i < MotionInput::kNumbers; ++i) {
    const double d = 0.1 * wheels.sigmas()(i);
    const Numbers step = d * Numbers::Unit(i);
    const double up = cost(wheels.numbers() + step), down = cost(wheels.numbers() - step);
    const double here = cost(wheels.numbers());
    EXPECT_GT(up, here) << i;
    EXPECT_GT(down, here) << i;
    EXPECT_LT(std::abs(up - down), 0.02 * (up + down - 2 * here)) << i;
  }
}

TEST(WheelNumbers, ACrabThatComesAndGoesIsFollowed) {
  Drive with(1, 0.01, 10), without = with;
  WheelNumbers wandering(with.steps, counted_right(), kSigma, {.crab = 0.01, .knot_way = 30});
  WheelNumbers steady(with.steps, counted_right(), kSigma, {.crab = 0});
  for (int round = 0; round < 4; ++round) with.follow(wandering), without.follow(steady);
  double off = 0;
  for (std::size_t k = 0; k < with.truth.size(); ++k)
    off = std::max(off, std::abs(wandering.crab(k) - with.crab[k]));
  EXPECT_LT(off, 0.006);
  EXPECT_EQ(steady.crab(100), steady.numbers()(MotionInput::kCrab));
  EXPECT_LT(with.worst(), 0.5 * without.worst());
}

// Without anything else to measure them by, the numbers stay what they were thought to be.
TEST(WheelNumbers, WheelsAloneTellNothing) {
  Drive drive(1.02, 0.01, 1000);
  WheelNumbers wheels(drive.steps, counted_right(), kSigma, {});
  drive.follow(wheels);
  EXPECT_LT((wheels.numbers() - counted_right()).cwiseQuotient(kSigma).norm(), 1e-6);
  EXPECT_LT((wheels.sigmas() - kSigma).cwiseQuotient(kSigma).norm(), 1e-6);
}

// A long way has no more knots than a short one, only longer ones.
TEST(WheelNumbers, KnotsMayBeFarApart) {
  Drive drive(1, 0.01, 10);
  WheelNumbers fine(drive.steps, counted_right(), kSigma, {.knot_way = 1e-3});
  drive.follow(fine);
  EXPECT_LT(drive.worst(), 0.05);
}

TEST(WheelNumbers, OneScanIsNoDrive) {
  const std::vector<MotionInput::Motion> steps{MotionInput::counted_right()};
  WheelNumbers wheels(steps, counted_right(), kSigma, {});
  graph::PoseGraph graph;
  graph.poses.push_back({1, 2, 0.5});
  wheels.learn(graph, graph::Marginals(graph));
  EXPECT_EQ(graph.poses[0], (Pose2{1, 2, 0.5}));
}

}  // namespace
}  // namespace majak::slam
