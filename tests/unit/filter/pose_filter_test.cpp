// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/pose_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "majak/core/chi_square.hpp"
#include "majak/core/random.hpp"

namespace majak::filter {
namespace {

using State = PoseState<2>;
using Belief = PoseBelief<2>;
using Motion = RelativeInput<2>;
using Vector = State::Vector;
using Matrix = State::Matrix;

template <int N>
Eigen::Matrix<double, N, 1> normals(RandomStream& random) {
  Eigen::Matrix<double, N, 1> v;
  for (double& x : v) x = random.normal();
  return v;
}

template <int N>
Eigen::Matrix<double, N, N> positive(RandomStream& random, double size = 1) {
  Eigen::Matrix<double, N, N> a;
  for (int i = 0; i < N; ++i) a.col(i) = normals<N>(random);
  return size * (a * a.transpose() + 0.1 * Eigen::Matrix<double, N, N>::Identity());
}

State random_state(RandomStream& random) {
  State s;
  s.T_map_robot = from_vector(3 * normals<3>(random));
  s.extra = normals<2>(random);
  return s;
}

Motion random_motion(RandomStream& random, const Eigen::Vector2d& at) {
  Motion m;
  m.T_from_to = from_vector(normals<3>(random));
  m.at = at;
  for (int i = 0; i < 2; ++i) m.by_extra.col(i) = normals<3>(random);
  m.noise = positive<3>(random);
  m.keep = {random.uniform(0.2, 1), random.uniform(0.2, 1)};
  return m;
}

double apart(const State& a, const State& b) { return a.minus(b).cwiseAbs().maxCoeff(); }

// States and errors.

TEST(PoseState, PlusAndMinusAreInverse) {
  RandomStream random(1);
  for (int i = 0; i < 1000; ++i) {
    const State a = random_state(random), b = random_state(random);
    EXPECT_LT(apart(a.plus(b.minus(a)), b), 1e-13);
    Vector e = normals<5>(random);
    e(2) = random.uniform(-3.1, 3.1);
    EXPECT_LT((a.plus(e).minus(a) - e).cwiseAbs().maxCoeff(), 1e-12);
  }
  const State a = random_state(random);
  EXPECT_LT(a.minus(a).cwiseAbs().maxCoeff(), 1e-15);
}

// Motions.

TEST(RelativeInput, ThenIsOneAfterTheOther) {
  RandomStream random(2);
  for (int i = 0; i < 1000; ++i) {
    State from = random_state(random);
    const Motion a = random_motion(random, from.extra);
    const State middle = a.apply(from);
    const Motion b = random_motion(random, middle.extra);
    Motion both = a;
    both.then(b);
    EXPECT_LT(apart(both.apply(from), b.apply(middle)), 1e-12);
    EXPECT_LT((both.transition() - b.transition() * a.transition()).cwiseAbs().maxCoeff(), 1e-12);
    const Matrix f = b.transition();
    EXPECT_LT((both.added() - f * a.added() * f.transpose() - b.added()).cwiseAbs().maxCoeff(),
              1e-11);
  }
}

TEST(RelativeInput, NumbersThatWanderAddUp) {
  Motion a, b;  // by_extra is zero
  a.keep = {0.5, 1}, a.extra_noise = {1, 2};
  b.keep = {0.25, 1}, b.extra_noise = {3, 4};
  Motion both = a;
  both.then(b);
  EXPECT_EQ(both.keep, Eigen::Vector2d(0.125, 1));
  EXPECT_EQ(both.extra_noise, Eigen::Vector2d(1.0 / 16 + 3, 6));
  EXPECT_EQ(both.added(), (b.transition() * a.added() * b.transition().transpose() + b.added()));
}

TEST(RelativeInput, TransitionIsTheNumericDerivative) {
  RandomStream random(3);
  for (int i = 0; i < 100; ++i) {
    const State from = random_state(random);
    const Motion m = random_motion(random, from.extra);
    const State to = m.apply(from);
    Matrix numeric;
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 5; ++k) {
      const Vector e = kStep * Vector::Unit(k);
      numeric.col(k) =
          (m.apply(from.plus(e)).minus(to) - m.apply(from.plus(-e)).minus(to)) / (2 * kStep);
    }
    EXPECT_LT((numeric - m.transition()).cwiseAbs().maxCoeff(), 1e-8);  // seen 2e-9
  }
}

TEST(RelativeInput, TransitionOfAPoseErrorIsExactHoweverLarge) {
  // exp(xi) T = T exp(Ad(T^-1) xi) has no second order, so an unknown heading does no harm.
  RandomStream random(4);
  for (int i = 0; i < 100; ++i) {
    const State from = random_state(random);
    const Motion m = random_motion(random, from.extra);
    Vector e = Vector::Zero();
    e.head<3>() = normals<3>(random);
    e(2) = random.uniform(-3, 3);
    const State moved = m.apply(from.plus(e));
    EXPECT_LT(apart(moved, m.apply(from).plus(m.transition() * e)), 1e-12);
  }
}

TEST(RelativeInput, ShiftingTheWholePathIsNotNoticed) {
  // Whatever the noise made of the step: moved and turned together, both ends err alike.
  RandomStream random(14);
  for (int i = 0; i < 100; ++i) {
    const State from = random_state(random), to = random_state(random);
    Motion m = random_motion(random, from.extra);
    const Vec3 shift = normals<3>(random);  // in the map's axes
    Vector e = Vector::Zero(), expected = Vector::Zero();
    e.head<3>() = adjoint(from.T_map_robot.inverse()) * shift;
    expected.head<3>() = adjoint(to.T_map_robot.inverse()) * shift;
    EXPECT_LT((m.transition(from, to) * e - expected).norm(), 1e-11);
  }
}

// Corrections.

template <int Dim>
AbsoluteInput<2, Dim> random_measurement(RandomStream& random, double size = 1) {
  AbsoluteInput<2, Dim> z;
  z.residual = size * normals<Dim>(random);
  for (int i = 0; i < 5; ++i) z.H.col(i) = normals<Dim>(random);
  z.noise = positive<Dim>(random, std::exp(random.normal()));
  return z;
}

TEST(PoseBelief, CorrectionsAreTheBatchLeastSquares) {
  // The slow twin adds up information: L = P^-1 + sum H' R^-1 H.
  RandomStream random(5);
  for (int run = 0; run < 50; ++run) {
    Belief b;
    b.mean = normals<5>(random);
    b.covariance = positive<5>(random);
    Matrix information = b.covariance.inverse();
    Vector vector = information * b.mean;
    for (int i = 0; i < 10; ++i) {
      const auto z = random_measurement<2>(random);
      const auto done = b.correct(z, 1e9);
      EXPECT_EQ(done.share, 1);
      information += z.H.transpose() * z.noise.inverse() * z.H;
      vector += z.H.transpose() * z.noise.inverse() * z.residual;
    }
    EXPECT_LT((b.covariance - information.inverse()).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((b.mean - information.inverse() * vector).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(PoseBelief, TellsTheNisAndTheSpread) {
  Belief b;
  b.covariance = 3 * Matrix::Identity();
  AbsoluteInput<2, 1> z;
  z.residual << 4;
  z.H << 1, 0, 0, 0, 0;
  z.noise << 1;
  const auto done = b.correct(z, 100);  // S = 4
  EXPECT_DOUBLE_EQ(done.nis, 4);
  EXPECT_DOUBLE_EQ(done.log_det, std::log(4.0));
  EXPECT_DOUBLE_EQ(b.mean(0), 3);
  EXPECT_DOUBLE_EQ(b.covariance(0, 0), 0.75);
  EXPECT_DOUBLE_EQ(b.covariance(1, 1), 3);
}

TEST(PoseBelief, BeyondTheGateItCountsAsMeasuredWorse) {
  Belief b;
  b.covariance = 3 * Matrix::Identity();
  AbsoluteInput<2, 1> z;
  z.residual << 12;
  z.H << 1, 0, 0, 0, 0;
  z.noise << 1;
  const auto done = b.correct(z, 9);  // S = 4, NIS 36, S' = 16
  EXPECT_DOUBLE_EQ(done.nis, 36);
  EXPECT_DOUBLE_EQ(done.share, 0.25);
  EXPECT_DOUBLE_EQ(b.mean(0), 12 * 3.0 / 16);
  EXPECT_DOUBLE_EQ(b.covariance(0, 0), 3 - 9.0 / 16);
}

TEST(PoseBelief, NoMeasurementMovesItBeyondTheGate) {
  RandomStream random(6);
  double furthest = 0;
  for (int i = 0; i < 2000; ++i) {
    const double gate = random.uniform(1, 20);
    Belief b;
    b.covariance = positive<5>(random);
    const Matrix prior = b.covariance;
    const auto done = b.correct(random_measurement<2>(random, std::exp(3 * random.normal())), gate);
    EXPECT_EQ(done.share<1, done.nis> gate);
    const double shift = std::sqrt(b.mean.dot(prior.ldlt().solve(b.mean)) / gate);
    EXPECT_LE(shift, 1 + 1e-9);
    furthest = std::max(furthest, shift);
    const Eigen::SelfAdjointEigenSolver<Matrix> less(prior - b.covariance);
    EXPECT_GT(less.eigenvalues().minCoeff(), -1e-9);  // nothing becomes less sure by measuring
  }
  EXPECT_GT(furthest, 0.95);  // and the bound is nearly reached: 0.98 seen
}

TEST(PoseBelief, SettlingKeepsTheState) {
  RandomStream random(7);
  Belief b;
  b.nominal = random_state(random);
  b.mean = 0.3 * normals<5>(random);
  const State before = b.state();
  b.settle();
  EXPECT_EQ(b.mean, Vector::Zero().eval());
  EXPECT_LT(apart(before, b.state()), 1e-15);
}

TEST(PoseBelief, PredictsTheSameAboutAnyNominalState) {
  RandomStream random(8);
  for (int i = 0; i < 100; ++i) {
    Belief own;
    own.nominal = random_state(random);
    own.covariance = positive<5>(random);
    Belief other = own;
    const Motion m = random_motion(random, own.nominal.extra);
    own.predict(m);
    const State to = own.nominal.plus(0.5 * normals<5>(random));
    other.predict(m, &to);
    EXPECT_LT(apart(own.state(), other.state()), 1e-13);
    // The same errors in other axes, noise apart.
    Matrix turn = Matrix::Identity();
    turn.topLeftCorner<3, 3>() = adjoint(between(to.T_map_robot, own.nominal.T_map_robot));
    const Matrix expected = turn * (own.covariance - m.added()) * turn.transpose() + m.added();
    EXPECT_LT((other.covariance - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(PoseBelief, StaysSymmetricAndPositiveOverAMillionSteps) {
  using Small = PoseBelief<1>;
  RandomStream random(9);
  Small b;
  b.covariance = 1e4 * Small::State::Matrix::Identity();
  RelativeInput<1> m;
  AbsoluteInput<1, 1> z;
  for (int i = 0; i < 1'000'000; ++i) {
    m.T_from_to =
        from_vector({random.uniform(-1, 1), random.uniform(-0.1, 0.1), random.uniform(-0.5, 0.5)});
    m.by_extra.setConstant(m.T_from_to.x);
    m.noise.diagonal().setConstant(1e-10);
    b.predict(m);
    for (int k = 0; k < 4; ++k) z.H(k) = random.uniform(-1, 1);
    z.residual(0) = random.uniform(-1, 1);
    z.noise(0) = i % 2 == 0 ? 1e-8 : 100;
    b.correct(z, 9);
    if (i % 100 == 0) {
      ASSERT_EQ(b.covariance, b.covariance.transpose().eval());
      ASSERT_EQ(b.covariance.llt().info(), Eigen::Success) << i;
    }
    b.settle();
  }
}

// The smoother.

TEST(Smooth, OnALineItIsTheJointLeastSquares) {
  // Without turning all is linear. Slow twin: normal equations over all states at once.
  constexpr int kNodes = 12, kAll = 5 * kNodes;
  RandomStream random(10);
  std::vector<Belief> predicted(kNodes), filtered(kNodes), smoothed(kNodes);
  std::vector<Motion> motions(kNodes);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kAll, kAll);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(kAll);
  const auto add = [&](const Eigen::MatrixXd& J, const Eigen::VectorXd& r, Eigen::MatrixXd noise) {
    const Eigen::MatrixXd information = noise.inverse();
    H += J.transpose() * information * J;
    g += J.transpose() * information * r;
  };
  // Errors of all against the zero state.
  predicted[0].covariance = positive<5>(random);
  predicted[0].covariance.row(2).setZero(), predicted[0].covariance.col(2).setZero();
  predicted[0].covariance(2, 2) = 1e-9;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(5, kAll);
  J.leftCols(5).setIdentity();
  add(J, Vector::Zero(), predicted[0].covariance);
  for (int k = 0; k < kNodes; ++k) {
    const auto n = static_cast<std::size_t>(k);
    if (k > 0) {
      Motion& m = motions[n];
      m.T_from_to = {random.normal(), random.normal(), 0};
      for (int i = 0; i < 2; ++i) m.by_extra.col(i) << random.normal(), random.normal(), 0;
      m.noise = Vec3(0.3, 0.2, 1e-9).asDiagonal();
      m.keep = {0.9, 0.8};
      m.extra_noise = {0.1, 0.2};
      predicted[n] = filtered[n - 1];
      const State zero;
      predicted[n].predict(m, &zero);
      J.setZero();
      J.middleCols(5 * k, 5).setIdentity();
      J.middleCols(5 * k - 5, 5) = -m.transition();
      add(J, (Vector() << m.T_from_to.vector(), 0, 0).finished(), m.added());
    }
    filtered[n] = predicted[n];
    auto z = random_measurement<2>(random, 3);
    z.H.col(2).setZero();
    filtered[n].correct(z, 1e9);
    J.setZero(2, kAll);
    J.middleCols(5 * k, 5) = z.H;
    add(J, z.residual, z.noise);
    J.setZero(5, kAll);
  }
  const Eigen::MatrixXd covariance = H.inverse();
  const Eigen::VectorXd mean = covariance * g;
  for (int k = kNodes; k-- > 0;) {
    const auto n = static_cast<std::size_t>(k);
    smoothed[n] = k + 1 < kNodes
                      ? smooth(filtered[n], predicted[n + 1], motions[n + 1], smoothed[n + 1])
                      : filtered[n];
    EXPECT_LT((smoothed[n].mean - mean.segment<5>(5 * k)).cwiseAbs().maxCoeff(), 1e-5) << k;
    EXPECT_LT((smoothed[n].covariance - covariance.block<5, 5>(5 * k, 5 * k)).cwiseAbs().maxCoeff(),
              1e-6)
        << k;
  }
}

// A robot that turns, with a scale and a drift to learn, seen by its place only.
struct Nees {
  double filter = 0, middle = 0, begin = 0;  // NEES, 5 degrees of freedom each
};

Nees simulated_run(std::uint64_t seed) {
  constexpr int kNodes = 40;
  RandomStream random(11, seed);
  Belief start;
  start.nominal.T_map_robot = {1, -2, 0.5};
  start.nominal.extra = {1, 0};
  const Vector spread(0.1, 0.1, 0.05, 0.03, 0.02);
  start.covariance = spread.cwiseAbs2().asDiagonal();
  State truth = start.nominal.plus(spread.cwiseProduct(normals<5>(random)));
  std::vector<State> truths;
  std::vector<Belief> predicted, filtered;
  std::vector<Motion> motions;
  const Vec3 noise(0.03, 0.02, 0.01);
  for (int k = 0; k < kNodes; ++k) {
    Motion m;
    const Vec3 twist(0.5, 0, k < 20 ? 0.1 : -0.15);
    m.noise = noise.cwiseAbs2().asDiagonal();
    Belief b = k == 0 ? start : filtered.back();
    if (k > 0) {
      m.at = b.nominal.extra;  // made linear where the filter stands
      const auto twist_with = [&](const Eigen::Vector2d& extra) {
        return Vec3(twist.x() * extra(0), 0, twist.z() + twist.x() * extra(1));
      };
      m.T_from_to = exp(twist_with(m.at));
      m.by_extra.col(0) << twist.x(), 0, 0;
      m.by_extra.col(1) << 0, 0, twist.x();
      m.by_extra = (right_jacobian(twist_with(m.at)) * m.by_extra).eval();
      truth.T_map_robot = truth.T_map_robot * exp(twist_with(truth.extra)) *
                          exp(noise.cwiseProduct(normals<3>(random)));
      b.predict(m);
    }
    predicted.push_back(b);
    AbsoluteInput<2, 2> z;
    const double c = std::cos(b.nominal.T_map_robot.theta),
                 s = std::sin(b.nominal.T_map_robot.theta);
    z.H.setZero();
    z.H.leftCols<2>() << c, -s, s, c;
    z.noise = 0.04 * Eigen::Matrix2d::Identity();
    z.residual = truth.T_map_robot.translation() + 0.2 * normals<2>(random) -
                 b.nominal.T_map_robot.translation();
    b.correct(z, 1e9);
    b.settle();
    filtered.push_back(b);
    motions.push_back(m);
    truths.push_back(truth);
  }
  const auto nees = [&](const Belief& b, std::size_t k) {
    const Vector e = truths[k].minus(b.nominal) - b.mean;
    return e.dot(b.covariance.ldlt().solve(e));
  };
  Nees run;
  run.filter = nees(filtered.back(), kNodes - 1);
  Belief next = filtered.back();
  for (std::size_t k = kNodes - 1; k-- > 0;) {
    next.mean = next.state().minus(predicted[k + 1].nominal);  // about the predicted state
    next.nominal = predicted[k + 1].nominal;
    next = smooth(filtered[k], predicted[k + 1], motions[k + 1], next);
    if (k == kNodes / 2) run.middle = nees(next, k);
    if (k == 0) run.begin = nees(next, k);
  }
  return run;
}

TEST(Consistency, FilterAndSmootherKnowTheirErrors) {
  constexpr int kRuns = 1000;
  Nees sum;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const Nees run = simulated_run(seed);
    sum.filter += run.filter, sum.middle += run.middle, sum.begin += run.begin;
  }
  const double low = chi_square_quantile(0.005, 5.0 * kRuns) / kRuns;
  const double high = chi_square_quantile(0.995, 5.0 * kRuns) / kRuns;
  // Seen: 4.97, 5.15, 5.14 within 4.75 .. 5.26.
  for (const double mean : {sum.filter / kRuns, sum.middle / kRuns, sum.begin / kRuns}) {
    EXPECT_GT(mean, low);
    EXPECT_LT(mean, high);
  }
}

}  // namespace
}  // namespace majak::filter
