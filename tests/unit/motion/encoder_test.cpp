// SPDX-License-Identifier: Apache-2.0
#include "majak/motion/encoder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "majak/core/angle.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/motion/drive.hpp"

namespace majak::motion {
namespace {

/// A counter of so many bits, as a device keeps it.
std::int64_t counter(std::int64_t ticks, int bits, bool is_signed) {
  const auto cut = static_cast<std::uint64_t>(ticks) & ((std::uint64_t{1} << bits) - 1);
  const auto half = std::int64_t{1} << (bits - 1);
  const auto value = static_cast<std::int64_t>(cut);
  return is_signed && value >= half ? value - 2 * half : value;
}

std::int64_t count_of(const Report& report, const std::string& part) {
  std::int64_t n = 0;
  for (const auto& [what, entry] : report.entries())
    if (what.find(part) != std::string::npos) n += entry.count;
  return n;
}

TEST(Encoder, ATurnOfTheWheelIsItsCircumference) {
  Encoder encoder({.ticks_per_turn = 1000, .radius = 0.1});
  Report report;
  EXPECT_FALSE(encoder.add(0, 77, report));
  EXPECT_NEAR(encoder.add(kSecond, 1077, report).value(), 2 * kPi * 0.1, 1e-15);
  EXPECT_NEAR(encoder.add(2 * kSecond, 577, report).value(), -kPi * 0.1, 1e-15);
  EXPECT_NEAR(encoder.way(), kPi * 0.1, 1e-15);
  EXPECT_TRUE(report.empty());
}

TEST(Encoder, ReversedCountsTheOtherWay) {
  Encoder encoder({.ticks_per_turn = 1000, .radius = 0.1, .reversed = true});
  Report report;
  encoder.add(0, 0, report);
  EXPECT_LT(encoder.add(kSecond, 500, report).value(), 0);
}

// The whole of a random drive, whatever the width of the counter and where it begins.
TEST(Encoder, RunsOverWithoutLoss) {
  for (const int bits : {8, 16, 24, 32}) {
    for (const bool is_signed : {false, true}) {
      RandomStream r(5, static_cast<std::uint64_t>(bits), is_signed);
      // At 8 bits the wheel may turn 100 ticks in a record and no more.
      Encoder encoder({.ticks_per_turn = 2 * kPi * 0.1 * 1000,
                       .radius = 0.1,
                       .bits = bits,
                       .is_signed = is_signed,
                       .max_speed = 5});
      const std::int64_t begin = static_cast<std::int64_t>(r.bits() >> 20);
      std::int64_t ticks = begin;
      Report report;
      Time time = 0;
      encoder.add(time, counter(ticks, bits, is_signed), report);
      for (int i = 0; i < 20'000; ++i) {
        const auto step = static_cast<std::int64_t>(r.below(201)) - (i < 10'000 ? 60 : 140);
        if (std::abs(step) > 100) continue;
        ticks += step;
        time += kSecond / 50;
        const auto way = encoder.add(time, counter(ticks, bits, is_signed), report);
        ASSERT_TRUE(way);
        ASSERT_NEAR(*way, 1e-3 * static_cast<double>(step), 1e-12);
      }
      EXPECT_NEAR(encoder.way(), 1e-3 * static_cast<double>(ticks - begin), 1e-9);
      EXPECT_TRUE(report.empty());
    }
  }
}

TEST(Encoder, RecordsThatCameTwiceAreCountedAndChangeNothing) {
  Encoder encoder({.ticks_per_turn = 1000, .radius = 0.1});
  Report report;
  encoder.add(0, 0, report);
  encoder.add(kSecond, 100, report);
  EXPECT_FALSE(encoder.add(kSecond, 100, report));
  EXPECT_FALSE(encoder.add(kSecond / 2, 50, report));
  EXPECT_EQ(count_of(report, "came twice"), 1);
  EXPECT_EQ(count_of(report, "older"), 1);
  EXPECT_NEAR(encoder.way(), 0.1 * 0.2 * kPi, 1e-15);
}

TEST(Encoder, AJumpIsLeftOutAndTheCountGoesOnFromThere) {
  Encoder encoder({.ticks_per_turn = 1000, .radius = 0.1, .max_speed = 2});
  Report report;
  encoder.add(0, 0, report);
  EXPECT_TRUE(encoder.add(kSecond / 10, 300, report));          // 1.9 m/s
  EXPECT_FALSE(encoder.add(2 * kSecond / 10, 10'300, report));  // the counter was set anew
  EXPECT_NEAR(encoder.add(3 * kSecond / 10, 10'400, report).value(), 0.02 * kPi, 1e-12);
  EXPECT_EQ(count_of(report, "jump"), 1);
  EXPECT_NEAR(encoder.way(), 400 * encoder.tick(), 1e-12);
}

TEST(Encoder, APauseThatMayHideARunOverIsReported) {
  Encoder encoder({.ticks_per_turn = 1000, .radius = 0.1, .bits = 8, .max_speed = 1});
  Report report;
  encoder.add(0, 0, report);
  EXPECT_TRUE(encoder.add(kSecond / 20, 20, report));
  EXPECT_FALSE(encoder.add(kSecond, 30, report));  // 1 m is 1591 ticks, the counter has 256
  EXPECT_EQ(count_of(report, "unseen"), 1);
}

TEST(Encoder, CountsBeyondTheWidthAreDamaged) {
  Encoder encoder({.bits = 16, .is_signed = true});
  Report report;
  encoder.add(0, 0, report);
  EXPECT_FALSE(encoder.add(kSecond / 100, 40'000, report));
  EXPECT_FALSE(encoder.add(kSecond / 100, -40'000, report));
  EXPECT_EQ(count_of(report, "width"), 2);
  EXPECT_TRUE(encoder.add(kSecond / 100, 32, report));
}

TEST(Encoder, NonsenseIsRefused) {
  EXPECT_THROW(Encoder({.ticks_per_turn = 0}), Error);
  EXPECT_THROW(Encoder({.radius = -1}), Error);
  EXPECT_THROW(Encoder({.bits = 7}), Error);
  EXPECT_THROW(Encoder({.bits = 33}), Error);
  EXPECT_THROW(Encoder({.max_speed = std::numeric_limits<double>::quiet_NaN()}), Error);
}

// From ticks to a pose (A012): three times round a circle, both counters of 16 bits running over.
TEST(Encoder, TwoOfThemCarryADifferentialDriveRound) {
  const EncoderOptions options{
      .ticks_per_turn = 100'000, .radius = 0.1, .bits = 16, .max_speed = 1};
  Encoder left(options), right(options);
  const Differential drive{0.4};
  const double tick = left.tick(), turns = 3, radius = 1;
  Pose2 pose;
  Report report;
  constexpr int kRecords = 3000;
  for (int i = 0; i <= kRecords; ++i) {
    const double turn = 2 * kPi * turns * i / kRecords;
    const auto count = [&](double way) { return counter(std::llround(way / tick), 16, true); };
    const Time time = i * kSecond / 50;
    const auto l = left.add(time, count((radius - 0.2) * turn), report);
    const auto r = right.add(time, count((radius + 0.2) * turn), report);
    if (l && r) pose = pose * exp(drive.forward({*l, *r}));
  }
  EXPECT_TRUE(report.empty());
  // Only the ticks' width is left: seen 3e-6 m.
  EXPECT_LT(pose.translation().norm(), 5e-5);
  EXPECT_NEAR(pose.theta, 0, 2 * tick / 0.4);
}

// Anything at all: no way is ever longer than the wheel can roll, and nothing is lost silently.
TEST(Encoder, AnyStreamOfRecords) {
  RandomStream r(6);
  for (int run = 0; run < 200; ++run) {
    const int bits = 8 + static_cast<int>(r.below(25));
    const EncoderOptions options{.bits = bits, .is_signed = r.below(2) == 1, .max_speed = 3};
    Encoder encoder(options);
    Report report;
    Time time = 0, last = 0;
    std::int64_t known = 0, unknown = 0;
    double sum = 0;
    for (int i = 0; i < 200; ++i) {
      time += static_cast<Time>(r.below(40'000'000)) - 4'000'000;
      const std::int64_t raw =
          static_cast<std::int64_t>(r.bits()) >> (r.below(4) == 0 ? 20 : 64 - bits);
      if (const auto way = encoder.add(time, raw, report)) {
        ++known;
        sum += *way;
        ASSERT_LE(std::abs(*way), 3 * to_seconds(time - last) + encoder.tick());
        last = time;
      } else {
        ++unknown;
        last = std::min(last, time);
      }
    }
    EXPECT_NEAR(sum, encoder.way(), 1e-9);
    const auto reported = count_of(report, "encoder");
    EXPECT_TRUE(unknown == reported || unknown == reported + 1);  // the first record
    EXPECT_EQ(known + unknown, 200);
  }
}

}  // namespace
}  // namespace majak::motion
