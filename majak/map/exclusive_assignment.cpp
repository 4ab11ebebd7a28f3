// SPDX-License-Identifier: Apache-2.0
#include "majak/map/exclusive_assignment.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace majak::map {
namespace {

using Row = std::vector<double>;

/// Each piece's likelihoods over its best one, so that sums neither vanish nor overflow.
struct Relative {
  std::vector<Row> object;
  Row none;
  double log_scale = 0;
};

Relative relative(const std::vector<Row>& log_likelihood, const Row& log_none) {
  Relative r{log_likelihood, log_none, 0};
  for (std::size_t k = 0; k < r.object.size(); ++k) {
    double best = log_none[k];
    for (const double l : r.object[k]) best = std::max(best, l);
    for (double& l : r.object[k]) l = std::exp(l - best);
    r.none[k] = std::exp(r.none[k] - best);
    r.log_scale += best;
  }
  return r;
}

/// Divides by the sum, which it tells.
double scale_to_one(Row& row) {
  double sum = 0;
  for (const double v : row) sum += v;
  for (double& v : row) v /= sum;
  return sum;
}

}  // namespace

AssignmentBelief exclusive_assignment(const std::vector<Row>& log_likelihood, const Row& log_none) {
  const std::size_t pieces = log_likelihood.size();
  const std::size_t objects = pieces == 0 ? 0 : log_likelihood.front().size();
  assert(objects <= 20 && log_none.size() == pieces);
  const Relative r = relative(log_likelihood, log_none);
  const std::size_t sets = std::size_t{1} << objects;
  // before[k][s]: sum over the ways in which pieces 0 ... k - 1 take the objects of s;
  // after[k][s]: pieces k ... take some that are not in s. Both to scale.
  std::vector<Row> before(pieces + 1, Row(sets)), after(pieces + 1, Row(sets, 1.0));
  before[0][0] = 1;
  AssignmentBelief belief{r.log_scale, std::vector<Row>(pieces, Row(objects))};
  for (std::size_t k = 0; k < pieces; ++k) {
    for (std::size_t s = 0; s < sets; ++s) {
      if (before[k][s] == 0) continue;
      before[k + 1][s] += before[k][s] * r.none[k];
      for (std::size_t n = 0; n < objects; ++n)
        if (!(s >> n & 1)) before[k + 1][s | std::size_t{1} << n] += before[k][s] * r.object[k][n];
    }
    belief.log_sum += std::log(scale_to_one(before[k + 1]));
  }
  for (std::size_t k = pieces; k-- > 0;) {
    for (std::size_t s = 0; s < sets; ++s) {
      after[k][s] = r.none[k] * after[k + 1][s];
      for (std::size_t n = 0; n < objects; ++n)
        if (!(s >> n & 1)) after[k][s] += r.object[k][n] * after[k + 1][s | std::size_t{1} << n];
    }
    scale_to_one(after[k]);
  }
  for (std::size_t k = 0; k < pieces; ++k) {
    double sum = 0;
    for (std::size_t s = 0; s < sets; ++s) {
      sum += before[k][s] * r.none[k] * after[k + 1][s];
      for (std::size_t n = 0; n < objects; ++n) {
        if (s >> n & 1) continue;
        const double ways = before[k][s] * r.object[k][n] * after[k + 1][s | std::size_t{1} << n];
        belief.chance[k][n] += ways;
        sum += ways;
      }
    }
    for (double& chance : belief.chance[k]) chance /= sum;
  }
  return belief;
}

}  // namespace majak::map
