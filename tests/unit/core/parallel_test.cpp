// SPDX-License-Identifier: Apache-2.0
#include "majak/core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "majak/core/random.hpp"

namespace majak {
namespace {

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (const int threads : {-1, 0, 1, 2, 3, 8, 64}) {
    for (const std::size_t n : {0, 1, 2, 3, 1000}) {
      std::vector<std::atomic<int>> visits(n);
      parallel_for({threads}, n, [&](std::size_t i) { ++visits.at(i); });
      for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(visits[i], 1) << threads << " " << i;
    }
  }
}

TEST(ParallelFor, SameBytesForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    std::vector<double> out(5000);
    parallel_for({threads}, out.size(), [&](std::size_t i) {
      RandomStream r(1, 2, i);
      for (int k = 0; k < 10; ++k) out[i] += std::sin(r.normal());
    });
    return out;
  };
  const auto one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(8), one);
}

TEST(ParallelFor, ExceptionsReachTheCaller) {
  for (const int threads : {1, 2, 8}) {
    try {
      parallel_for({threads}, 100, [](std::size_t i) {
        if (i == 37) throw std::runtime_error("at 37");
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
      EXPECT_EQ(e.what(), std::string("at 37"));
    }
    // And the next loop works as if nothing had been.
    std::atomic<int> visits = 0;
    parallel_for({threads}, 100, [&](std::size_t) { ++visits; });
    EXPECT_EQ(visits, 100);
  }
}

TEST(ParallelFor, LoopsInLoops) {
  std::vector<int> sums(20);
  parallel_for({4}, sums.size(), [&](std::size_t i) {
    std::vector<int> inner(30);
    parallel_for({4}, inner.size(), [&](std::size_t k) { inner[k] = static_cast<int>(i + k); });
    for (const int v : inner) sums[i] += v;
  });
  for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_EQ(sums[i], 30 * static_cast<int>(i) + 435);
}

}  // namespace
}  // namespace majak
