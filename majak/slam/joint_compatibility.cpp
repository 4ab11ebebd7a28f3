// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/joint_compatibility.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "majak/core/chi_square.hpp"

namespace majak::slam {
namespace {

constexpr std::size_t kMostSightings = 32;  // sightings that are looked at together

// Depth first over the sightings; each pairing that is added extends the Cholesky root of the joint
// innovation's covariance by two rows.
class Search {
 public:
  Search(const std::vector<std::vector<Pairing>>& candidates, const Eigen::MatrixXd& covariance,
         const JointCompatibilityOptions& options)
      : candidates_(candidates),
        covariance_(covariance),
        options_(options),
        chosen_(candidates.size(), -1),
        best_(candidates.size(), -1) {
    for (std::size_t k = 0; k <= std::min(candidates.size(), kMostSightings); ++k)
      bounds_.push_back(k == 0 ? 0
                               : chi_square_quantile(options.gate, 2.0 * static_cast<double>(k)));
    const auto n = 2 * static_cast<Eigen::Index>(bounds_.size());
    root_.setZero(n, n);
    whitened_.setZero(n);
  }

  std::vector<int> run() {
    descend(0);
    return best_;
  }

 private:
  void descend(std::size_t s) {
    const std::size_t left = candidates_.size() - s;
    const std::size_t count = pairs_.size();
    if (count + left < best_count_ || ++nodes_ > options_.most_nodes) return;
    if (s == candidates_.size()) {
      if (count > best_count_ || (count == best_count_ && nis_ < best_nis_))
        best_ = chosen_, best_count_ = count, best_nis_ = nis_;
      return;
    }
    for (std::size_t c = 0; c < candidates_[s].size(); ++c) {
      const Pairing& p = candidates_[s][c];
      const bool taken = std::any_of(pairs_.begin(), pairs_.end(),
                                     [&](const Pairing* o) { return o->landmark == p.landmark; });
      if (taken || count + 1 >= bounds_.size()) continue;
      const double before = nis_;
      if (push(p)) {
        chosen_[s] = static_cast<int>(c);
        descend(s + 1);
        chosen_[s] = -1;
      }
      pairs_.resize(count);
      nis_ = before;
    }
    descend(s + 1);
  }

  bool push(const Pairing& p) {
    const auto k = 2 * static_cast<Eigen::Index>(pairs_.size());
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      root_.block<2, 2>(k, 2 * static_cast<Eigen::Index>(i)) =
          shared_spread(p, *pairs_[i], covariance_);
    // L21 = S21 L11^-T, L22 L22' = S22 - L21 L21'.
    const auto l11 = root_.topLeftCorner(k, k).triangularView<Eigen::Lower>();
    if (k > 0) l11.transpose().solveInPlace<Eigen::OnTheRight>(root_.middleRows<2>(k).leftCols(k));
    const auto l21 = root_.middleRows<2>(k).leftCols(k);
    const Eigen::Matrix2d s = p.spread - l21 * l21.transpose();
    const double a = s(0, 0), det = s.determinant();
    if (!(a > 0 && det > 0)) return false;
    Eigen::Matrix2d l22 = Eigen::Matrix2d::Zero();
    l22(0, 0) = std::sqrt(a);
    l22(1, 0) = s(1, 0) / l22(0, 0);
    l22(1, 1) = std::sqrt(det / a);
    root_.block<2, 2>(k, k) = l22;
    const Vec2 rest = p.innovation - l21 * whitened_.head(k);
    const double first = rest.x() / l22(0, 0);
    whitened_.segment<2>(k) << first, (rest.y() - l22(1, 0) * first) / l22(1, 1);
    nis_ += whitened_.segment<2>(k).squaredNorm();
    pairs_.push_back(&p);
    return nis_ < bounds_[pairs_.size()];
  }

  const std::vector<std::vector<Pairing>>& candidates_;
  const Eigen::MatrixXd& covariance_;
  const JointCompatibilityOptions& options_;
  std::vector<double> bounds_;  // of the joint NIS, by the number of pairings
  Eigen::MatrixXd root_;
  Eigen::VectorXd whitened_;
  std::vector<const Pairing*> pairs_;
  std::vector<int> chosen_, best_;
  double nis_ = 0, best_nis_ = 0;
  std::size_t best_count_ = 0;
  int nodes_ = 0;
};

// Sightings without a candidate come last: none of them costs a place among those looked at.
bool sooner(const std::vector<Pairing>& a, const std::vector<Pairing>& b) {
  if (a.empty() || b.empty()) return !a.empty() && b.empty();
  return a.size() != b.size() ? a.size() < b.size() : a.front().nis < b.front().nis;
}

}  // namespace

Eigen::Matrix2d shared_spread(const Pairing& a, const Pairing& b,
                              const Eigen::MatrixXd& covariance) {
  const Eigen::Matrix<double, 2, 3> pa = a.by_state.leftCols<3>(), pb = b.by_state.leftCols<3>();
  const Eigen::Matrix2d la = a.by_state.rightCols<2>(), lb = b.by_state.rightCols<2>();
  return pa * covariance.topLeftCorner<3, 3>() * pb.transpose() +
         pa * covariance.block<3, 2>(0, b.column) * lb.transpose() +
         la * covariance.block<2, 3>(a.column, 0) * pb.transpose() +
         la * covariance.block<2, 2>(a.column, b.column) * lb.transpose();
}

std::vector<int> associate_jointly(const std::vector<std::vector<Pairing>>& candidates,
                                   const Eigen::MatrixXd& covariance,
                                   const JointCompatibilityOptions& options) {
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return sooner(candidates[a], candidates[b]);
  });
  std::vector<std::vector<Pairing>> ordered;
  for (const std::size_t s : order) ordered.push_back(candidates[s]);
  const std::vector<int> found = Search(ordered, covariance, options).run();
  std::vector<int> choice(candidates.size());
  for (std::size_t i = 0; i < order.size(); ++i) choice[order[i]] = found[i];
  return choice;
}

void describe(OptionFields& f, JointCompatibilityOptions& o) {
  f.add("association.gate", o.gate,
        {"1", "probability with which true pairings pass, each and together", 0.5, 0.999999});
  f.add("association.most_nodes", o.most_nodes, {"1", "of the search", 1, 1e9});
}

}  // namespace majak::slam
