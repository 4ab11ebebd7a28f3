// SPDX-License-Identifier: Apache-2.0
// Laws that every drive keeps, over 10^5 random motions and down to the straight limit.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "majak/core/random.hpp"
#include "majak/motion/drive.hpp"

namespace majak::motion {
namespace {

constexpr int kMotions = 100'000;

/// Of every size down to nothing, both signs: half of them usual, the rest 10^-1 ... 10^-16.
double any_size(RandomStream& r, double usual) {
  const double sign = r.below(2) == 0 ? -1 : 1;
  if (r.below(100) == 0) return 0;
  return sign * usual * (r.below(2) == 0 ? r.uniform() : std::pow(10.0, -r.uniform(1, 16)));
}

/// dx = R sin(turn), dy = R - R cos(turn) (thesis p. 16) in quadruple-like care: 1 - cos by half
/// angles, and the straight limit written out.
Pose2 arc(double way, double turn) {
  if (std::abs(turn) < 1e-9) return {way, way * turn / 2, turn};
  const double radius = way / turn, half = std::sin(turn / 2);
  return {radius * std::sin(turn), 2 * radius * half * half, wrap_angle(turn)};
}

TEST(DriveLaws, DifferentialArcsAreTheClosedForm) {
  RandomStream r(1);
  const Differential drive{0.37};
  for (int i = 0; i < kMotions; ++i) {
    const double left = any_size(r, 1),
                 right = i % 3 == 0 ? left + any_size(r, 0.1) : any_size(r, 1);
    const Pose2 T = exp(drive.forward({left, right}));
    const Pose2 expected = arc((left + right) / 2, (right - left) / 0.37);
    ASSERT_NEAR(T.x, expected.x, 1e-12);
    ASSERT_NEAR(T.y, expected.y, 1e-12);
    ASSERT_NEAR(angle_diff(T.theta, expected.theta), 0, 1e-12);
    const auto back = drive.inverse(log(T));  // turns below pi: |right - left| < 0.37 pi
    if (std::abs(right - left) > 1.1) continue;
    ASSERT_NEAR(back.left, left, 1e-12);
    ASSERT_NEAR(back.right, right, 1e-12);
  }
}

TEST(DriveLaws, AckermannArcsAreTheClosedForm) {
  RandomStream r(2);
  const Ackermann drive{1.2};
  for (int i = 0; i < kMotions; ++i) {
    const double way = any_size(r, 2), steering = any_size(r, 1.4);
    const Pose2 T = exp(drive.forward({way, steering}));
    const Pose2 expected = arc(way * std::cos(steering), way * std::sin(steering) / 1.2);
    ASSERT_NEAR(T.x, expected.x, 1e-12);
    ASSERT_NEAR(T.y, expected.y, 1e-12);
    ASSERT_NEAR(angle_diff(T.theta, expected.theta), 0, 1e-12);
    if (std::abs(way) < 1e-6) continue;  // what does not roll says nothing of its steering
    const auto back = drive.inverse(log(T));
    ASSERT_NEAR(back.way, way, 1e-12);
    ASSERT_NEAR(back.steering, steering, 1e-9);
  }
}

TEST(DriveLaws, OmnidirectionalGoesBothWaysRound) {
  RandomStream r(3);
  const Omnidirectional drive{0.25};
  for (int i = 0; i < kMotions; ++i) {
    const Vec3 twist(any_size(r, 1), any_size(r, 1), any_size(r, 3));
    const Vec3 back = log(exp(drive.forward(drive.inverse(twist))));
    ASSERT_LT((back - twist).norm(), 1e-11) << twist.transpose();
  }
}

/// Central differences of f: the slow twin of every derivative.
template <class F>
Vec3 slope(F&& f) {
  constexpr double h = 1e-5;
  return (f(h) - f(-h)) / (2 * h);
}

TEST(DriveLaws, DerivativesByWheels) {
  RandomStream r(4);
  for (int i = 0; i < 1000; ++i) {
    const Differential d{r.uniform(0.2, 1)};
    const Differential::Wheels dw{any_size(r, 1), any_size(r, 1)};
    EXPECT_LT((d.by_wheels().col(0) - slope([&](double h) {
                 return d.forward({dw.left + h, dw.right});
               })).norm(),
              1e-9);
    EXPECT_LT((d.by_wheels().col(1) - slope([&](double h) {
                 return d.forward({dw.left, dw.right + h});
               })).norm(),
              1e-9);
    const Ackermann a{r.uniform(0.3, 3)};
    const Ackermann::Wheels aw{any_size(r, 1), any_size(r, 1.4)};
    EXPECT_LT((a.by_wheels(aw).col(0) - slope([&](double h) {
                 return a.forward({aw.way + h, aw.steering});
               })).norm(),
              1e-9);
    EXPECT_LT((a.by_wheels(aw).col(1) - slope([&](double h) {
                 return a.forward({aw.way, aw.steering + h});
               })).norm(),
              1e-9);
    const Omnidirectional o{r.uniform(0.1, 1)};
    const Omnidirectional::Wheels ow{any_size(r, 1), any_size(r, 1), any_size(r, 1)};
    for (int k = 0; k < 3; ++k) {
      const auto moved = [&](double h) {
        auto w = ow;
        w[k] += h;
        return o.forward(w);
      };
      EXPECT_LT((o.by_wheels().col(k) - slope(moved)).norm(), 1e-9);
    }
  }
}

TEST(DriveLaws, DerivativesByParameters) {
  RandomStream r(5);
  for (int i = 0; i < 1000; ++i) {
    const Differential d{r.uniform(0.3, 1)};
    const Differential::Wheels dw{r.uniform(-1, 1), r.uniform(-1, 1)};
    const auto dp = d.by_parameters(dw);
    EXPECT_LT((dp.col(0) - slope([&](double h) {
                 return d.forward({dw.left * (1 + h), dw.right});
               })).norm(),
              1e-8);
    EXPECT_LT((dp.col(1) - slope([&](double h) {
                 return d.forward({dw.left, dw.right * (1 + h)});
               })).norm(),
              1e-8);
    EXPECT_LT(
        (dp.col(2) - slope([&](double h) { return Differential{d.track + h}.forward(dw); })).norm(),
        1e-7);
    const Ackermann a{r.uniform(0.3, 3)};
    const Ackermann::Wheels aw{r.uniform(-1, 1), r.uniform(-1.4, 1.4)};
    const auto ap = a.by_parameters(aw);
    EXPECT_LT((ap.col(0) - slope([&](double h) {
                 return a.forward({aw.way * (1 + h), aw.steering});
               })).norm(),
              1e-8);
    EXPECT_LT((ap.col(1) - slope([&](double h) {
                 return a.forward({aw.way, aw.steering + h});
               })).norm(),
              1e-8);
    EXPECT_LT((ap.col(2) - slope([&](double h) {
                 return Ackermann{a.wheelbase + h}.forward(aw);
               })).norm(),
              1e-7);
    const Omnidirectional o{r.uniform(0.2, 1)};
    const Omnidirectional::Wheels ow{r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1)};
    const auto op = o.by_parameters(ow);
    for (int k = 0; k < 3; ++k) {
      const auto scaled = [&](double h) {
        auto w = ow;
        w[k] *= 1 + h;
        return o.forward(w);
      };
      EXPECT_LT((op.col(k) - slope(scaled)).norm(), 1e-8);
    }
    EXPECT_LT((op.col(3) - slope([&](double h) {
                 return Omnidirectional{o.arm + h}.forward(ow);
               })).norm(),
              1e-7);
  }
}

// Two steered wheels, A006.

TEST(SteeredPair, MeanOfTheCotangents) {
  RandomStream r(6);
  constexpr double l = 2.8, track = 1.5;
  for (int i = 0; i < kMotions; ++i) {
    // The centre of the circle lies at R to the left, each front wheel stands across to it.
    const double radius = (r.below(2) == 0 ? -1 : 1) * std::pow(10.0, r.uniform(0.2, 12));
    const double left = std::atan(l / (radius - track / 2)),
                 right = std::atan(l / (radius + track / 2));
    const SteeredPair pair = steered_pair(left, right, l, track);
    ASSERT_NEAR(pair.steering, std::atan(l / radius), 1e-12);
    ASSERT_LT(pair.disagreement, 1e-12);
    ASSERT_TRUE(pair.consistent);
    ASSERT_NEAR(1 / std::tan(pair.steering), (1 / std::tan(left) + 1 / std::tan(right)) / 2,
                1e-9 * std::abs(radius));
    ASSERT_EQ(std::abs(left) > std::abs(right), radius > 0);  // the inner wheel is turned more
  }
  EXPECT_EQ(steered_pair(0, 0, l, track).steering, 0);
  EXPECT_TRUE(steered_pair(0, 0, l, track).consistent);
}

TEST(SteeredPair, WheelsThatDoNotFitAreReported) {
  // Parallel wheels in a bend: the outer one would need a larger circle than it is set to.
  const SteeredPair parallel = steered_pair(0.4, 0.4, 2.8, 1.5);
  EXPECT_FALSE(parallel.consistent);
  EXPECT_GT(parallel.disagreement, 0.05);
  EXPECT_NEAR(parallel.steering, 0.4, 1e-12);
  // Toe-in: apart in sign, the mean is straight ahead.
  const SteeredPair toe = steered_pair(0.05, -0.05, 2.8, 1.5);
  EXPECT_FALSE(toe.consistent);
  EXPECT_NEAR(toe.steering, 0, 1e-12);
  EXPECT_TRUE(steered_pair(0.05, -0.05, 2.8, 1.5, 0.2).consistent);
  // The outer wheel on the smaller circle.
  EXPECT_FALSE(steered_pair(0.3, 0.45, 2.8, 1.5).consistent);
}

}  // namespace
}  // namespace majak::motion
