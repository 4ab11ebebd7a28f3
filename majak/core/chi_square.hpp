// SPDX-License-Identifier: Apache-2.0
// The chi-square distribution: of squared errors divided by their variances.
#pragma once

namespace majak {

/// P(X <= x) for X chi-square with `dof` degrees of freedom; dof > 0, x >= 0.
double chi_square_cdf(double x, double dof);

/// The x with chi_square_cdf(x, dof) = p; p in (0, 1), to about 1e-12 relative.
double chi_square_quantile(double p, double dof);

}  // namespace majak
