// SPDX-License-Identifier: Apache-2.0
#include "majak/core/chi_square.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace majak {
namespace {

/// Slow twin: Simpson's rule over the density, with x = u^2 so that it is smooth at zero.
double integrated_cdf(double x, double dof) {
  const double log_norm = std::log(2.0) - dof / 2 * std::log(2.0) - std::lgamma(dof / 2);
  const auto density = [&](double u) {
    return u <= 0 ? (dof == 1 ? std::exp(log_norm) : 0.0)
                  : std::exp(log_norm + (dof - 1) * std::log(u) - u * u / 2);
  };
  const int n = 20000;
  const double step = std::sqrt(x) / n;
  double sum = density(0) + density(std::sqrt(x));
  for (int i = 1; i < n; ++i) sum += (i % 2 == 1 ? 4 : 2) * density(i * step);
  return sum * step / 3;
}

TEST(ChiSquare, AgreesWithNumericIntegration) {
  for (const double dof : {1.0, 2.0, 3.0, 6.0, 30.0, 150.0, 900.0}) {
    for (const double share : {0.1, 0.7, 0.95, 1.0, 1.1, 1.6}) {
      const double x = share * dof;
      EXPECT_NEAR(chi_square_cdf(x, dof), integrated_cdf(x, dof), 1e-10) << x << ' ' << dof;
    }
  }
}

TEST(ChiSquare, OfTwoDegreesIsExponential) {
  for (const double x : {1e-6, 0.1, 1.0, 5.0, 40.0}) {
    EXPECT_NEAR(chi_square_cdf(x, 2), -std::expm1(-x / 2), 1e-14);
  }
  for (const double p : {1e-6, 0.025, 0.5, 0.975, 1 - 1e-9}) {
    EXPECT_NEAR(chi_square_quantile(p, 2), -2 * std::log1p(-p), 1e-8 * (1 - 2 * std::log1p(-p)));
  }
}

TEST(ChiSquare, QuantileInvertsTheDistribution) {
  for (const double dof : {1.0, 3.0, 50.0, 150.0, 30000.0}) {
    for (const double p : {0.001, 0.025, 0.5, 0.975, 0.999}) {
      EXPECT_NEAR(chi_square_cdf(chi_square_quantile(p, dof), dof), p, 1e-11) << dof << ' ' << p;
    }
  }
}

TEST(ChiSquare, HasTheValuesOfThePrintedTables) {
  EXPECT_NEAR(chi_square_quantile(0.95, 3), 7.815, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.975, 3), 9.348, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.025, 3), 0.216, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.975, 100), 129.561, 5e-4);
}

}  // namespace
}  // namespace majak
