// SPDX-License-Identifier: Apache-2.0
#include "majak/core/chi_square.hpp"

#include <algorithm>
#include <cmath>

#include "majak/core/angle.hpp"

namespace majak {
namespace {

/// ln of x^a e^-x / gamma(a): the common factor of both expansions below. std::lgamma writes a
/// global sign, so Lanczos' formula (g = 7, 9 terms; relative error 1e-15) stands here instead.
double log_prefactor(double a, double x) {
  constexpr double kTerms[] = {0.99999999999980993,  676.5203681218851,     -1259.1392167224028,
                               771.32342877765313,   -176.61502916214059,   12.507343278686905,
                               -0.13857109526572012, 9.9843695780195716e-6, 1.5056327351493116e-7};
  double sum = kTerms[0];
  for (int i = 1; i < 9; ++i) sum += kTerms[i] / (a - 1 + i);
  const double t = a + 6.5;
  const double log_gamma = 0.5 * std::log(2 * kPi) + (a - 0.5) * std::log(t) - t + std::log(sum);
  return a * std::log(x) - x - log_gamma;
}

/// Lower regularized incomplete gamma P(a, x) by its series (Abramowitz and Stegun 6.5.29).
double gamma_series(double a, double x) {
  double term = 1 / a, sum = term;
  for (int n = 1; n < 100000 && std::abs(term) > std::abs(sum) * 1e-17; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * std::exp(log_prefactor(a, x));
}

/// Upper Q(a, x) by its continued fraction (6.5.31), evaluated by Lentz' method.
double gamma_fraction(double a, double x) {
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
  for (int n = 1; n < 100000; ++n) {
    const double factor = -n * (n - a);
    b += 2;
    d = factor * d + b;
    c = b + factor / c;
    if (std::abs(d) < kTiny) d = kTiny;
    if (std::abs(c) < kTiny) c = kTiny;
    d = 1 / d;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return h * std::exp(log_prefactor(a, x));
}

/// Standard normal quantile to a few per mille (Abramowitz and Stegun 26.2.23): a start only.
double rough_normal_quantile(double p) {
  const double tail = std::min(p, 1 - p);
  const double t = std::sqrt(-2 * std::log(tail));
  const double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                           (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  return p < 0.5 ? -z : z;
}

}  // namespace

double chi_square_cdf(double x, double dof) {
  if (!(x > 0)) return 0;
  const double a = dof / 2, half = x / 2;
  return half < a + 1 ? gamma_series(a, half) : 1 - gamma_fraction(a, half);
}

double chi_square_quantile(double p, double dof) {
  // Wilson and Hilferty 1931 start the search; bisection guards Newton's steps.
  const double v = 2 / (9 * dof);
  const double cube = 1 - v + rough_normal_quantile(p) * std::sqrt(v);
  double x = std::max(dof * cube * cube * cube, 1e-10);
  double low = 0, high = std::max(2 * x, dof);
  while (chi_square_cdf(high, dof) < p) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double error = chi_square_cdf(x, dof) - p;
    (error < 0 ? low : high) = x;
    const double density = std::exp(log_prefactor(dof / 2, x / 2)) / x;
    double next = x - error / density;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - x) <= 1e-15 * x) break;
    x = next;
  }
  return x;
}

}  // namespace majak
