// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/held_out_fixes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace majak::eval {
namespace {

/// A car that drives east at 1 m/s; one letter a fifth of a second: '.' no fix, 'o' a fix, 'x' one
/// that is 2 m too far north.
std::vector<Event> drive(const std::string& fixes, bool car = true) {
  std::vector<Event> events;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const double t = 0.2 * static_cast<double>(i);
    const Time time = from_seconds(t);
    if (car)
      events.push_back(WheelMotion{.time = time, .speed = 1, .steering = 0});
    else
      events.push_back(Odometry{time, {t, 0, 0}, {}, {}});
    if (fixes[i] == '.') continue;
    GpsFix fix;
    fix.time = time, fix.east = t, fix.north = fixes[i] == 'x' ? 2 : 0;
    events.push_back(fix);
  }
  return events;
}

/// 's' a sound fix, 'u' one that is not.
std::string verdicts(const ReferenceFixes& reference) {
  std::string text;
  for (const ReferenceFix& fix : reference.fixes) text += fix.sound ? 's' : 'u';
  return text;
}

const std::string kGap(26, '.');  // 5.2 s and more

TEST(ReferenceFixes, BurstsAreApartByMoreThanFiveSeconds) {
  const std::string less(20, '.');
  const auto reference = reference_fixes(drive("oooooo" + less + "oo" + kGap + "ooo"), 2.7);
  EXPECT_EQ(reference.bursts, 2U);
  ASSERT_EQ(reference.fixes.size(), 11U);
  for (std::size_t i = 0; i < 11; ++i) EXPECT_EQ(reference.fixes[i].burst, i < 8 ? 0U : 1U);
  EXPECT_NEAR(reference.fixes[6].p.x(), 0.2 * 26, 1e-12);
}

TEST(ReferenceFixes, TheLastOneBeforeAnOutageIsNoWitness) {
  EXPECT_EQ(verdicts(reference_fixes(drive("ooooooo" + kGap + "oooooo"), 2.7)), "ssssssussssss");
}

TEST(ReferenceFixes, WhatStepsOtherwiseThanTheWheelsIsAPieceOfItsOwn) {
  EXPECT_EQ(verdicts(reference_fixes(drive("oooooxoooooo"), 2.7)), "sssssussssss");
  EXPECT_EQ(verdicts(reference_fixes(drive("ooo" + kGap + "oooooo"), 2.7)), "uuussssss");
}

TEST(ReferenceFixes, OdometryIsAsGoodAsWheels) {
  for (const char* fixes : {"oooooxoooooo", "oooxxxooo"})
    EXPECT_EQ(verdicts(reference_fixes(drive(fixes, false), 2.7)),
              verdicts(reference_fixes(drive(fixes), 2.7)));
}

TEST(ReferenceFixes, NoneGiveNone) {
  EXPECT_TRUE(reference_fixes(drive("...."), 2.7).fixes.empty());
  EXPECT_EQ(reference_fixes({}, 2.7).bursts, 0U);
}

TEST(HoldOut, FoldsShareAllBurstsButTheFirstAndTheLast) {
  for (const std::size_t bursts : {1U, 2U, 3U, 6U, 7U}) {
    std::string text;
    for (std::size_t i = 0; i < bursts; ++i) text += "oo" + kGap;
    const auto reference = reference_fixes(drive(text), 2.7);
    const auto a = hold_out_fold(reference, 0), b = hold_out_fold(reference, 1);
    ASSERT_EQ(reference.bursts, bursts);
    for (std::size_t i = 0; i < reference.fixes.size(); ++i) {
      const std::size_t burst = reference.fixes[i].burst;
      const bool inner = burst > 0 && burst + 1 < bursts;
      EXPECT_EQ(a[i] + b[i], inner ? 1 : 0) << burst;
      EXPECT_EQ(a[i], inner && burst % 2 == 1) << burst;
    }
  }
}

TEST(HoldOut, OneBurstAndOneStretchOfTime) {
  const auto reference = reference_fixes(drive("ooo" + kGap + "oo" + kGap + "o"), 2.7);
  EXPECT_EQ(hold_out_burst(reference, 1), (std::vector<bool>{0, 0, 0, 1, 1, 0}));
  EXPECT_EQ(hold_out_between(reference, from_seconds(0.3), from_seconds(5.8)),
            (std::vector<bool>{0, 0, 1, 1, 0, 0}));
}

}  // namespace
}  // namespace majak::eval
