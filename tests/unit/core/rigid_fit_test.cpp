// SPDX-License-Identifier: Apache-2.0
#include "majak/core/rigid_fit.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "majak/core/random.hpp"

namespace majak {
namespace {

TEST(RigidFit, FindsTheMotionThatWasMade) {
  for (const double theta : {0.0, 1e-9, 0.7, -2.5, kPi}) {
    const Pose2 T{3, -2, theta};
    std::vector<Vec2> a{{0, 0}, {2, 0}, {2, 1}, {-1, 4}}, b;
    for (const Vec2& p : a) b.push_back(T * p);
    const Pose2 off = between(T, rigid_fit(a, b));
    EXPECT_LT(off.vector().norm(), 1e-14) << theta;
  }
}

TEST(RigidFit, IsTheLeastSquares) {
  RandomStream random(1);
  std::vector<Vec2> a, b;
  for (int i = 0; i < 20; ++i) {
    a.emplace_back(random.normal(), random.normal());
    b.push_back(Pose2{1, 2, 0.5} * a.back() + 0.3 * Vec2(random.normal(), random.normal()));
  }
  const auto cost = [&](const Pose2& T) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (T * a[i] - b[i]).squaredNorm();
    return sum;
  };
  const Pose2 best = rigid_fit(a, b);
  for (int k = 0; k < 3; ++k)
    for (const double step : {-1e-3, 1e-3}) {
      Vec3 aside = Vec3::Zero();
      aside(k) = step;
      EXPECT_GT(cost(best * exp(aside)), cost(best));
    }
}

TEST(RigidFit, OnePointIsAShift) {
  const std::vector<Vec2> a{{1, 1}}, b{{4, -1}};
  const Pose2 T = rigid_fit(a, b);
  EXPECT_EQ(T, (Pose2{3, -2, 0}));
}

}  // namespace
}  // namespace majak
