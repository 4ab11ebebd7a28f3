// SPDX-License-Identifier: Apache-2.0
#include "majak/core/pose2.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "majak/core/random.hpp"

namespace majak {
namespace {

/// Turns at which a formula breaks, if it breaks: none, almost none, both sides of the border
/// between series and quotient, a quarter, almost half and half.
std::vector<double> nasty_turns() {
  std::vector<double> turns{0.0, kPi};
  for (const double t : {1e-300, 1e-12, 1e-9, 0.99e-4, 1.01e-4, 1e-3, kPi / 2, kPi - 1e-9})
    turns.insert(turns.end(), {t, -t});
  return turns;
}

std::vector<Pose2> menagerie() {
  std::vector<Pose2> poses;
  for (const double turn : nasty_turns())
    for (const Vec2& t : {Vec2(0, 0), Vec2(1, 0), Vec2(0, -2), Vec2(1e-9, 1e-9), Vec2(-300, 40)})
      poses.push_back({t.x(), t.y(), turn});
  RandomStream r(1);
  for (int i = 0; i < 40; ++i)
    poses.push_back({r.uniform(-9, 9), r.uniform(-9, 9), r.uniform(-kPi, kPi)});
  return poses;
}

void expect_same(const Pose2& a, const Pose2& b, double tolerance = 1e-11) {
  const double size = 1 + a.translation().norm();
  EXPECT_LT((a.translation() - b.translation()).norm(), tolerance * size)
      << a.vector().transpose() << " against " << b.vector().transpose();
  EXPECT_LT(std::abs(angle_diff(a.theta, b.theta)), tolerance)
      << a.vector().transpose() << " against " << b.vector().transpose();
}

/// The pose as a homogeneous matrix: what everything below is held against.
Mat3 matrix(const Pose2& p) {
  Mat3 m;
  m << std::cos(p.theta), -std::sin(p.theta), p.x, std::sin(p.theta), std::cos(p.theta), p.y, 0, 0,
      1;
  return m;
}

/// Matrix exponential of a twist by its power series.
Mat3 slow_exp(const Vec3& twist) {
  Mat3 generator;
  generator << 0, -twist.z(), twist.x(), twist.z(), 0, twist.y(), 0, 0, 0;
  Mat3 term = Mat3::Identity(), sum = term;
  for (int n = 1; n < 60; ++n) sum += term = term * generator / n;
  return sum;
}

TEST(Pose2, GroupLaws) {
  const auto poses = menagerie();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose2 &a = poses[i], &b = poses[(7 * i + 3) % poses.size()],
                &c = poses[(11 * i + 5) % poses.size()];
    expect_same(a * Pose2{}, a, 1e-15);
    expect_same(Pose2{} * a, a, 1e-15);
    expect_same(a * a.inverse(), {});
    expect_same(a.inverse() * a, {});
    expect_same(a.inverse().inverse(), a);
    expect_same((a * b).inverse(), b.inverse() * a.inverse());
    expect_same((a * b) * c, a * (b * c));
    expect_same(a * between(a, b), b);
  }
}

TEST(Pose2, AgreesWithMatrices) {
  const auto poses = menagerie();
  RandomStream r(2);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose2 &a = poses[i], &b = poses[(13 * i + 1) % poses.size()];
    EXPECT_LT((matrix(a * b) - matrix(a) * matrix(b)).norm(), 1e-12 * (1 + matrix(a).norm()));
    const Vec2 p(r.uniform(-5, 5), r.uniform(-5, 5));
    const Vec3 moved = matrix(a) * Vec3(p.x(), p.y(), 1);
    EXPECT_LT((a * p - moved.head<2>()).norm(), 1e-12 * (1 + moved.norm()));
  }
}

TEST(Pose2, TurnStaysInItsInterval) {
  for (const Pose2& a : menagerie()) {
    for (const Pose2& b : menagerie()) {
      for (const double turn : {(a * b).theta, a.inverse().theta, between(a, b).theta,
                                interpolate(a, b, 0.7).theta, from_vector(3 * a.vector()).theta}) {
        ASSERT_GT(turn, -kPi);
        ASSERT_LE(turn, kPi);
      }
    }
  }
}

TEST(Pose2, ExpUndoesLog) {
  for (const Pose2& p : menagerie()) expect_same(exp(log(p)), p);
}

TEST(Pose2, LogUndoesExp) {
  RandomStream r(3);
  for (const double turn : nasty_turns()) {
    for (int i = 0; i < 5; ++i) {
      const Vec3 twist(r.uniform(-3, 3), r.uniform(-3, 3), turn);
      EXPECT_LT((log(exp(twist)) - twist).norm(), 1e-11) << twist.transpose();
    }
  }
}

TEST(Pose2, ExpIsTheMatrixExponential) {
  RandomStream r(4);
  for (const double turn : nasty_turns()) {
    for (int i = 0; i < 5; ++i) {
      const Vec3 twist(r.uniform(-3, 3), r.uniform(-3, 3), turn);
      EXPECT_LT((matrix(exp(twist)) - slow_exp(twist)).norm(), 1e-11) << twist.transpose();
    }
  }
}

TEST(Pose2, StraightMotionIsNotLostAtZeroTurn) {
  // A guard that adds a tiny number to the turn gives x = 0 here.
  EXPECT_EQ(exp(Vec3(2, 0, 0)), (Pose2{2, 0, 0}));
  EXPECT_EQ(log(Pose2{2, -1, 0}), Vec3(2, -1, 0));
  for (const double turn : {1e-12, -1e-12, 1e-9, -1e-9}) {
    const Pose2 p = exp(Vec3(2, 0, turn));
    EXPECT_DOUBLE_EQ(p.x, 2);
    EXPECT_NEAR(p.y, turn, 1e-18);  // 2 m * turn / 2
    EXPECT_EQ(p.theta, turn);
  }
}

TEST(Pose2, HalfTurnDrivesHalfACircle) {
  for (const double turn : {kPi, -kPi}) {
    const Pose2 p = exp(Vec3(kPi, 0, turn));  // radius 1
    EXPECT_NEAR(p.x, 0, 1e-15);
    EXPECT_NEAR(p.y, turn > 0 ? 2 : -2, 1e-15);
    EXPECT_EQ(p.theta, kPi);  // in (-pi, pi]
  }
}

TEST(Pose2, SeriesMeetsQuotientAtTheirBorder) {
  const double border = 1e-4;
  const auto below = arc_factors(std::nextafter(border, 0)), above = arc_factors(border);
  EXPECT_NEAR(below.sinc, above.sinc, 1e-15);
  EXPECT_NEAR(below.cosc, above.cosc, 1e-11);
}

TEST(Pose2, AdjointCarriesATwistToAnotherFrame) {
  RandomStream r(5);
  for (const Pose2& T : menagerie()) {
    const Vec3 v(r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1));
    expect_same(T * exp(v) * T.inverse(), exp(adjoint(T) * v), 1e-10);
    EXPECT_LT((adjoint(T) * adjoint(T.inverse()) - Mat3::Identity()).norm(), 1e-9);
  }
}

TEST(Pose2, InterpolateHitsItsEndsAndDividesTheArc) {
  const auto poses = menagerie();
  RandomStream r(6);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose2 &a = poses[i], &b = poses[(17 * i + 9) % poses.size()];
    expect_same(interpolate(a, b, 0), a, 1e-12);
    expect_same(interpolate(a, b, 1), b, 1e-10);
    // The law of an arc: a part of a part is the product of the parts.
    const double s = r.uniform(), t = r.uniform();
    expect_same(interpolate(a, interpolate(a, b, s), t), interpolate(a, b, s * t), 1e-9);
  }
}

TEST(Pose2, InterpolateGoesTheShortWayAround) {
  const Pose2 a{0, 0, radians(170)}, b{0, 0, radians(-170)};
  EXPECT_NEAR(interpolate(a, b, 0.25).theta, radians(175), 1e-12);
  EXPECT_NEAR(interpolate(a, b, 0.75).theta, radians(-175), 1e-12);
  EXPECT_NEAR(between(a, b).theta, radians(20), 1e-12);
}

TEST(Pose2, FiniteSeesEveryComponent) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE((Pose2{1, 2, 3}.finite()));
  EXPECT_FALSE((Pose2{nan, 2, 3}.finite()));
  EXPECT_FALSE((Pose2{1, -inf, 3}.finite()));
  EXPECT_FALSE((Pose2{1, 2, nan}.finite()));
}

TEST(Pose2, RightJacobianIsTheDerivative) {
  constexpr double h = 1e-5;
  for (const double turn : {0.0, 1e-9, 1e-4, 0.2, 0.3, 1.0, kPi - 1e-9, kPi, 5.0}) {
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 v(0.8, -0.5, sign * turn);
      const Mat3 J = right_jacobian(v);
      for (int k = 0; k < 3; ++k) {
        const Vec3 d = h * Vec3::Unit(k);
        const Vec3 slope =
            (log(between(exp(v), exp(v + d))) - log(between(exp(v), exp(v - d)))) / (2 * h);
        // exp() itself rounds at 1e-12 around the border of its series, and h magnifies that.
        EXPECT_LT((slope - J.col(k)).norm(), turn == 1e-4 ? 5e-8 : 1e-9) << turn;
      }
    }
  }
  EXPECT_EQ(right_jacobian(Vec3::Zero()), Mat3::Identity().eval());
  // Both sides of the borders between series and quotients.
  for (const double border : {1e-4, 0.3}) {
    const Mat3 below = right_jacobian({1, 2, border * (1 - 1e-9)});
    const Mat3 above = right_jacobian({1, 2, border * (1 + 1e-9)});
    EXPECT_LT((below - above).norm(), 2e-9);
  }
}

TEST(Pose2, RightJacobianAgreesWithItsPowerSeries) {
  // sum of (-ad)^n / (n + 1)!
  for (const double turn : {0.0, 1e-12, 1e-4, 0.29, 0.31, 2.0, kPi}) {
    const Vec3 v(-1.5, 0.7, turn);
    Mat3 ad;
    ad << 0, -v.z(), v.y(), v.z(), 0, -v.x(), 0, 0, 0;
    Mat3 term = Mat3::Identity(), sum = term;
    for (int n = 1; n < 40; ++n) sum += term = -term * ad / (n + 1);
    EXPECT_LT((right_jacobian(v) - sum).norm(), 1e-11) << turn;  // seen: 3e-12 at 1e-4
  }
}

}  // namespace
}  // namespace majak
