// SPDX-License-Identifier: Apache-2.0
// Robust kernels: cost(s) and weight(s) = cost'(s) of a squared error s (MATH 2.5).
#pragma once

#include <algorithm>
#include <cmath>

namespace majak::graph {

enum class Robust {
  none,                 ///< every edge is believed
  cauchy,               ///< cost grows with the logarithm
  dcs,                  ///< dynamic covariance scaling (Agarwal et al. 2013)
  gnc_geman_mcclure,    ///< graduated non-convexity (Yang et al. 2020)
  gnc_truncated,        ///< the same with truncated least squares: ends with weights 0 or 1
};

struct Kernel {
  Robust kind = Robust::none;
  double bound = 1;  ///< squared error at which an edge starts to be doubted
  double mu = 1;     ///< graduation: convex at infinity (Geman-McClure) or 0 (truncated)

  double cost(double s) const {
    switch (kind) {
      case Robust::none: return s;
      case Robust::cauchy: return bound * std::log1p(s / bound);
      case Robust::dcs: return s <= bound ? s : bound * (3 * s - bound) / (s + bound);
      case Robust::gnc_geman_mcclure: return mu * bound * s / (mu * bound + s);
      case Robust::gnc_truncated:
        if (s <= low()) return s;
        if (s >= high()) return bound;
        return 2 * std::sqrt(bound * s * mu * (mu + 1)) - mu * (bound + s);
    }
    return s;
  }

  double weight(double s) const {
    const auto square = [](double v) { return v * v; };
    switch (kind) {
      case Robust::none: return 1;
      case Robust::cauchy: return bound / (bound + s);
      case Robust::dcs: return s <= bound ? 1 : square(2 * bound / (bound + s));
      case Robust::gnc_geman_mcclure: return square(mu * bound / (mu * bound + s));
      case Robust::gnc_truncated:
        if (s <= low()) return 1;
        if (s >= high()) return 0;
        return std::clamp(std::sqrt(bound * mu * (mu + 1) / s) - mu, 0.0, 1.0);
    }
    return 1;
  }

 private:
  double low() const { return bound * mu / (mu + 1); }
  double high() const { return bound * (mu + 1) / mu; }
};

}  // namespace majak::graph
