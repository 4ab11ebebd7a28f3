// SPDX-License-Identifier: Apache-2.0
#include "majak/core/normal_table.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "majak/core/chi_square.hpp"

namespace majak {
namespace {

double below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

// Forty classes of equal probability, from the body to the tails.
TEST(NormalTable, IsNormalByChiSquare) {
  constexpr int kDraws = 400000, kClasses = 40;
  const NormalTable normal;
  std::vector<int> count(kClasses);
  RandomStream stream(3);
  for (int i = 0; i < kDraws; ++i) {
    const int c = static_cast<int>(below(normal(stream)) * kClasses);
    ++count[std::min(c, kClasses - 1)];
  }
  double chi2 = 0;
  const double expected = double(kDraws) / kClasses;
  for (const int c : count) chi2 += (c - expected) * (c - expected) / expected;
  EXPECT_LT(chi2, chi_square_quantile(0.999, kClasses - 1));
}

TEST(NormalTable, MomentsAndTails) {
  constexpr int kDraws = 1000000;
  const NormalTable normal;
  double m1 = 0, m2 = 0, m4 = 0;
  int beyond3 = 0, beyond4 = 0;
  for (int i = 0; i < kDraws; ++i) {
    RandomStream stream(7, 1, i);  // a stream a number, as particles have them
    const double z = normal(stream);
    m1 += z, m2 += z * z, m4 += z * z * z * z;
    beyond3 += std::abs(z) > 3, beyond4 += std::abs(z) > 4;
  }
  EXPECT_NEAR(m1 / kDraws, 0, 0.004);
  EXPECT_NEAR(m2 / kDraws, 1, 0.006);
  EXPECT_NEAR(m4 / kDraws, 3, 0.04);
  EXPECT_NEAR(beyond3, 2 * below(-3) * kDraws, 4 * std::sqrt(2700.0));
  EXPECT_NEAR(beyond4, 2 * below(-4) * kDraws, 4 * std::sqrt(63.0));
}

}  // namespace
}  // namespace majak
