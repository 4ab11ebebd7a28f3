// SPDX-License-Identifier: Apache-2.0
#include "majak/match/beam_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "majak/core/random.hpp"
#include "tests/support/ascii_map.hpp"

namespace majak::match {
namespace {

constexpr double kReach = 20, kNothing = std::numeric_limits<double>::infinity();

// All returns and the missing ones together have probability 1, wherever the wall is.
TEST(BeamModel, ProbabilitiesSumToOne) {
  const BeamModel model{
      .hit = 0.6, .brief = 0.2, .none = 0.05, .random = 0.15, .sigma = 0.2, .rate = 0.7};
  for (const double expected : {0.05, 0.5, 3.0, 12.0, 19.9}) {
    double sum = probability(model, {kNothing, expected}, kReach);
    constexpr double kStep = 1e-3;
    for (double z = kStep / 2; z < kReach; z += kStep)
      sum += kStep * probability(model, {z, expected}, kReach);
    EXPECT_NEAR(sum, 1, 2e-4) << expected;
  }
  EXPECT_NEAR(probability(model, {kNothing, kNothing}, kReach), 0.65, 1e-15);
}

double exponential(RandomStream& random, double rate, double way) {
  return -std::log1p(random.uniform() * std::expm1(-rate * way)) / rate;
}

std::vector<BeamPair> drawn(const BeamModel& m, std::size_t n, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<BeamPair> pairs;
  while (pairs.size() < n) {
    const double expected = random.uniform() < 0.1 ? kNothing : random.uniform(1, 15);
    const double cause = random.uniform();
    double z = kNothing;
    if (cause < m.hit)
      z = expected + m.sigma * random.normal();
    else if (cause < m.hit + m.brief)
      z = exponential(random, m.rate, std::min(expected, kReach));
    else if (cause < m.hit + m.brief + m.random)
      z = random.uniform(0, kReach);
    pairs.push_back({z, expected});
  }
  return pairs;
}

TEST(BeamModel, KnownParametersAreGivenBack) {
  for (const BeamModel& truth :
       {BeamModel{
            .hit = 0.7, .brief = 0.15, .none = 0.05, .random = 0.1, .sigma = 0.05, .rate = 0.8},
        BeamModel{
            .hit = 0.5, .brief = 0.3, .none = 0.1, .random = 0.1, .sigma = 0.2, .rate = 0.2}}) {
    const BeamModel m = learn_beam_model(drawn(truth, 15000, 3), kReach, {}, 60);
    EXPECT_NEAR(m.hit, truth.hit, 0.01);
    EXPECT_NEAR(m.brief, truth.brief, 0.015);
    EXPECT_NEAR(m.none, truth.none, 0.005);
    EXPECT_NEAR(m.random, truth.random, 0.015);
    EXPECT_NEAR(m.sigma, truth.sigma, 0.02 * truth.sigma);
    EXPECT_NEAR(m.rate, truth.rate, 0.12 * truth.rate);
  }
}

// Expectation maximization never makes the data less likely.
TEST(BeamModel, LikelihoodRisesRoundByRound) {
  const auto pairs = drawn({}, 3000, 9);
  BeamModel m{.hit = 0.25, .brief = 0.25, .none = 0.25, .random = 0.25, .sigma = 1, .rate = 3};
  double last = -1e300;
  for (int round = 0; round < 30; ++round) {
    double sum = 0;
    for (const BeamPair& b : pairs) sum += std::log(probability(m, b, kReach));
    EXPECT_GE(sum, last - 0.5);  // the normal's cut-off ends are left out of sigma
    last = sum;
    m = learn_beam_model(pairs, kReach, m, 1);
  }
}

TEST(BeamModel, TheTruePoseCostsLeast) {
  const auto map = fixture::ascii_map({"##########",  //
                                       "#........#",  //
                                       "#...##...#",  //
                                       "#........#",  //
                                       "##########"},
                                      0.4);
  const map::DistanceField distances(map);
  const Pose2 truth(0.9, 0.9, 0.3);
  Scan scan;
  scan.start_angle = -kPi, scan.angle_step = radians(4), scan.max_range = 20;
  for (std::size_t i = 0; i < 90; ++i) {
    const double angle = scan.angle(i) + truth.theta;
    scan.ranges.push_back(static_cast<float>(
        distances.cast(truth.translation(), {std::cos(angle), std::sin(angle)}, 19)));
  }
  const Beams seen = beams(scan);
  EXPECT_EQ(cost({}, seen, distances, truth), 0U);
  RandomStream random(4);
  for (int k = 0; k < 50; ++k)
    EXPECT_GT(cost({}, seen, distances,
                   truth * Pose2{random.uniform(0.1, 2), random.uniform(0.1, 0.5), 0.2}),
              1000U);
}

TEST(LikelihoodField, KnownParametersAreGivenBack) {
  for (const auto& [hit, sigma] : {std::pair(0.9, 0.03), std::pair(0.6, 0.2)}) {
    RandomStream random(6);
    std::vector<double> distances;
    for (int i = 0; i < 40000; ++i)
      distances.push_back(random.uniform() < hit ? sigma * random.normal() : random.uniform(-5, 5));
    const auto learnt = learn_likelihood_field(distances);
    EXPECT_NEAR(learnt.hit, hit, 0.01);
    EXPECT_NEAR(learnt.random, 1 - hit, 0.01);
    EXPECT_NEAR(learnt.sigma, sigma, 0.02 * sigma);
  }
}

}  // namespace
}  // namespace majak::match
