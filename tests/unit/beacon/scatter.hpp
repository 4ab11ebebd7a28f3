// SPDX-License-Identifier: Apache-2.0
// Does a stated covariance hold? The scatter of many errors, seen in the stated one's own axes.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>

#include "majak/core/pose2.hpp"
#include "majak/core/random.hpp"

namespace majak::beacon {

template <int N>
class Scatter {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Square = Eigen::Matrix<double, N, N>;

  /// `stated` at the true place.
  explicit Scatter(const Square& stated) : root_(stated.llt()) {}
  void add(const Vector& error) {
    const Vector white = root_.matrixL().solve(error);
    sum_ += white * white.transpose();
    ++count_;
  }
  /// The largest difference of the whitened second moments from the identity.
  double difference() const { return (sum_ / count_ - Square::Identity()).cwiseAbs().maxCoeff(); }

 private:
  Eigen::LLT<Square> root_;
  Square sum_ = Square::Zero();
  double count_ = 0;
};

}  // namespace majak::beacon
