// SPDX-License-Identifier: Apache-2.0
#include "majak/map/exclusive_assignment.hpp"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace majak::map {
namespace {

using Row = std::vector<double>;
constexpr double kNever = -std::numeric_limits<double>::infinity();

/// log(exp(a) + exp(b)). Likelihoods lie thousands of nats apart; they never leave the logarithm.
double add(double a, double b) {
  if (a < b) std::swap(a, b);
  return b == kNever ? a : a + std::log1p(std::exp(b - a));
}

/// Piece k is object n, which is not in the set s, or is none of them: next(what it adds, s with
/// n).
template <class Next>
void ways_on(std::size_t s, const Row& object, double none, Next next) {
  next(none, s);
  for (std::size_t n = 0; n < object.size(); ++n)
    if (!(s >> n & 1)) next(object[n], s | std::size_t{1} << n);
}

}  // namespace

AssignmentBelief exclusive_assignment(const std::vector<Row>& log_likelihood, const Row& log_none) {
  const std::size_t pieces = log_likelihood.size();
  const std::size_t objects = pieces == 0 ? 0 : log_likelihood.front().size();
  assert(objects <= 20 && log_none.size() == pieces);
  const std::size_t sets = std::size_t{1} << objects;
  // before[k][s]: sum over the ways in which pieces 0 ... k - 1 take the objects of s;
  // after[k][s]: pieces k ... take some that are not in s. Logarithms.
  std::vector<Row> before(pieces + 1, Row(sets, kNever)), after(pieces + 1, Row(sets, 0.0));
  before[0][0] = 0;
  for (std::size_t k = 0; k < pieces; ++k)
    for (std::size_t s = 0; s < sets; ++s) {
      if (before[k][s] == kNever) continue;
      ways_on(s, log_likelihood[k], log_none[k], [&](double l, std::size_t with) {
        before[k + 1][with] = add(before[k + 1][with], before[k][s] + l);
      });
    }
  for (std::size_t k = pieces; k-- > 0;)
    for (std::size_t s = 0; s < sets; ++s) {
      double sum = kNever;
      ways_on(s, log_likelihood[k], log_none[k],
              [&](double l, std::size_t with) { sum = add(sum, l + after[k + 1][with]); });
      after[k][s] = sum;
    }
  AssignmentBelief belief{after[0][0], std::vector<Row>(pieces, Row(objects))};
  for (std::size_t k = 0; k < pieces; ++k)
    for (std::size_t n = 0; n < objects; ++n)
      for (std::size_t s = 0; s < sets; ++s)
        if (!(s >> n & 1) && before[k][s] != kNever)
          belief.chance[k][n] += std::exp(before[k][s] + log_likelihood[k][n] +
                                          after[k + 1][s | std::size_t{1} << n] - belief.log_sum);
  return belief;
}

}  // namespace majak::map
