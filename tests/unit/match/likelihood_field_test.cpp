// SPDX-License-Identifier: Apache-2.0
#include "majak/match/likelihood_field.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "majak/core/random.hpp"
#include "tests/support/ascii_map.hpp"

namespace majak::match {
namespace {

const map::KnownMap& room() {
  static const map::KnownMap map = fixture::ascii_map({"##########",  //
                                                       "#........#",  //
                                                       "#...##...#",  //
                                                       "#........#",  //
                                                       "##########"},
                                                      0.2);
  return map;
}

Beams some_beams(std::size_t n, std::uint64_t seed) {
  RandomStream random(seed);
  Beams b;
  for (std::size_t i = 0; i < n; ++i) {
    b.x.push_back(static_cast<float>(random.uniform(-3, 3)));
    b.y.push_back(static_cast<float>(random.uniform(-3, 3)));
  }
  b.returns = n;
  return b;
}

TEST(LikelihoodField, IsTheMixtureOfTheBook) {
  const map::DistanceField distances(room());
  const LikelihoodFieldOptions o{.sigma = 0.3, .hit = 0.7, .random = 0.3, .range = 5};
  const LikelihoodField field(room(), distances, o);
  const double peak = 0.7 / (0.3 * std::sqrt(2 * kPi)), floor = 0.3 / 5;
  for (int iy = 0; iy < room().height; ++iy)
    for (int ix = 0; ix < room().width; ++ix) {
      const double d = distances.at(ix, iy);
      const double p = peak * std::exp(-d * d / (2 * 0.3 * 0.3)) + floor;
      const Vec2 c = room().centre(ix, iy);
      EXPECT_NEAR(
          field.cost(static_cast<float>(c.x()), static_cast<float>(c.y())) * LikelihoodField::kUnit,
          std::log((peak + floor) / p), 0.51 * LikelihoodField::kUnit);
    }
  EXPECT_EQ(field.cost(-100, 3), field.cost_at_most());
  EXPECT_NEAR(field.cost_at_most() * LikelihoodField::kUnit, std::log((peak + floor) / floor),
              0.51 * LikelihoodField::kUnit);
}

// Eight beams at a time, and what is left over, against one look-up a beam.
TEST(LikelihoodField, SumsEqualTheSlowTwin) {
  const LikelihoodField field(room(), map::DistanceField(room()), {.sigma = 0.15});
  RandomStream random(5);
  for (const std::size_t n : {0UL, 1UL, 7UL, 8UL, 9UL, 61UL, 180UL}) {
    const Beams b = some_beams(n, n);
    PoseArrays poses;
    poses.resize(40);
    for (std::size_t i = 0; i < poses.size(); ++i)
      poses.set(i, {random.uniform(-3, 5), random.uniform(-3, 5), random.uniform(-4, 4)});
    std::vector<std::uint32_t> sums(poses.size(), 12345);
    field.costs(b, poses, 2, poses.size(), sums.data());
    EXPECT_EQ(sums[0], 12345U);
    EXPECT_EQ(sums[1], 12345U);
    for (std::size_t i = 2; i < poses.size(); ++i) {
      std::uint32_t sum = 0;
      for (std::size_t k = 0; k < n; ++k)
        sum += field.cost(poses.x[i] + poses.cos[i] * b.x[k] - poses.sin[i] * b.y[k],
                          poses.y[i] + poses.sin[i] * b.x[k] + poses.cos[i] * b.y[k]);
      // A point on the border of two cells may fall to either.
      EXPECT_NEAR(sums[i], sum, n > 100 ? 60 : 0) << n;
    }
  }
}

TEST(LikelihoodField, SlackBoundsAllPlacesThatNear) {
  const map::DistanceField distances(room());
  const LikelihoodField exact(room(), distances, {.sigma = 0.15});
  const LikelihoodField bound(room(), distances, {.sigma = 0.15, .slack = 0.4});
  for (int iy = 0; iy < room().height; ++iy)
    for (int ix = 0; ix < room().width; ++ix) {
      const Vec2 a = room().centre(ix, iy);
      const auto least = bound.cost(static_cast<float>(a.x()), static_cast<float>(a.y()));
      for (int jy = 0; jy < room().height; ++jy)
        for (int jx = 0; jx < room().width; ++jx) {
          const Vec2 b = room().centre(jx, jy);
          if ((a - b).norm() > 0.4 - 1e-9) continue;
          EXPECT_LE(least, exact.cost(static_cast<float>(b.x()), static_cast<float>(b.y())));
        }
    }
}

TEST(LikelihoodField, TheTruePoseFitsBest) {
  const LikelihoodField field(room(), map::DistanceField(room()), {.sigma = 0.2});
  Beams b;  // the left wall, and two returns from the upper one
  for (const auto& [x, y] : {std::pair(-0.4F, 0.0F), std::pair(0.0F, 0.4F), std::pair(0.4F, 0.4F)})
    b.x.push_back(x), b.y.push_back(y);
  b.returns = b.x.size();
  PoseArrays poses;
  poses.resize(3);
  poses.set(0, {0.5, 0.5, 0});
  poses.set(1, {1.1, 0.5, 0});
  poses.set(2, {0.5, 0.5, kPi / 4});
  std::vector<std::uint32_t> sums(3);
  field.costs(b, poses, 0, 3, sums.data());
  EXPECT_EQ(sums[0], 0U);
  EXPECT_GT(sums[1], 0U);
  EXPECT_GT(sums[2], 0U);
}

}  // namespace
}  // namespace majak::match
