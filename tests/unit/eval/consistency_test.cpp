// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/consistency.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "majak/core/random.hpp"

namespace majak::eval {
namespace {

Mat3 some_covariance() {
  Mat3 root;
  root << 0.3, 0, 0, 0.1, 0.2, 0, 0.02, -0.01, 0.05;
  return root * root.transpose();
}

TEST(Nees, OfAKnownError) {
  Mat3 covariance = Mat3::Zero();
  covariance.diagonal() << 0.04, 0.01, 0.0025;
  const auto value = nees({1.2, 2.1, kPi - 0.01}, covariance, {1.0, 2.0, -kPi + 0.04});
  ASSERT_TRUE(value);
  EXPECT_NEAR(*value, 1 + 1 + 1, 1e-9);  // each by one sigma, the angle across the seam
}

TEST(Nees, RefusesACovarianceThatIsNone) {
  EXPECT_FALSE(nees({}, Mat3::Zero(), {}));
  EXPECT_FALSE(nees({}, -Mat3::Identity(), {}));
  EXPECT_FALSE(nees({}, Mat3::Constant(std::nan("")), {}));
}

TEST(Nees, OfHonestErrorsStandsInTheBandAndOfOthersDoesNot) {
  const Mat3 covariance = some_covariance();
  const Mat3 root = covariance.llt().matrixL();
  RandomStream random(11);
  std::vector<double> honest, timid, bold;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 e = root * Vec3(random.normal(), random.normal(), random.normal());
    const Pose2 truth{3, 4, 1};
    const Pose2 estimate{3 + e.x(), 4 + e.y(), 1 + e.z()};
    honest.push_back(*nees(estimate, covariance, truth));
    timid.push_back(*nees(estimate, 2 * covariance, truth));
    bold.push_back(*nees(estimate, 0.5 * covariance, truth));
  }
  const auto h = summarize_nees(honest);
  EXPECT_TRUE(h.inside_band()) << h.mean;
  EXPECT_NEAR(h.inside_share, 0.95, 0.015);
  EXPECT_LT(summarize_nees(timid).mean, summarize_nees(timid).band_low);
  EXPECT_GT(summarize_nees(bold).mean, summarize_nees(bold).band_high);
  EXPECT_FALSE(summarize_nees({}).inside_band());
}

TEST(NeesOfRun, MovesTheTruthToTheFirstPoseOfTheMap) {
  std::vector<Estimate> estimates(3);
  Trajectory truth;
  const Pose2 T_world_map{10, 20, 2};
  for (int i = 0; i < 3; ++i) {
    const Pose2 true_pose{1.0 * i, 0, 0};
    Estimate& estimate = estimates[static_cast<std::size_t>(i)];
    estimate.time = i * kSecond;
    estimate.T_map_robot = true_pose;
    estimate.covariance.setIdentity();
    truth.push_back({i * kSecond, T_world_map * true_pose});
  }
  estimates[0].covariance.setZero();  // the pose that fixes the map
  estimates[2].T_map_robot.y += 2;
  const auto samples = nees_of_run(estimates, truth);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_NEAR(samples[0], 0, 1e-12);
  EXPECT_NEAR(samples[1], 4, 1e-9);
}

}  // namespace
}  // namespace majak::eval
