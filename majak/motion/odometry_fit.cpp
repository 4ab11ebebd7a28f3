// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/odometry_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace majak::motion {
namespace {

using Vec6 =
    Eigen::Matrix<double, 6, 1>;  // scale cos, place turned back, scale sin, turn scale, lag
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Rows = Eigen::Matrix<double, 3, 6>;

constexpr double kDoubt = 3;  // sigmas at which a step counts half
constexpr std::size_t kShortBlock = 6, kBlocks = 25;
constexpr double kLeastTranslation = 0.0005, kLeastRotation = 0.0003;  // m, rad

/// Wheel step w to laser step, linear in the first five unknowns once the turn is known.
Rows rows_of(const Vec3& w, double turn_scale) {
  const double turn = turn_scale * w.z(), c = std::cos(turn) - 1, s = std::sin(turn);
  Rows a = Rows::Zero();
  a.row(0) << w.x(), c, -s, w.y(), 0, 0;
  a.row(1) << w.y(), s, c, -w.x(), 0, 0;
  a(2, 4) = w.z();
  return a;
}

/// The last column: how the laser step that is foretold changes with the lag.
Vec3 by_lag(const Vec3& w, const Vec3& rate, const Vec6& p) {
  const double c = std::cos(p(4) * w.z()), s = std::sin(p(4) * w.z()), turn_rate = p(4) * rate.z();
  return {p(0) * rate.x() + p(3) * rate.y() - turn_rate * (s * p(1) + c * p(2)),
          p(0) * rate.y() - p(3) * rate.x() + turn_rate * (c * p(1) - s * p(2)), turn_rate};
}

Vec6 unknowns_of(const OdometryFaults& f) {
  const Vec2 place = Pose2{0, 0, -f.D.theta} * f.D.translation();
  Vec6 p;
  p << f.scale * std::cos(f.D.theta), place.x(), place.y(), f.scale * std::sin(f.D.theta),
      f.turn_scale, 0;
  return p;
}

/// What is left of the steps, and how much each residual counts.
struct Residual {
  Vec3 r;
  Vec3 weight;       ///< of the residual
  double slope = 0;  ///< derivative of weight times residual over weight; 0: does not count
};

// The scale of the noise is its root of the mean square, not a median: odometry whose records come
// late and then double errs skewly, and its mode is not its mean.
std::vector<Residual> residuals_of(const std::vector<ComparedStep>& steps, const Vec6& p) {
  std::vector<Residual> out;
  out.reserve(steps.size());
  double sum_t = 0, sum_r = 0, n = 0;
  const auto gross = [](const Vec3& r) {
    return r.head<2>().norm() > kGrossStep || std::abs(r.z()) > kGrossTurn;
  };
  for (const ComparedStep& step : steps) {
    Vec3 r = step.laser.vector() - rows_of(step.wheels.vector(), p(4)) * p;
    r.z() = wrap_angle(r.z());
    out.push_back({r, Vec3::Zero(), 0});
    if (gross(r)) continue;
    sum_t += 0.5 * r.head<2>().squaredNorm(), sum_r += r.z() * r.z(), n += 1;
  }
  const double t = 1 / std::max(sum_t / std::max(n, 1.0), kLeastTranslation * kLeastTranslation);
  const double a = 1 / std::max(sum_r / std::max(n, 1.0), kLeastRotation * kLeastRotation);
  for (Residual& e : out) {
    if (gross(e.r)) continue;
    const double doubt =
        (e.r.head<2>().squaredNorm() * t + e.r.z() * e.r.z() * a) / (kDoubt * kDoubt);
    e.weight = Vec3(t, t, a) / (1 + doubt);
    e.slope = (1 - doubt) / (1 + doubt);
  }
  return out;
}

struct Term {
  Mat6 a;
  Vec6 score;
};

// The jackknife over blocks: how far the solution moves when a block is left out. It holds for
// noise that is correlated within a block, and for unknowns that few blocks determine.
Vec6 variance_over_blocks(const std::vector<Term>& terms, const Mat6& a, const Vec6& prior,
                          std::size_t length) {
  const Mat6 inverse = a.inverse();
  Vec6 variance = (inverse * prior.asDiagonal() * inverse.transpose()).diagonal();
  for (std::size_t begin = 0; begin < terms.size(); begin += length) {
    Mat6 rest = a;
    Vec6 score = Vec6::Zero();
    for (std::size_t i = begin; i < std::min(begin + length, terms.size()); ++i)
      rest -= terms[i].a, score += terms[i].score;
    variance += (rest.inverse() * score).cwiseAbs2();
  }
  return variance.allFinite() ? variance : Vec6(prior.cwiseInverse());
}

}  // namespace

OdometryFit fit_odometry(const std::vector<ComparedStep>& steps, const OdometryFaults& start,
                         bool with_sigma) {
  const Vec6 p = unknowns_of(start);
  const auto residuals = residuals_of(steps, p);
  const Mat3 turn = adjoint(start.D);
  Mat6 a = Mat6::Zero(), curvature = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  std::vector<Term> terms;
  terms.reserve(with_sigma ? steps.size() : 0);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const ComparedStep& step = steps[i];
    const Residual& e = residuals[i];
    if (e.weight.isZero()) continue;
    const Vec3 wheels = step.wheels.vector();
    Rows jacobian = rows_of(wheels, p(4));
    jacobian.col(5) = by_lag(wheels, step.wheels_per_lag, p);
    // Instruments: the same by the laser's steps beside this one, whose noise is not in this one.
    Rows instrument = rows_of(turn * step.neighbours, 1);
    instrument.col(5) = step.change;
    const Mat6 product = instrument.transpose() * e.weight.asDiagonal() * jacobian;
    const Vec6 score = instrument.transpose() * e.weight.cwiseProduct(e.r);
    a += product, b += score;
    curvature += e.slope * product;
    if (with_sigma) terms.push_back({e.slope * product, score});
  }
  const Vec6 usual = (Vec6() << 0.1, 0.1, 0.1, 0.05, 0.1, 0.3).finished();
  const Vec6 nominal = (Vec6() << 1, 0, 0, 0, 1, 0).finished();
  const Vec6 prior = usual.cwiseAbs2().cwiseInverse();
  a.diagonal() += prior, curvature.diagonal() += prior;
  const Vec6 x = p + a.inverse() * (b + prior.cwiseProduct(nominal - p));

  OdometryFit fit;
  const double theta = std::atan2(x(3), x(0));
  const Vec2 place = Pose2{0, 0, theta} * Vec2(x(1), x(2));
  fit.faults = {x(5), std::hypot(x(0), x(3)), x(4), {place.x(), place.y(), theta}};
  if (!with_sigma) return fit;
  Vec6 variance = Vec6::Zero();
  for (const std::size_t length : {kShortBlock, std::max(kShortBlock, terms.size() / kBlocks)})
    variance = variance.cwiseMax(variance_over_blocks(terms, curvature, prior, length));
  const Vec6 sigma = variance.cwiseSqrt();
  fit.lag = sigma(5), fit.scale = sigma(0), fit.turn_scale = sigma(4);
  fit.D = Vec3(sigma(1), sigma(2), sigma(3));
  return fit;
}

}  // namespace majak::motion
