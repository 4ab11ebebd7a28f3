// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/pose_bins.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <tuple>

#include "majak/core/random.hpp"

namespace majak::localize {
namespace {

// The slow twin is a tree keyed by cell and by the angle's class.
TEST(PoseBins, CountAsATreeDoes) {
  PoseBins bins(0.5, 3000);
  for (int round = 0; round < 3; ++round) {
    RandomStream random(static_cast<std::uint64_t>(round));
    std::map<std::tuple<int, int, int>, double> twin;
    bins.clear();
    EXPECT_EQ(bins.count(), 0U);
    for (int i = 0; i < 3000; ++i) {
      const auto x = static_cast<float>(random.uniform(-20, 20)),
                 y = static_cast<float>(random.uniform(-3, 3));
      const double angle = random.uniform(-3.14, 3.14), w = random.uniform();
      const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
      const float diamond = s / (std::abs(s) + std::abs(c));
      const int turn = static_cast<int>((c < 0 ? 2 - diamond : diamond) * 10 + 10);
      double& bin = twin[std::tuple(static_cast<int>(std::floor(x / 0.5F)),
                                    static_cast<int>(std::floor(y / 0.5F)), turn)];
      bin += w;
      EXPECT_NEAR(bins.add(x, y, c, s, w), bin, 1e-12);
    }
    EXPECT_EQ(bins.count(), twin.size());
  }
}

TEST(PoseBins, HeadingsRiseAllTheWayRound) {
  PoseBins bins(1, 1000);
  int last = 0, widest = 0, begin = 0;
  for (int k = 0; k < 3600; ++k) {  // from -90 degrees on
    const double angle = -M_PI / 2 + (k + 0.5) * M_PI / 1800;
    bins.add(0.5, 0.5, static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 1);
    if (const int now = static_cast<int>(bins.count()); now > last) {
      EXPECT_EQ(now, last + 1);
      widest = std::max(widest, k - begin);
      begin = k, last = now;
    }
  }
  EXPECT_EQ(last, 40);
  EXPECT_LE(widest, 115);  // tenths of a degree
}

}  // namespace
}  // namespace majak::localize
