// SPDX-License-Identifier: Apache-2.0
#include "majak/match/cell_attributes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace majak::match {
namespace {

/// Two rows of three cells of half a metre.
const CellAttributes kFloor{0.5, -1, 2, 3, 2, {0, 1, 2, 1, kNoAttribute, 0}};

TEST(CellAttributes, AreReadWhereTheyLie) {
  EXPECT_EQ(kFloor.at({-0.9, 2.1}), 0);
  EXPECT_EQ(kFloor.at({-0.3, 2.49}), 1);
  EXPECT_EQ(kFloor.at({0.49, 2.0}), 2);
  EXPECT_EQ(kFloor.at({-1.0, 2.5}), 1);
  EXPECT_EQ(kFloor.at({0.2, 2.9}), 0);
  EXPECT_TRUE(std::isnan(kFloor.at({-0.2, 2.7})));
  for (const Vec2& outside : {Vec2(-1.01, 2.1), Vec2(0.5, 2.1), Vec2(0, 1.99), Vec2(0, 3),
                              Vec2(std::nan(""), 2.1), Vec2(1e300, 2.1)})
    EXPECT_TRUE(std::isnan(kFloor.at(outside))) << outside.transpose();
}

TEST(ClassSense, IsTheRowOfWhatIsThere) {
  const ClassSense colour{3, {0.8, 0.1, 0.1, 0.2, 0.7, 0.1, 0.05, 0.05, 0.9}};
  EXPECT_EQ(colour(0, 0), 0.8);
  EXPECT_EQ(colour(0, 1), 0.2);
  EXPECT_EQ(colour(2, 1), 0.1);
  EXPECT_EQ(colour(1, 2), 0.05);
  EXPECT_DOUBLE_EQ(colour(0, kNoAttribute), (0.8 + 0.2 + 0.05) / 3);
  for (const float there : {0.0F, 1.0F, 2.0F, kNoAttribute})
    EXPECT_NEAR(colour(0, there) + colour(1, there) + colour(2, there), 1, 1e-15) << there;
}

TEST(NumberSense, IsADensity) {
  const NumberSense reflectivity{0.05, 0.1, 1};
  for (const float there : {0.5F, kNoAttribute}) {
    double sum = 0;
    for (int i = 0; i < 10000; ++i) sum += reflectivity((i + 0.5) / 10000, there) / 10000;
    EXPECT_NEAR(sum, 1, 1e-9) << there;
  }
  EXPECT_DOUBLE_EQ(reflectivity(0.5, 0.5F), 0.9 / (std::sqrt(2 * kPi) * 0.05) + 0.1);
  EXPECT_NEAR(reflectivity(0.9, 0.3F), 0.1, 1e-12) << "a gross error";
}

}  // namespace
}  // namespace majak::match
