// SPDX-License-Identifier: Apache-2.0
#include "majak/map/relations.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace majak::map {
namespace {

Segment wall(const Vec2& a, const Vec2& b, double sigma = 0.001) {
  Segment s;
  s.a = a, s.b = b;
  s.covariance << sigma * sigma, 0, 0, 12 * sigma * sigma / (b - a).squaredNorm();
  s.sigma_a = s.sigma_b = 0.003;
  return s;
}

std::vector<Relation> of_kind(const std::vector<Relation>& all, RelationKind kind) {
  std::vector<Relation> found;
  std::copy_if(all.begin(), all.end(), std::back_inserter(found),
               [&](const Relation& r) { return r.kind == kind; });
  return found;
}

/// A room of 4 x 3 m seen from inside, with a door of 0.9 m in the wall along y = 0.
std::vector<Segment> room() {
  return {wall({0, 0}, {1.5, 0}), wall({2.4, 0}, {4, 0}), wall({4, 0}, {4, 3}),
          wall({4, 3}, {0, 3}), wall({0, 3}, {0, 0})};
}

TEST(Relations, OfARoomWithADoor) {
  const auto all = relations(room());
  const auto openings = of_kind(all, RelationKind::opening);
  ASSERT_EQ(openings.size(), 1U);
  EXPECT_NEAR(openings[0].value, 0.9, 1e-12);
  EXPECT_NEAR(openings[0].sigma, 0.003 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(openings[0].place.x(), 1.95, 1e-12);
  EXPECT_EQ(of_kind(all, RelationKind::collinear).size(), 1U);

  const auto corners = of_kind(all, RelationKind::corner);
  ASSERT_EQ(corners.size(), 4U);
  for (const Relation& c : corners) EXPECT_NEAR(c.value, kPi / 2, 1e-9) << "seen from inside";
  EXPECT_EQ(of_kind(all, RelationKind::perpendicular).size(), 4U);

  const auto parallel = of_kind(all, RelationKind::parallel);
  ASSERT_EQ(parallel.size(), 3U) << "both parts of the wall with the door, and the side walls";
  EXPECT_NEAR(parallel[0].value, 3, 1e-9);
}

TEST(Relations, AnOutsideCornerHasThreeRightAngles) {
  // The same two walls seen from the other side.
  const auto corners = of_kind(relations(std::vector{wall({1, 0}, {0, 0}), wall({0, 0}, {0, 1})}),
                               RelationKind::corner);
  ASSERT_EQ(corners.size(), 1U);
  const auto other = of_kind(relations(std::vector{wall({0, 0}, {1, 0}), wall({0, 1}, {0, 0})}),
                             RelationKind::corner);
  ASSERT_EQ(other.size(), 1U);
  EXPECT_NEAR(corners[0].value + other[0].value, 2 * kPi, 1e-9);
  EXPECT_NEAR(other[0].value, kPi / 2, 1e-9);
}

TEST(Relations, DoNotHangOnFrameOrOrder) {
  const auto plain = relations(room());
  auto turned = room();
  for (Segment& s : turned) s = moved({3, -7, 1.1}, s);
  const auto there = relations(turned);
  ASSERT_EQ(there.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(there[i].kind, plain[i].kind);
    EXPECT_NEAR(there[i].value, plain[i].value, 1e-9);
    EXPECT_NEAR(there[i].sigma, plain[i].sigma, 1e-9);
  }
  auto reversed = room();
  std::reverse(reversed.begin(), reversed.end());
  const auto back = relations(reversed);
  for (const auto kind : {RelationKind::parallel, RelationKind::perpendicular,
                          RelationKind::collinear, RelationKind::corner, RelationKind::opening})
    EXPECT_EQ(of_kind(back, kind).size(), of_kind(plain, kind).size()) << name_of(kind);
}

TEST(Relations, AnOpeningWithSomethingInItIsNone) {
  auto walls = room();
  walls.push_back(wall({1.9, 0.3}, {1.9, -0.3}));
  EXPECT_TRUE(of_kind(relations(walls), RelationKind::opening).empty());
}

TEST(Relations, TheTwoSidesOfAWallAreParallelNotCollinear) {
  const auto all = relations(std::vector{wall({0, 0}, {4, 0}), wall({4, -0.15}, {0, -0.15})});
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].kind, RelationKind::parallel);
  EXPECT_NEAR(all[0].value, 0.15, 1e-12);
}

TEST(Relations, WhatIsKnownWorseMayBeTurnedMore) {
  EXPECT_TRUE(relations(std::vector{wall({0, 0}, {1, 0}), wall({0, 1}, {1, 1.08})}).empty());
  EXPECT_EQ(
      relations(std::vector{wall({0, 0}, {1, 0}, 0.02), wall({0, 1}, {1, 1.08}, 0.02)}).size(), 1U);
}

TEST(Relations, NothingOfNothing) {
  EXPECT_TRUE(relations({}).empty());
  EXPECT_TRUE(relations(std::vector{wall({0, 0}, {1, 0})}).empty());
}

}  // namespace
}  // namespace majak::map
