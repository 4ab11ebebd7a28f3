// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/path_uncertainty.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "majak/core/random.hpp"
#include "majak/motion/wheel_noise.hpp"

namespace majak::motion {
namespace {

constexpr int kRuns = 100'000;
constexpr int kSteps = 40;  // of 0.25 m
constexpr double kChi95In2 = 5.991464547107979, kChi95In3 = 7.814727903251179;

/// A drive along a path: what its wheels report, step by step, and how a report with errors comes
/// about.
template <class Drive, class Wheels, class Perturb>
struct Course {
  Drive drive;
  std::vector<Wheels> wheels;
  Perturb perturb;  ///< wheels, random stream -> wheels
};

struct Coverage {
  double ellipse = 0, all = 0;  ///< share of the runs within 95 % of (x, y), of (x, y, theta)
  Mat3 sampled = Mat3::Zero(), stated = Mat3::Zero();
};

template <class C>
Coverage drive_many_times(const C& course, const WheelNoise& noise) {
  Pose2 T;
  PathUncertainty uncertainty;
  for (const auto& w : course.wheels) {
    const Vec3 twist = course.drive.forward(w);
    T = T * exp(twist);
    uncertainty.move(twist, random_part(noise, course.drive, w));
  }
  Coverage c;
  c.stated = uncertainty.covariance();
  const Mat3 information = c.stated.inverse();
  const Eigen::Matrix2d xy = Eigen::Matrix2d(c.stated.topLeftCorner<2, 2>()).inverse();
  const Pose2 T_inverse = T.inverse();
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(7, static_cast<std::uint64_t>(run));
    Pose2 truth;
    for (const auto& w : course.wheels)
      truth = truth * exp(course.drive.forward(course.perturb(w, random)));
    const Vec3 error = log(T_inverse * truth);
    c.sampled += error * error.transpose() / kRuns;
    const Vec2 e = error.head<2>();
    c.ellipse += e.dot(xy * e) <= kChi95In2 ? 1.0 / kRuns : 0;
    c.all += error.dot(information * error) <= kChi95In3 ? 1.0 / kRuns : 0;
  }
  return c;
}

void expect_honest(const Coverage& c) {
  EXPECT_NEAR(c.ellipse, 0.95, 0.01);
  EXPECT_NEAR(c.all, 0.95, 0.01);
  // Sampled noise is the analytic covariance: within 3 % of the larger entries (seen: up to 1.5 %).
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(c.sampled(i, j), c.stated(i, j),
                  0.03 * std::sqrt(c.stated(i, i) * c.stated(j, j)));
  }
}

double slipped(double way, const WheelNoise& noise, RandomStream& r) {
  return way + noise.slip * std::sqrt(std::abs(way)) * r.normal();
}

// 10 m along a bend to the left, then one to the right.
double bend(int step) { return step < kSteps / 2 ? 0.08 : -0.05; }  // rad a step

// Ellipses of (x, y) in the robot's axes and exponential coordinates, where the banana is straight.

TEST(PathUncertainty, HoldsDifferentialDrives) {
  const WheelNoise noise{.slip = 0.005};
  const Differential drive{0.4};
  std::vector<Differential::Wheels> wheels;
  for (int i = 0; i < kSteps; ++i) wheels.push_back(drive.inverse({0.25, 0, bend(i)}));
  const auto perturb = [&](const Differential::Wheels& w, RandomStream& r) {
    const double left = slipped(w.left, noise, r);
    return Differential::Wheels{left, slipped(w.right, noise, r)};
  };
  expect_honest(drive_many_times(
      Course<Differential, Differential::Wheels, decltype(perturb)>{drive, wheels, perturb},
      noise));
}

TEST(PathUncertainty, HoldsAckermannDrives) {
  const WheelNoise noise{.slip = 0.01, .steering = 0.02};
  const Ackermann drive{0.5};
  std::vector<Ackermann::Wheels> wheels;
  for (int i = 0; i < kSteps; ++i) wheels.push_back(drive.inverse({0.25, 0, bend(i)}));
  const auto perturb = [&](const Ackermann::Wheels& w, RandomStream& r) {
    const double way = slipped(w.way, noise, r);
    return Ackermann::Wheels{way, w.steering + noise.steering * r.normal()};
  };
  expect_honest(drive_many_times(
      Course<Ackermann, Ackermann::Wheels, decltype(perturb)>{drive, wheels, perturb}, noise));
}

TEST(PathUncertainty, HoldsOmnidirectionalDrives) {
  const WheelNoise noise{.slip = 0.008};
  const Omnidirectional drive{0.25};
  std::vector<Omnidirectional::Wheels> wheels;  // slides to the side all the while
  for (int i = 0; i < kSteps; ++i) wheels.push_back(drive.inverse({0.2, 0.15, bend(i)}));
  const auto perturb = [&](Omnidirectional::Wheels w, RandomStream& r) {
    for (double& way : w) way = slipped(way, noise, r);
    return w;
  };
  expect_honest(drive_many_times(
      Course<Omnidirectional, Omnidirectional::Wheels, decltype(perturb)>{drive, wheels, perturb},
      noise));
}

TEST(PathUncertainty, HoldsMecanumDrives) {
  const WheelNoise noise{.slip = 0.008};
  const WheelMatrix matrix(mecanum_wheels(0.6, 0.4));
  // Four wheels at once, without the heap.
  struct Mecanum {
    Eigen::Matrix<double, 3, 4> by_wheels;
    Vec3 forward(const Eigen::Vector4d& rolled) const { return by_wheels * rolled; }
  };
  const Mecanum drive{matrix.by_wheels()};
  std::vector<Eigen::Vector4d> wheels;
  PathUncertainty uncertainty;
  Pose2 T;
  for (int i = 0; i < kSteps; ++i) {
    wheels.emplace_back(matrix.inverse({0.2, 0.15, bend(i)}));
    const Vec3 twist = drive.forward(wheels.back());
    T = T * exp(twist);
    uncertainty.move(twist, random_part(noise, matrix, wheels.back()));
  }
  const Eigen::Matrix2d xy =
      Eigen::Matrix2d(uncertainty.covariance().topLeftCorner<2, 2>()).inverse();
  double inside = 0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream r(10, static_cast<std::uint64_t>(run));
    Pose2 truth;
    for (const Eigen::Vector4d& w : wheels) {
      Eigen::Vector4d rolled;
      for (int k = 0; k < 4; ++k) rolled[k] = slipped(w[k], noise, r);
      truth = truth * exp(drive.forward(rolled));
    }
    const Vec2 e = log(between(T, truth)).head<2>();
    inside += e.dot(xy * e) <= kChi95In2 ? 1.0 / kRuns : 0;
  }
  EXPECT_NEAR(inside, 0.95, 0.01);
}

/// The same law for what is constantly wrong, drawn once a run.
TEST(PathUncertainty, HoldsWheelsThatAreWrongAllTheWay) {
  const Vec3 sigma(0.001, 0.001, 0.004);  // left, right radius; m of track
  const Differential drive{0.4};
  const Mat3 parameters = sigma.cwiseAbs2().asDiagonal();
  PathUncertainty uncertainty{ParameterCovariance(parameters)};
  std::vector<Differential::Wheels> wheels;
  Pose2 T;
  for (int i = 0; i < kSteps; ++i) {
    wheels.push_back(drive.inverse({0.25, 0, bend(i)}));
    const Vec3 twist = drive.forward(wheels.back());
    T = T * exp(twist);
    uncertainty.move(twist, Mat3::Zero(), drive.by_parameters(wheels.back()));
  }
  Mat3 sampled = Mat3::Zero();
  double inside = 0;
  const Eigen::Matrix2d xy =
      Eigen::Matrix2d(uncertainty.covariance().topLeftCorner<2, 2>()).inverse();
  for (int run = 0; run < kRuns; ++run) {
    RandomStream r(8, static_cast<std::uint64_t>(run));
    const double left = 1 + sigma[0] * r.normal(), right = 1 + sigma[1] * r.normal();
    const Differential other{0.4 + sigma[2] * r.normal()};
    Pose2 truth;
    for (const auto& w : wheels)
      truth = truth * exp(other.forward({w.left * left, w.right * right}));
    const Vec3 error = log(between(T, truth));
    sampled += error * error.transpose() / kRuns;
    inside += error.head<2>().dot(xy * error.head<2>()) <= kChi95In2 ? 1.0 / kRuns : 0;
  }
  EXPECT_NEAR(inside, 0.95, 0.01);
  EXPECT_LT((sampled - uncertainty.covariance()).norm(), 0.03 * sampled.norm());
}

/// Sigma points (Julier, Uhlmann 1997) instead of derivatives: an independent account of one step.
Mat3 by_sigma_points(const Mat3& before, const Differential& drive, const Differential::Wheels& w,
                     const Vec2& sigma) {
  Eigen::Matrix<double, 5, 5> joint = Eigen::Matrix<double, 5, 5>::Zero();
  joint.topLeftCorner<3, 3>() = before;
  joint(3, 3) = sigma[0] * sigma[0];
  joint(4, 4) = sigma[1] * sigma[1];
  const Eigen::Matrix<double, 5, 5> root =
      Eigen::Matrix<double, 5, 5>((5.0 * joint).llt().matrixL());
  const Pose2 nominal = exp(drive.forward(w));
  Mat3 sum = Mat3::Zero();
  for (int k = 0; k < 5; ++k) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Matrix<double, 5, 1> x = sign * root.col(k);
      const Pose2 after =
          exp(Vec3(x.head<3>())) * exp(drive.forward({w.left + x[3], w.right + x[4]}));
      const Vec3 error = log(between(nominal, after));
      sum += error * error.transpose() / 10;
    }
  }
  return sum;
}

TEST(PathUncertainty, SigmaPointsAgree) {
  const WheelNoise noise{.slip = 0.002};
  const Differential drive{0.4};
  PathUncertainty uncertainty;
  Mat3 twin = 1e-12 * Mat3::Identity();
  for (int i = 0; i < kSteps; ++i) {
    const auto w = drive.inverse({0.25, 0, bend(i)});
    uncertainty.move(drive.forward(w), random_part(noise, drive, w));
    twin =
        by_sigma_points(twin, drive, w, noise.slip * Vec2(std::sqrt(w.left), std::sqrt(w.right)));
  }
  // They differ by the square of the errors: seen 0.3 %.
  EXPECT_LT((twin - uncertainty.covariance()).norm(), 0.01 * twin.norm());
}

TEST(PathUncertainty, ManyShortStepsAreOneLongOne) {
  const OdometryNoise noise;
  PathUncertainty one(constant_covariance(noise)), many(constant_covariance(noise));
  const Vec3 twist(2, 0, 0.6);
  // What does not depend on where within the step it arises: the constant part.
  one.move(twist, Mat3::Zero(), constant_part(twist));
  for (int i = 0; i < 1000; ++i) many.move(twist / 1000, Mat3::Zero(), constant_part(twist / 1000));
  EXPECT_LT((one.covariance() - many.covariance()).norm(), 1e-12);
  // Random parts of a straight way: heading errors act over the rest of the way, q way^3 / 3.
  PathUncertainty straight;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 step(0.01, 0, 0);
    straight.move(step, random_part({.way = 0, .side = 0, .turn = 0, .turn_per_way = 0.02}, step));
  }
  EXPECT_NEAR(straight.covariance()(2, 2), 4e-4 * 10, 1e-12);
  EXPECT_NEAR(straight.covariance()(1, 1), 4e-4 * 1000 / 3, 1e-6);
}

// No information comes in, so the volume of the ellipsoid never falls; its trace may, on the way
// back, when the same heading error undoes what it did.
TEST(PathUncertainty, VolumeNeverFalls) {
  RandomStream r(9);
  const OdometryNoise noise;
  PathUncertainty uncertainty;
  double volume = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 twist(r.uniform(-0.3, 0.3), r.uniform(-0.1, 0.1), r.uniform(-1, 1));
    uncertainty.move(twist, random_part(noise, twist));
    ASSERT_GE(uncertainty.covariance().determinant(), volume * (1 - 1e-9));
    ASSERT_TRUE(Eigen::LLT<Mat3>(uncertainty.covariance()).info() == Eigen::Success);
    volume = uncertainty.covariance().determinant();
  }
}

TEST(PathUncertainty, MapAxesAreTurnedByTheHeading) {
  const Mat3 covariance = Vec3(4, 1, 0.1).asDiagonal();
  const Mat3 turned = in_map_axes(covariance, kPi / 2);
  EXPECT_NEAR(turned(0, 0), 1, 1e-15);
  EXPECT_NEAR(turned(1, 1), 4, 1e-15);
  EXPECT_NEAR(turned(2, 2), 0.1, 1e-15);
}

TEST(WheelNoise, MatricesAndClosedFormsAgree) {
  const WheelNoise noise;
  const Omnidirectional closed{0.3};
  const WheelMatrix matrix(omni_wheels(3, 0.3));
  const Omnidirectional::Wheels w{0.2, -0.1, 0.3};
  const Mat3 a = random_part(noise, closed, w),
             b = random_part(noise, matrix, Eigen::Vector3d(0.2, -0.1, 0.3));
  EXPECT_LT((a - b).norm(), 1e-18);
}

TEST(WheelNoise, CarsErrByTheWayWhateverTheRateOfRecords) {
  const CarNoise noise;
  const Ackermann drive{2.83};
  const auto drive_in = [&](int steps) {
    PathUncertainty u(constant_covariance(noise, drive));
    for (int i = 0; i < steps; ++i) {
      const Ackermann::Wheels w{50.0 / steps, 0.1};
      u.move(drive.forward(w), random_part(noise, drive, w), drive.by_parameters(w));
    }
    return u.covariance();
  };
  EXPECT_LT((drive_in(1000) - drive_in(4000)).norm(), 1e-3 * drive_in(1000).norm());
  EXPECT_EQ(random_part(noise, drive, {0, 0.1}), Mat3::Zero().eval());
}

}  // namespace
}  // namespace majak::motion
