// SPDX-License-Identifier: Apache-2.0
// Exclusive assignment: pieces of one snapshot are different objects, so that of all ways to name
// them only those count in which no object occurs twice (MATH 21.4).
#pragma once

#include <vector>

namespace majak::map {

struct AssignmentBelief {
  double log_sum = 0;  ///< log of the sum over all ways of the product of their likelihoods
  std::vector<std::vector<double>> chance;  ///< [piece][object]: share of the ways that say so
};

/// log_likelihood[piece][object], and log_none[piece]: it is none of the objects, which any number
/// of pieces may be. Sums over sets of objects: pieces x objects x 2^objects steps, exact; at most
/// 20 objects.
AssignmentBelief exclusive_assignment(const std::vector<std::vector<double>>& log_likelihood,
                                      const std::vector<double>& log_none);

}  // namespace majak::map
