// SPDX-License-Identifier: Apache-2.0
// Robust kernels: cost(s) and weight(s) = cost'(s) of a squared error s (MATH 2.5).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace majak::graph {

/// How edges marked robust are judged. Measured in docs/MATH.md, table of 2.5.
enum class Robust {
  none,           ///< they are believed
  cauchy,         ///< cost grows with the logarithm: softens, never rejects
  dcs,            ///< dynamic covariance scaling (Agarwal et al. 2013): far errors have no pull
  dcs_truncated,  ///< the same, then a verdict: weights end as 0 or 1
  gnc_truncated,  ///< graduated non-convexity, truncated least squares (Yang et al. 2020)
};

struct Kernel {
  enum Kind { quadratic, cauchy, dcs, truncated };
  Kind kind = quadratic;
  double bound = 1;  ///< squared error at which an edge starts to be doubted
  /// Graduation of `truncated`: convex at 0, min(s, bound) at infinity.
  double mu = std::numeric_limits<double>::infinity();

  double cost(double s) const {
    switch (kind) {
      case quadratic:
        return s;
      case cauchy:
        return bound * std::log1p(s / bound);
      case dcs:
        return s <= bound ? s : bound * (3 * s - bound) / (s + bound);
      case truncated:
        if (s <= low()) return s;
        if (s >= high()) return bound;
        return 2 * std::sqrt(bound * s * mu * (mu + 1)) - mu * (bound + s);
    }
    return s;
  }

  double weight(double s) const {
    const double ratio = 2 * bound / (bound + s);
    switch (kind) {
      case quadratic:
        return 1;
      case cauchy:
        return bound / (bound + s);
      case dcs:
        return s <= bound ? 1 : ratio * ratio;
      case truncated:
        if (s <= low()) return 1;
        if (s >= high()) return 0;
        return std::clamp(std::sqrt(bound * mu * (mu + 1) / s) - mu, 0.0, 1.0);
    }
    return 1;
  }

 private:
  double low() const { return bound / (1 + 1 / mu); }
  double high() const { return bound * (1 + 1 / mu); }
};

}  // namespace majak::graph
