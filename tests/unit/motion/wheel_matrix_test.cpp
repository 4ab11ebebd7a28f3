// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/wheel_matrix.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/motion/drive.hpp"

namespace majak::motion {
namespace {

Vec3 any_twist(RandomStream& r) { return {r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-2, 2)}; }

TEST(WheelMatrix, ThreeOmniWheelsAreTheClosedForm) {
  RandomStream r(1);
  const WheelMatrix matrix(omni_wheels(3, 0.3));
  const Omnidirectional closed{0.3};
  EXPECT_LT((matrix.by_wheels() - closed.by_wheels()).norm(), 1e-14);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 twist = any_twist(r);
    const Eigen::VectorXd rolled = matrix.inverse(twist);
    const auto expected = closed.inverse(twist);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(rolled[k], expected[k], 1e-14);
  }
}

TEST(WheelMatrix, BothWaysRoundForManyWheels) {
  RandomStream r(2);
  for (const auto& wheels :
       {omni_wheels(3, 0.2), omni_wheels(4, 0.3), omni_wheels(7, 0.5), mecanum_wheels(0.6, 0.4)}) {
    const WheelMatrix drive(wheels);
    for (int i = 0; i < 25'000; ++i) {  // 10^5 in all
      const Vec3 twist = any_twist(r);
      const auto motion = drive.forward(drive.inverse(twist));
      ASSERT_LT((motion.twist - twist).norm(), 1e-13);
      ASSERT_LT(motion.slip.norm(), 1e-13);
    }
  }
}

// What is printed in every description of a mecanum drive: w = (+-) sums of x, y and (a + b) turn.
TEST(WheelMatrix, MecanumIsTheTextbookForm) {
  RandomStream r(3);
  const double length = 0.6, width = 0.4, lever = (length + width) / 2;
  const WheelMatrix drive(mecanum_wheels(length, width));
  for (int i = 0; i < 1000; ++i) {
    const Vec3 t = any_twist(r);
    const Eigen::Vector4d expected(t.x() - t.y() - lever * t.z(), t.x() + t.y() + lever * t.z(),
                                   t.x() + t.y() - lever * t.z(), t.x() - t.y() + lever * t.z());
    EXPECT_LT((drive.inverse(t) - expected).norm(), 1e-14);
  }
}

TEST(WheelMatrix, SlipOfOneWheelShowsAndIsShared) {
  const WheelMatrix drive(mecanum_wheels(0.6, 0.4));
  Eigen::VectorXd rolled = drive.inverse({0.5, 0.1, 0.2});
  rolled[2] += 0.04;
  const auto motion = drive.forward(rolled);
  // Four wheels, three unknowns: a quarter of a wheel's error is left over, in all four alike.
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(std::abs(motion.slip[k]), 0.01, 1e-14);
  // The normal equations: what is left over is no motion.
  EXPECT_LT((drive.by_wheels() * motion.slip).norm(), 1e-15);
}

TEST(WheelMatrix, DerivativesAreThoseOfTheMotion) {
  RandomStream r(4);
  const WheelMatrix drive(omni_wheels(5, 0.35));
  Eigen::VectorXd rolled(5);
  for (int k = 0; k < 5; ++k) rolled[k] = r.uniform(-1, 1);
  const auto scales = drive.by_scales(rolled);
  for (int k = 0; k < 5; ++k) {
    Eigen::VectorXd more = rolled, scaled = rolled;
    more[k] += 1;
    scaled[k] *= 2;
    const Vec3 at = drive.forward(rolled).twist;
    EXPECT_LT((drive.forward(more).twist - at - drive.by_wheels().col(k)).norm(), 1e-14);
    EXPECT_LT((drive.forward(scaled).twist - at - scales.col(k)).norm(), 1e-14);
  }
}

TEST(WheelMatrix, WheelsThatDoNotTellAreRefused) {
  EXPECT_THROW(WheelMatrix({}), Error);
  EXPECT_THROW(WheelMatrix(omni_wheels(2, 0.3)), Error);
  // All roll ahead: nothing tells of motion to the side.
  EXPECT_THROW(WheelMatrix({{{0, 0.2}, 0, 0}, {{0, -0.2}, 0, 0}, {{0.3, 0.2}, 0, 0}}), Error);
  EXPECT_THROW(WheelMatrix({{{0, 0.2}, 0, kPi / 2}, {{0, -0.2}, 1, 0}, {{0.3, 0.2}, 2, 0}}), Error);
}

}  // namespace
}  // namespace majak::motion
