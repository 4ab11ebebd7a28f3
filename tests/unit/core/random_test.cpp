// SPDX-License-Identifier: Apache-2.0
#include "majak/core/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

namespace majak {
namespace {

TEST(RandomStream, FirstNumbersAreTheSameOnEveryMachine) {
  // SplitMix64 by its published constants, apart from the code under test.
  const auto mix = [](std::uint64_t z) {
    z += 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  };
  EXPECT_EQ(mix(0), 0xe220a8397b1dcdafULL);  // first output of the reference for seed 0
  std::uint64_t state = mix(mix(mix(5) ^ 6) ^ 7);
  RandomStream keyed(5, 6, 7);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(keyed.bits(), mix(state += 0x9e3779b97f4a7c15ULL));
  EXPECT_EQ(RandomStream(1).bits(), RandomStream(1, 0, 0).bits());
}

TEST(RandomStream, KeyedStreamsDoNotCareWhoAsksFirst) {
  std::array<std::vector<double>, 20> forward, backward;
  for (std::size_t i = 0; i < 20; ++i) {
    RandomStream r(42, 3, i);
    for (int k = 0; k < 10; ++k) forward[i].push_back(r.normal());
  }
  std::vector<RandomStream> streams;
  for (std::size_t i = 0; i < 20; ++i) streams.emplace_back(42, 3, i);
  for (int k = 0; k < 10; ++k)
    for (std::size_t i = 20; i-- > 0;) backward[i].push_back(streams[i].normal());
  EXPECT_EQ(forward, backward);
}

TEST(RandomStream, EveryPartOfTheKeyCounts) {
  std::set<std::uint64_t> first;
  for (std::uint64_t seed = 0; seed < 12; ++seed)
    for (std::uint64_t step = 0; step < 12; ++step)
      for (std::uint64_t index = 0; index < 12; ++index)
        first.insert(RandomStream(seed, step, index).bits());
  EXPECT_EQ(first.size(), 12U * 12U * 12U);
}

TEST(RandomStream, UniformFillsItsInterval) {
  RandomStream r(7);
  constexpr int kDraws = 200000;
  double sum = 0, squares = 0;
  std::array<int, 20> bins{};
  for (int i = 0; i < kDraws; ++i) {
    const double u = r.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u, squares += u * u;
    ++bins[static_cast<std::size_t>(20 * u)];
  }
  // Four standard deviations of the mean, of the mean square, and of chi2 with 19 degrees.
  EXPECT_NEAR(sum / kDraws, 0.5, 4 * std::sqrt(1 / 12.0 / kDraws));
  EXPECT_NEAR(squares / kDraws, 1 / 3.0, 4 * std::sqrt(4 / 45.0 / kDraws));
  double chi2 = 0;
  for (const int n : bins) chi2 += std::pow(n - kDraws / 20.0, 2) / (kDraws / 20.0);
  EXPECT_LT(chi2, 19 + 4 * std::sqrt(2 * 19.0));
  EXPECT_GT(chi2, 19 - 3 * std::sqrt(2 * 19.0));  // too even is not random either
  for (int i = 0; i < 1000; ++i) {
    const double u = r.uniform(-3, -1);
    EXPECT_GE(u, -3);
    EXPECT_LT(u, -1);
  }
}

TEST(RandomStream, NormalHasTheMomentsOfANormal) {
  RandomStream r(8);
  constexpr int kDraws = 200000;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = r.normal();
    ASSERT_TRUE(std::isfinite(z));
    m1 += z, m2 += z * z, m3 += z * z * z, m4 += z * z * z * z;
    beyond_two += std::abs(z) > 2;
  }
  EXPECT_NEAR(m1 / kDraws, 0, 4 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(m2 / kDraws, 1, 4 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(m3 / kDraws, 0, 4 * std::sqrt(15.0 / kDraws));
  EXPECT_NEAR(m4 / kDraws, 3, 4 * std::sqrt(96.0 / kDraws));
  EXPECT_NEAR(beyond_two / double{kDraws}, 0.0455, 0.002);
}

TEST(RandomStream, NeighbouringStreamsAreNotCorrelated) {
  double product = 0;
  constexpr int kStreams = 50000;
  for (std::uint64_t i = 0; i < kStreams; ++i)
    product += RandomStream(1, 2, i).normal() * RandomStream(1, 2, i + 1).normal();
  EXPECT_NEAR(product / kStreams, 0, 4 / std::sqrt(kStreams));
}

TEST(RandomStream, BelowCountsEveryValue) {
  RandomStream r(9);
  std::array<int, 7> counts{};
  for (int i = 0; i < 70000; ++i) ++counts.at(r.below(7));
  for (const int n : counts) EXPECT_NEAR(n, 10000, 400);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(r.below(1), 0U);
}

}  // namespace
}  // namespace majak
