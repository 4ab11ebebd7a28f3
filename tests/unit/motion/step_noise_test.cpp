// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/step_noise.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "majak/core/chi_square.hpp"
#include "majak/core/random.hpp"

namespace majak::motion {
namespace {

Vec3 draw(const Mat3& covariance, RandomStream& random) {
  const Vec3 n(random.normal(), random.normal(), random.normal());
  const Eigen::LDLT<Mat3> ldlt(covariance);
  const Vec3 scaled = ldlt.vectorD().cwiseMax(0).cwiseSqrt().cwiseProduct(n);
  return ldlt.transpositionsP().transpose() * Vec3(ldlt.matrixL() * scaled);
}

// Steps of 0.4 s at all sorts of speeds, some of them turns on the spot, with this noise.
std::vector<SeenStep> simulated(int n, const StepNoise& noise, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<SeenStep> out;
  Vec3 before = Vec3::Zero(), velocity_before = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    SeenStep s;
    s.seconds = 0.4;
    const bool on_the_spot = random.uniform() < 0.3;
    const Vec3 twist(on_the_spot ? 0 : random.uniform(-0.4, 0.6), 0,
                     on_the_spot || random.uniform() < 0.5 ? random.uniform(-0.6, 0.6) : 0);
    s.way = std::abs(twist.x()), s.turn = std::abs(twist.z());
    s.wheels = exp(twist);
    s.velocity_before = velocity_before;
    s.velocity_after = velocity_before = Vec3(random.uniform(-1, 2), 0, random.uniform(-1, 1));
    const Vec3 after = draw(noise.pose(s.velocity_after, Vec3::Zero()), random);
    const Vec3 rolled = draw(noise.wheels(s.way, s.turn), random);
    if (i == 0) before = draw(noise.pose(velocity_before, Vec3::Zero()), random);
    s.laser = exp(Vec3(-before)) * s.wheels * exp(rolled) * exp(after);
    before = after;
    out.push_back(s);
  }
  return out;
}

// The slow twin: the covariance of all the errors at once.
Eigen::MatrixXd dense(const std::vector<SeenStep>& steps, const StepNoise& noise) {
  const auto n = static_cast<Eigen::Index>(steps.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const SeenStep& s = steps[static_cast<std::size_t>(i)];
    const Mat3 A = adjoint(s.wheels.inverse());
    const Mat3 before = noise.pose(s.velocity_before, s.doubt_before) -
                        noise.wheels(s.split_way_before, s.split_turn_before);
    const Mat3 after = noise.pose(s.velocity_after, s.doubt_after) -
                       noise.wheels(s.split_way_after, s.split_turn_after);
    C.block<3, 3>(3 * i, 3 * i) =
        noise.wheels(s.way, s.turn) + 4e-8 * Mat3::Identity() + after + A * before * A.transpose();
    if (i == 0) continue;
    C.block<3, 3>(3 * i, 3 * i - 3) = -A * before;
    C.block<3, 3>(3 * i - 3, 3 * i) = -before * A.transpose();
  }
  return C;
}

Eigen::VectorXd errors(const std::vector<SeenStep>& steps) {
  Eigen::VectorXd e(3 * static_cast<Eigen::Index>(steps.size()));
  for (std::size_t i = 0; i < steps.size(); ++i)
    e.segment<3>(3 * static_cast<Eigen::Index>(i)) = steps[i].error();
  return e;
}

// With shared samples and doubt at the poses between the steps.
std::vector<SeenStep> shared(int n) {
  auto steps = simulated(n, {}, 5);
  RandomStream random(6);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    SeenStep &a = steps[i - 1], &b = steps[i];
    a.split_way_after = b.split_way_before = random.uniform(0, 0.02);
    a.split_turn_after = b.split_turn_before = random.uniform(0, 0.02);
    a.doubt_after = b.doubt_before = Vec3(random.uniform(0, 0.004), 0, random.uniform(0, 0.002));
  }
  return steps;
}

TEST(StepNoise, OfAPoseAndOfWheels) {
  const StepNoise n{1, 2, 3, 4, 5, 6, 0.5};
  Mat3 pose = Vec3(1 + 4, 1, 4 + 0.01).asDiagonal();
  pose += 0.25 * Vec3(1, 2, 3) * Vec3(1, 2, 3).transpose();
  EXPECT_NEAR((n.pose({1, 2, 3}, {2, 0, -0.1}) - pose).norm(), 0, 1e-14);
  // A turn on the spot rolls the wheels by 0.2 m/rad, too.
  const Mat3 wheels = Vec3(9 * 2.6, 16 * 2.6, 25 * 2 + 36 * 3).asDiagonal();
  EXPECT_NEAR((n.wheels(2, 3) - wheels).norm(), 0, 1e-13);
}

TEST(WhitenedSteps, EqualTheJointGaussian) {
  const StepNoise noise{0.004, 0.002, 0.02, 0.01, 0.015, 0.012, 0.004};
  const auto steps = shared(40);
  const WhitenedSteps white(steps, noise);
  const Eigen::LLT<Eigen::MatrixXd> llt(dense(steps, noise));
  ASSERT_EQ(llt.info(), Eigen::Success);
  const Eigen::VectorXd e = errors(steps);
  const double squares = e.dot(llt.solve(e)),
               log_det = 2 * Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum();
  double nis = 0;
  for (std::size_t i = 0; i < white.size(); ++i) nis += white.nis(i);
  EXPECT_NEAR(nis, squares, 1e-9 * squares);
  EXPECT_NEAR(white.log_likelihood(), -0.5 * (squares + log_det), 1e-9 * std::abs(log_det));
}

TEST(WhitenedSteps, TurnRowsAsTheyTurnErrors) {
  const auto steps = shared(20);
  const WhitenedSteps white(steps, {});
  Vec3 before = Vec3::Zero();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Vec3 v = white.whiten<Vec3>(i, steps[i].error(), before);
    EXPECT_NEAR((v - white.innovation(i)).norm(), 0, 1e-16);
    EXPECT_NEAR(v.dot(white.weight(i) * v), white.nis(i), 1e-12 * (1 + white.nis(i)));
    before = v;
  }
}

// E(q | e) = Cov(q, e) Cov(e)^-1 e; Cov(q_i, .) is Q_i less what is shared out at its ends.
TEST(WhitenedSteps, TheWheelsErrorsAreTheirConditionalMean) {
  const StepNoise noise;
  const auto steps = shared(30);
  const auto found = WhitenedSteps(steps, noise).wheel_errors();
  const Eigen::VectorXd lambda = dense(steps, noise).llt().solve(errors(steps));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const SeenStep& s = steps[i];
    const auto at = [&](std::size_t k) -> Vec3 {
      return k < steps.size() ? Vec3(lambda.segment<3>(3 * static_cast<Eigen::Index>(k)))
                              : Vec3(Vec3::Zero());
    };
    const Mat3 A = adjoint(s.wheels.inverse());
    Vec3 after = at(i), before = -A.transpose() * at(i);
    if (i + 1 < steps.size())
      after -= adjoint(steps[i + 1].wheels.inverse()).transpose() * at(i + 1);
    if (i > 0) before += at(i - 1);
    const Vec3 mean = (noise.wheels(s.way, s.turn) + 4e-8 * Mat3::Identity()) * at(i) -
                      noise.wheels(s.split_way_after, s.split_turn_after) * after +
                      A * noise.wheels(s.split_way_before, s.split_turn_before) * before;
    EXPECT_NEAR((found[i] - mean).norm(), 0, 1e-12);
  }
}

TEST(WhitenedSteps, RightNoiseHasANisOfThree) {
  const StepNoise noise;
  const int n = 4000;
  const auto steps = simulated(n, noise, 11);
  const WhitenedSteps white(steps, noise);
  double nis = 0;
  for (std::size_t i = 0; i < white.size(); ++i) nis += white.nis(i);
  EXPECT_GT(nis, chi_square_quantile(0.001, 3 * n));
  EXPECT_LT(nis, chi_square_quantile(0.999, 3 * n));
}

// As if the row were not there.
TEST(WhitenedSteps, ABrokenStepTellsNothing) {
  auto steps = shared(20);
  steps[8].broken = true;
  const WhitenedSteps white(steps, {});
  EXPECT_TRUE(white.broken(8));
  steps[8].broken = false, steps[8].laser = Pose2{50, 1, 2};
  const WhitenedSteps gated(steps, {}, 100);
  EXPECT_TRUE(gated.broken(8));
  EXPECT_EQ(white.log_likelihood(), gated.log_likelihood());
  const std::vector<SeenStep> head(steps.begin(), steps.begin() + 8),
      tail(steps.begin() + 9, steps.end());
  EXPECT_NEAR(white.log_likelihood(),
              WhitenedSteps(head, {}).log_likelihood() + WhitenedSteps(tail, {}).log_likelihood(),
              1e-9);
}

TEST(LearnNoise, FindsWhatWasSimulated) {
  const StepNoise truth{0.006, 0.003, 0.02, 0.012, 0.015, 0.02, 0.006};
  // Seen: rotation of the laser 0.81, all others 0.92 ... 1.12.
  for (std::uint64_t seed = 30; seed < 50; ++seed) {
    const StepNoise found = learn_noise(simulated(2000, truth, seed), {});
    for (const auto value :
         {&StepNoise::laser_translation, &StepNoise::laser_rotation, &StepNoise::ahead,
          &StepNoise::aside, &StepNoise::turn_of_way, &StepNoise::turn_of_turn, &StepNoise::jitter})
      EXPECT_NEAR(found.*value / (truth.*value), 1, 0.2) << seed;
  }
}

}  // namespace
}  // namespace majak::motion
