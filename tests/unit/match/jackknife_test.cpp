// SPDX-License-Identifier: Apache-2.0
#include "majak/match/jackknife.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "majak/core/random.hpp"

namespace majak::match {
namespace {

// Walls of a room of 6 x 4 m, each with a surfel every 5 cm.
map::SurfelMap walls() {
  map::SurfelMap map;
  for (float x = -3; x <= 3; x += 0.05F) map.add(x, -2, 0, 1), map.add(x, 2, 0, -1);
  for (float y = -2; y <= 2; y += 0.05F) map.add(-3, y, 1, 0), map.add(3, y, -1, 0);
  return map;
}

/// The room seen from its middle, ranges off by sigma, `together` beams by the same.
ScanPoints seen(double sigma, std::size_t together, std::uint64_t seed) {
  ScanPoints points;
  double error = 0;
  for (std::size_t i = 0; i < 360; ++i) {
    RandomStream random(seed, i);
    if (i % together == 0) error = sigma * random.normal();
    const double angle = radians(static_cast<double>(i)), c = std::cos(angle), s = std::sin(angle);
    const double range = std::min(3 / std::abs(c), 2 / std::abs(s)) + error;
    points.x.push_back(static_cast<float>(range * c));
    points.y.push_back(static_cast<float>(range * s));
  }
  return points;
}

struct Shares {
  double told = 0, errors = 0;  // mean of tr(covariance), of the squared error: place, m^2
};

Shares over_many(std::size_t together) {
  const map::SurfelMap map = walls();
  constexpr int kRuns = 200;
  Shares mean;
  for (int run = 0; run < kRuns; ++run) {
    const ScanPoints points = seen(0.01, together, static_cast<std::uint64_t>(run));
    const Match m = align(points, map, {}, {});
    const Jackknife j = jackknife(points, map, m.T_map_robot, Mat3::Zero(), {}, {});
    mean.told += (j.covariance(0, 0) + j.covariance(1, 1)) / kRuns;
    mean.errors += m.T_map_robot.translation().squaredNorm() / kRuns;
  }
  return mean;
}

TEST(Jackknife, TellsTheErrorOfBeamsThatErrAlone) {
  const Shares s = over_many(1);
  // Leaving out whole blocks is cautious: by 1/(1 - leverage), here of an eighth.
  EXPECT_GT(s.told / s.errors, 1.0);
  EXPECT_LT(s.told / s.errors, 1.7);
}

TEST(Jackknife, TellsTheErrorOfNeighboursThatErrTogether) {
  const Shares alone = over_many(1), together = over_many(9);
  EXPECT_GT(together.errors, 4 * alone.errors) << "nine beams that err as one";
  EXPECT_GT(together.told / together.errors, 0.9);
  EXPECT_LT(together.told / together.errors, 1.7);
}

TEST(Jackknife, ClaimsWhatMatchingClaims) {
  const map::SurfelMap map = walls();
  const ScanPoints points = seen(0.01, 1, 3);
  AlignOptions options;
  options.tolerance = 1e-6, options.max_iterations = 40;
  const Match m = align(points, map, {}, options);
  const Jackknife j = jackknife(points, map, m.T_map_robot, Mat3::Zero(), options, {});
  EXPECT_LT((j.claimed * m.information - Mat3::Identity()).norm(), 1e-2);
}

TEST(Jackknife, AStepOfTheLasersErrorIsSeenAndWhiteNoiseIsNone) {
  const map::SurfelMap map = walls();
  const auto variance = [&](double step) {
    double steps = 0, weight = 0;
    for (std::uint64_t run = 0; run < 40; ++run) {
      ScanPoints points = seen(0.003, 1, run);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const float range = std::hypot(points.x[i], points.y[i]);
        const float longer = 1 + (range > 2.5F ? static_cast<float>(step) / range : 0);
        points.x[i] *= longer, points.y[i] *= longer;
      }
      const Jackknife j =
          jackknife(points, map, align(points, map, {}, {}).T_map_robot, Mat3::Zero(), {}, {});
      steps += j.steps, weight += j.steps_weight;
    }
    return steps / weight;
  };
  EXPECT_LT(std::abs(variance(0)), 1e-6);
  EXPECT_GT(variance(0.02), 5e-5);
}

TEST(Jackknife, WithoutAPairNothingIsSaid) {
  const Jackknife j = jackknife(seen(0, 1, 1), map::SurfelMap(), {}, Mat3::Identity(), {}, {});
  EXPECT_TRUE(j.covariance.isZero(0));
  EXPECT_TRUE(j.claimed.isZero(0));
}

}  // namespace
}  // namespace majak::match
