// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/umbmark.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

constexpr double kSide = 4, kTrack = 0.4;

// The odometry drives the square exactly; where the robot truly ends.
SquareRun square(bool left, double turn_scale, double turn_per_metre, RandomStream* noise) {
  Pose2 truth;
  const double sense = left ? 1 : -1;
  const auto slip = [&](double sigma) { return noise ? sigma * noise->normal() : 0.0; };
  for (int corner = 0; corner < 4; ++corner) {
    truth = truth * exp({kSide, 0, turn_per_metre * kSide + slip(0.002)});
    truth = truth * exp({0, 0, sense * turn_scale * kPi / 2 + slip(0.002)});
  }
  return {left, truth.x, truth.y};
}

TEST(Umbmark, CornersAndBendsComeApart) {
  for (const double turn_scale : {0.99, 1.0, 1.005})
    for (const double bend : {-0.003, 0.0, 0.002}) {
      const Umbmark u = umbmark(
          {square(true, turn_scale, bend, nullptr), square(false, turn_scale, bend, nullptr)},
          kSide);
      // First order: errors of the square of the angles, 0.03 rad a corner at most.
      EXPECT_NEAR(u.turn_scale.value, turn_scale, 1e-3);
      EXPECT_NEAR(u.turn_per_metre.value, bend, 2.5e-4);
      EXPECT_EQ(u.correction.turn_scale, u.turn_scale.value);
      EXPECT_EQ(u.correction.turn_per_metre, u.turn_per_metre.value);
    }
}

TEST(Umbmark, RightWheelsGiveNothing) {
  const Umbmark u =
      umbmark({square(true, 1, 0, nullptr), square(false, 1, 0, nullptr)}, kSide, kTrack);
  EXPECT_NEAR(u.turn_scale.value, 1, 1e-15);
  EXPECT_NEAR(u.turn_per_metre.value, 0, 1e-15);
  EXPECT_NEAR(u.wheel_ratio.value, 1, 1e-15);
  EXPECT_NEAR(u.track.value, kTrack, 1e-15);
  EXPECT_NEAR(u.systematic, 0, 1e-14);
}

TEST(Umbmark, TheTrackMakesWheelsOfTheBend) {
  const double right = 1.001, left = 0.999, true_track = 0.404;
  // What the odometry with equal wheels and 0.4 m believes is driven exactly.
  const double turn_scale = kTrack / true_track, bend = (right - left) / true_track;
  const Umbmark u =
      umbmark({square(true, turn_scale, bend, nullptr), square(false, turn_scale, bend, nullptr)},
              kSide, kTrack);
  EXPECT_NEAR(u.wheel_ratio.value, right / left, 2e-4);
  EXPECT_NEAR(u.track.value, true_track, 5e-4);
}

TEST(Umbmark, SigmasAreThoseOfTheScatter) {
  double squared = 0, bend_squared = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    RandomStream noise(seed);
    std::vector<SquareRun> runs;
    for (int i = 0; i < 5; ++i)
      for (const bool left : {true, false}) runs.push_back(square(left, 1, 0, &noise));
    const Umbmark u = umbmark(runs, kSide);
    ASSERT_GT(u.turn_scale.sigma, 0);
    squared += std::pow((u.turn_scale.value - 1) / u.turn_scale.sigma, 2) / 300;
    bend_squared += std::pow(u.turn_per_metre.value / u.turn_per_metre.sigma, 2) / 300;
  }
  // x and y of one run hang together, of which the scatter axis by axis knows nothing.
  EXPECT_NEAR(squared, 1.3, 0.6);
  EXPECT_NEAR(bend_squared, 1.3, 0.6);
}

TEST(Umbmark, BadInput) {
  const SquareRun left = square(true, 1, 0, nullptr);
  EXPECT_THROW(umbmark({left, left}, kSide), Error);
  EXPECT_THROW(umbmark({}, kSide), Error);
  EXPECT_THROW(umbmark({left, square(false, 1, 0, nullptr)}, 0), Error);
}

}  // namespace
}  // namespace majak::motion
