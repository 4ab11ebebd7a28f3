// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/hidden_poses.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace majak::slam {
namespace {

constexpr double kFar = 9;              // of log probability below a row's best
constexpr double kMost = 600;           // differences of log probability
constexpr double kNothing = 1e-14;      // a posterior below this is not drawn into the map
constexpr double kMostCells = 1 << 22;  // more would be made larger

double log_sum(const std::vector<double>& values) {
  const double largest = *std::max_element(values.begin(), values.end());
  double sum = 0;
  for (const double v : values) sum += std::exp(v - largest);
  return largest + std::log(sum);
}

// exp(values - the largest), which is returned too. What is e^-600 times as likely or less counts
// as that, so that there is always a path.
double from_log(const std::vector<double>& values, std::vector<double>& result) {
  const double largest = *std::max_element(values.begin(), values.end());
  result.clear();
  for (const double v : values) result.push_back(std::exp(std::max(v - largest, -kMost)));
  return largest;
}

// log sum_s exp(from_s) p(t | s)
std::vector<double> forward(const Transitions& step, const std::vector<double>& from,
                            std::size_t n) {
  std::vector<double> weight, sum(n, 0.0);
  const double largest = from_log(from, weight);
  for (std::size_t s = 0; s < weight.size(); ++s)
    for (std::uint32_t k = step.row[s]; k < step.row[s + 1]; ++k)
      sum[step.to[k]] += weight[s] * static_cast<double>(step.probability[k]);
  for (double& v : sum) v = largest + std::log(v);
  return sum;
}

// log sum_t p(t | s) exp(to_t)
std::vector<double> backward(const Transitions& step, const std::vector<double>& to) {
  std::vector<double> weight, result;
  const double largest = from_log(to, weight);
  for (std::size_t s = 0; s + 1 < step.row.size(); ++s) {
    double sum = 0;
    for (std::uint32_t k = step.row[s]; k < step.row[s + 1]; ++k)
      sum += static_cast<double>(step.probability[k]) * weight[step.to[k]];
    result.push_back(largest + std::log(sum));
  }
  return result;
}

std::vector<double> sum_of(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

// visit(cell index) for places [first, last) of the piece seen from T; all lie inside.
template <class Visit>
void for_cells(const Piece& piece, std::size_t first, std::size_t last, const Pose2& T,
               const HitMap& grid, const Visit& visit) {
  const auto c = static_cast<float>(std::cos(T.theta) / grid.cell);
  const auto s = static_cast<float>(std::sin(T.theta) / grid.cell);
  const auto px = static_cast<float>((T.x - grid.x0) / grid.cell);
  const auto py = static_cast<float>((T.y - grid.y0) / grid.cell);
  for (std::size_t i = first; i < last; ++i) {
    const int ix = static_cast<int>(c * piece.x[i] - s * piece.y[i] + px);
    const int iy = static_cast<int>(s * piece.x[i] + c * piece.y[i] + py);
    visit(static_cast<std::size_t>(iy) * static_cast<std::size_t>(grid.width) +
          static_cast<std::size_t>(ix));
  }
}

// Cells around all that may be seen from any hypothesis.
HitMap empty_map(const std::vector<Piece>& pieces, const HiddenPoses& hidden, double cell) {
  double x0 = 1e300, y0 = 1e300, x1 = -1e300, y1 = -1e300;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    double reach = 0;
    for (std::size_t i = 0; i < pieces[p].x.size(); ++i)
      reach = std::max(reach, std::hypot(static_cast<double>(pieces[p].x[i]),
                                         static_cast<double>(pieces[p].y[i])));
    for (const Pose2& T : hidden.supports[p]) {
      x0 = std::min(x0, T.x - reach), x1 = std::max(x1, T.x + reach);
      y0 = std::min(y0, T.y - reach), y1 = std::max(y1, T.y + reach);
    }
  }
  HitMap d;
  d.cell = std::max(cell, std::sqrt((x1 - x0) * (y1 - y0) / kMostCells));
  d.x0 = x0 - d.cell, d.y0 = y0 - d.cell;
  d.width = static_cast<int>((x1 - d.x0) / d.cell) + 2;
  d.height = static_cast<int>((y1 - d.y0) / d.cell) + 2;
  return d;
}

}  // namespace

Transitions transitions(const std::vector<Pose2>& from, const std::vector<Pose2>& to,
                        const Pose2& T_from_to, const Mat3& covariance) {
  const Mat3 root = covariance.llt().matrixL().solve(Mat3::Identity());
  Transitions result;
  result.row.push_back(0);
  std::vector<double> row(to.size());
  for (const Pose2& s : from) {
    const Pose2 expected_inverse = (s * T_from_to).inverse();
    for (std::size_t t = 0; t < to.size(); ++t)
      row[t] = -0.5 * (root * (expected_inverse * to[t]).vector()).squaredNorm();
    const double best = *std::max_element(row.begin(), row.end());
    double sum = 0;
    for (const double v : row)
      if (v > best - kFar) sum += std::exp(v - best);
    for (std::size_t t = 0; t < to.size(); ++t) {
      if (!(row[t] > best - kFar)) continue;
      result.to.push_back(static_cast<std::uint32_t>(t));
      result.probability.push_back(static_cast<float>(std::exp(row[t] - best) / sum));
    }
    result.row.push_back(static_cast<std::uint32_t>(result.to.size()));
  }
  return result;
}

HiddenPosterior forward_backward(const HiddenPoses& hidden, const PerHypothesis& log_likelihood) {
  const std::size_t n = hidden.supports.size();
  PerHypothesis alpha(n), beta(n);
  const double first = -std::log(static_cast<double>(hidden.supports.front().size()));
  alpha[0] = log_likelihood[0];
  for (double& a : alpha[0]) a += first;
  for (std::size_t p = 1; p < n; ++p)
    alpha[p] = sum_of(forward(hidden.steps[p - 1], alpha[p - 1], hidden.supports[p].size()),
                      log_likelihood[p]);
  beta[n - 1].assign(hidden.supports[n - 1].size(), 0.0);
  for (std::size_t p = n - 1; p-- > 0;)
    beta[p] = backward(hidden.steps[p], sum_of(beta[p + 1], log_likelihood[p + 1]));
  HiddenPosterior posterior{PerHypothesis(n), log_sum(alpha[n - 1])};
  for (std::size_t p = 0; p < n; ++p) {
    std::vector<double>& of_pose = posterior.probability[p] = sum_of(alpha[p], beta[p]);
    const double eta = log_sum(of_pose);  // the normaliser of Bayes' rule
    for (double& v : of_pose) v = std::exp(v - eta);
  }
  return posterior;
}

HitMap maximise(const std::vector<Piece>& pieces, const HiddenPoses& hidden,
                const PerHypothesis& probability, const HitMapOptions& options) {
  HitMap map = empty_map(pieces, hidden, options.cell);
  const std::size_t cells =
      static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
  std::vector<double> hits(cells, options.hits), misses(cells, options.misses);
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (std::size_t s = 0; s < hidden.supports[p].size(); ++s) {
      if (probability[p][s] < kNothing) continue;
      const Piece& piece = pieces[p];
      const Pose2& T = hidden.supports[p][s];
      const double hit = options.weight * probability[p][s], miss = hit * piece.miss_weight;
      for_cells(piece, 0, piece.hits, T, map, [&](std::size_t c) { hits[c] += hit; });
      for_cells(piece, piece.hits, piece.x.size(), T, map,
                [&](std::size_t c) { misses[c] += miss; });
    }
  map.log_hit.resize(cells), map.log_miss.resize(cells);
  for (std::size_t c = 0; c < cells; ++c) {
    const double log_both = std::log(hits[c] + misses[c]);
    const double log_hit = std::log(hits[c]) - log_both, log_miss = std::log(misses[c]) - log_both;
    map.log_hit[c] = static_cast<float>(log_hit), map.log_miss[c] = static_cast<float>(log_miss);
    map.log_prior += options.hits * log_hit + options.misses * log_miss;
  }
  return map;
}

PerHypothesis log_likelihoods(const std::vector<Piece>& pieces, const HiddenPoses& hidden,
                              const HitMap& map, const HitMapOptions& options, Threads threads) {
  PerHypothesis result(pieces.size());
  parallel_for(threads, pieces.size(), [&](std::size_t p) {
    const Piece& piece = pieces[p];
    for (const Pose2& T : hidden.supports[p]) {
      double hit = 0, miss = 0;
      for_cells(piece, 0, piece.hits, T, map,
                [&](std::size_t c) { hit += static_cast<double>(map.log_hit[c]); });
      for_cells(piece, piece.hits, piece.x.size(), T, map,
                [&](std::size_t c) { miss += static_cast<double>(map.log_miss[c]); });
      result[p].push_back(options.weight * (hit + piece.miss_weight * miss));
    }
  });
  return result;
}

}  // namespace majak::slam
