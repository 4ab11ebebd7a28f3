// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/turn_merger.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "majak/core/random.hpp"
#include "tests/unit/sensor/lms_wire.hpp"

namespace majak::sensor {
namespace {

constexpr Variant kHalf{180, 50}, kQuarter{100, 25}, kWholeDegrees{180, 100};

/// Values that are all different, for one whole scan.
LmsScan whole_scan(const Variant& variant, int number) {
  LmsScan scan;
  for (int i = 0; i < merged_variant(variant).beams(); ++i)
    scan.values.push_back(static_cast<std::uint16_t>(1 + number * 1000 + i));
  return scan;
}

/// The turns that the device sends of it, the first one with this index.
std::vector<LmsScan> turns_of(const LmsScan& whole, const Variant& variant,
                              std::optional<int> index = {}) {
  std::vector<LmsScan> turns(static_cast<std::size_t>(variant.turns()), whole);
  for (std::size_t part = 0; part < turns.size(); ++part) {
    turns[part].partial = true;
    turns[part].quarter = static_cast<int>(part * 4 / turns.size());
    turns[part].values.clear();
    for (std::size_t beam = part; beam < whole.values.size(); beam += turns.size())
      turns[part].values.push_back(whole.values[beam]);
    if (index) turns[part].scan_index = static_cast<std::uint8_t>(*index + static_cast<int>(part));
  }
  return turns;
}

/// A stream of scans, turn after turn from `first_index` on, of which some turns are lost.
struct Stream {
  explicit Stream(const Variant& v, std::optional<int> first_index = {}, int scans = 10)
      : variant(v) {
    for (int i = 0; i < scans; ++i) {
      whole.push_back(whole_scan(v, i));
      std::optional<int> index;
      if (first_index) index = *first_index + i * v.turns();
      for (LmsScan& turn : turns_of(whole.back(), v, index)) turns.push_back(std::move(turn));
    }
  }
  /// Numbers of the scans that come out whole.
  std::vector<int> merge(const std::vector<std::size_t>& lost = {}, Duration jitter = 0) {
    std::vector<int> out;
    for (std::size_t i = 0; i < turns.size(); ++i) {
      if (std::find(lost.begin(), lost.end(), i) != lost.end()) continue;
      const Time late = jitter * static_cast<Duration>(i * 7 % 5) / 4;
      const Time stamp = 5 * kSecond + static_cast<Time>(i) * kMirrorTurn + late;
      const auto merged = merger.add(turns[i], variant, stamp);
      if (!merged) continue;
      const int number = merged->values.front() / 1000;
      EXPECT_EQ(merged->values, whole[static_cast<std::size_t>(number)].values);
      EXPECT_FALSE(merged->partial);
      out.push_back(number);
    }
    return out;
  }

  Variant variant;
  std::vector<LmsScan> whole, turns;
  TurnMerger merger;
};

std::vector<int> all_but(std::vector<int> missing, int count = 10) {
  std::vector<int> out;
  for (int i = 0; i < count; ++i)
    if (std::find(missing.begin(), missing.end(), i) == missing.end()) out.push_back(i);
  return out;
}

TEST(TurnMerger, PartsOfAScanGiveTheScan) {
  for (const Variant& variant : {kHalf, kQuarter, kWholeDegrees})
    for (const auto index : {std::optional<int>(), std::optional<int>(17)}) {
      Stream stream(variant, index);
      EXPECT_EQ(stream.merge(), all_but({})) << variant.resolution;
      EXPECT_EQ(stream.merger.incomplete(), 0);
    }
}

// The merged one becomes the same Scan as one that came whole: time, angles and ranges.
TEST(TurnMerger, AMergedScanIsTheWholeOne) {
  const LmsConfiguration configuration = LmsConfiguration::factory();
  for (const Variant& variant : {kHalf, kQuarter}) {
    const LmsScan whole = whole_scan(variant, 0);
    TurnMerger merger;
    std::optional<LmsScan> merged;
    Time stamp = kSecond;
    for (const LmsScan& turn : turns_of(whole, variant)) {
      EXPECT_FALSE(merged.has_value());
      merged = merger.add(turn, variant, stamp += kMirrorTurn);
    }
    ASSERT_TRUE(merged.has_value());
    EXPECT_EQ(*merged, whole);
    const Scan scan = to_scan(*merged, configuration, merged_variant(variant), stamp);
    EXPECT_EQ(scan.time, kSecond);
    EXPECT_EQ(scan.ranges.size(), variant == kHalf ? 361U : 721U);
    EXPECT_NEAR(scan.start_angle, radians(-90.0), 1e-12);
    EXPECT_NEAR(scan.angle_step, radians(variant.resolution * 0.01), 1e-12);
  }
}

// Beam k of the merged scan looks where the same value's beam looked in its own turn, and was
// fired when that one was.
TEST(TurnMerger, EachBeamKeepsItsAngleAndItsTime) {
  const LmsConfiguration configuration = LmsConfiguration::factory();
  for (const Variant& variant : {kHalf, kQuarter}) {
    const Variant whole = merged_variant(variant);
    const auto parts = turns_of(whole_scan(variant, 0), variant);
    const std::size_t n = parts.size();
    const Time last = kSecond + static_cast<Time>(n - 1) * kMirrorTurn;
    const Time begin = last - static_cast<Time>(n) * kMirrorTurn;
    for (std::size_t part = 0; part < n; ++part) {
      const Time stamp = kSecond + static_cast<Time>(part) * kMirrorTurn;
      const Scan turn = to_scan(parts[part], configuration, variant, stamp);
      for (std::size_t i = 0; i < turn.ranges.size(); ++i) {
        const auto beam = static_cast<int>(i * n + part);
        EXPECT_NEAR(turn.start_angle + static_cast<double>(i) * turn.angle_step,
                    whole.start_angle() + beam * whole.angle_step(), 1e-12);
        EXPECT_NEAR(static_cast<double>(turn.time + beam_time(kWholeDegrees, static_cast<int>(i))),
                    static_cast<double>(begin + beam_time(whole, beam)), 3);  // ns, rounding
      }
    }
  }
}

TEST(TurnMerger, ALostTurnCostsItsScanAndNoOther) {
  for (const Variant& variant : {kHalf, kQuarter})
    for (const auto index : {std::optional<int>(), std::optional<int>(17)})
      for (std::size_t lost = 0; lost < 36; ++lost) {
        Stream stream(variant, index);
        if (lost + static_cast<std::size_t>(variant.turns()) >= stream.turns.size()) break;
        const int scan = static_cast<int>(lost) / variant.turns();
        EXPECT_EQ(stream.merge({lost}), all_but({scan})) << lost;
        EXPECT_EQ(stream.merger.incomplete(), 1) << lost;
      }
}

// The end of one scan and the beginning of the next are missing: what is left is no scan.
TEST(TurnMerger, HalvesOfTwoScansAreNotOne) {
  for (const auto index : {std::optional<int>(), std::optional<int>(17)}) {
    Stream quarter(kQuarter, index);
    EXPECT_EQ(quarter.merge({2, 3, 4, 5}), all_but({0, 1}));
    EXPECT_EQ(quarter.merger.incomplete(), 2);
    Stream half(kHalf, index);
    EXPECT_EQ(half.merge({1, 2}), all_but({0, 1}));
    EXPECT_EQ(half.merger.incomplete(), 2);
  }
}

TEST(TurnMerger, AScanOfWhichNothingCameIsNotCounted) {
  Stream stream(kQuarter);
  EXPECT_EQ(stream.merge({4, 5, 6, 7}), all_but({1}));
  EXPECT_EQ(stream.merger.incomplete(), 0);
}

TEST(TurnMerger, TheIndexComesAround) {
  for (const Variant& variant : {kHalf, kQuarter})
    for (int first = 240; first < 256; ++first) {
      Stream stream(variant, first);
      EXPECT_EQ(stream.merge(), all_but({})) << first;
      EXPECT_EQ(stream.merger.incomplete(), 0);
    }
}

// 256 turns later the index is the same again, the time is not.
TEST(TurnMerger, ATurnFromTheNextRoundOfTheIndexDoesNotFit) {
  TurnMerger merger;
  const auto turns = turns_of(whole_scan(kHalf, 0), kHalf, 4);
  EXPECT_FALSE(merger.add(turns[0], kHalf, kSecond));
  EXPECT_FALSE(merger.add(turns[1], kHalf, kSecond + 257 * kMirrorTurn));
  EXPECT_EQ(merger.incomplete(), 1);
}

// An adapter hands over late: up to one turn is forgiven.
TEST(TurnMerger, LateTurnsAreStillTheirs) {
  for (const Variant& variant : {kHalf, kQuarter}) {
    Stream stream(variant);
    EXPECT_EQ(stream.merge({}, kMirrorTurn * 9 / 10), all_but({}));
    EXPECT_EQ(stream.merger.incomplete(), 0);
  }
}

TEST(TurnMerger, ATurnThatComesTwiceCountsOnce) {
  TurnMerger merger;
  const auto turns = turns_of(whole_scan(kHalf, 0), kHalf);
  EXPECT_FALSE(merger.add(turns[0], kHalf, kSecond));
  EXPECT_FALSE(merger.add(turns[0], kHalf, kSecond));
  EXPECT_TRUE(merger.add(turns[1], kHalf, kSecond + kMirrorTurn));
  EXPECT_FALSE(merger.add(turns[1], kHalf, kSecond + kMirrorTurn));
}

TEST(TurnMerger, WhatIsNoTurnIsLeftOut) {
  TurnMerger merger;
  LmsScan whole = whole_scan(kHalf, 0);
  EXPECT_FALSE(merger.add(whole, kHalf, kSecond));
  LmsScan turn = turns_of(whole, kHalf)[1];
  turn.quarter = 1;  // a device of half degrees has none
  EXPECT_FALSE(merger.add(turn, kHalf, kSecond));
  turn.quarter = 2;
  turn.values.pop_back();
  EXPECT_FALSE(merger.add(turn, kHalf, kSecond));
  EXPECT_EQ(merger.incomplete(), 0);
}

TEST(TurnMerger, TheStatusIsTheWorstOfAll) {
  TurnMerger merger;
  auto turns = turns_of(whole_scan(kHalf, 0), kHalf);
  turns[0].status = 0x52;  // implausible, warning
  turns[1].status = 0x91;  // dirty, info
  merger.add(turns[0], kHalf, kSecond);
  const auto merged = merger.add(turns[1], kHalf, kSecond + kMirrorTurn);
  ASSERT_TRUE(merged.has_value());
  EXPECT_EQ(merged->status, 0xD2);
}

// ---- From an emulated device --------------------------------------------------------------------

struct Merged {
  std::int64_t right = 0, wrong = 0, incomplete = 0;
};

Merged from_device(const Variant& variant, const LmsFaults& faults, bool indices) {
  LmsEmulatorOptions laser = lms291_s05();
  laser.booted = true;
  laser.baud = 500000;
  laser.variant = variant;
  LmsDriverOptions wanted;
  wanted.interlaced = true;
  wanted.real_time_indices = indices;
  Wire wire(laser, wanted, faults);
  wire.run(20 * kSecond);
  TurnMerger merger;
  Merged out;
  for (const auto& a : wire.arrived) {
    const auto merged = merger.add(a.delivery.scan, variant, a.delivery.stamp);
    if (!merged) continue;
    const Scan scan =
        to_scan(*merged, LmsConfiguration::factory(), merged_variant(variant), a.delivery.stamp);
    const bool right = wire.was_measured({{}, scan, 0});
    ++(right ? out.right : out.wrong);
  }
  out.incomplete = merger.incomplete();
  return out;
}

TEST(TurnMerger, ScansOfADeviceAreThoseThatItMeasured) {
  for (const Variant& variant : {kHalf, kQuarter})
    for (const bool indices : {false, true}) {
      const Merged m = from_device(variant, {}, indices);
      EXPECT_GT(m.right, 75 * 18 / variant.turns()) << variant.resolution;
      EXPECT_EQ(m.wrong, 0);
      EXPECT_LE(m.incomplete, 1);  // the first one, of which the beginning was not heard
    }
}

TEST(TurnMerger, WithTurnsLostNoScanIsWrong) {
  LmsFaults faults;
  faults.truncate = 0.2;
  for (const Variant& variant : {kHalf, kQuarter})
    for (const bool indices : {false, true}) {
      const Merged m = from_device(variant, faults, indices);
      EXPECT_GT(m.right, variant == kHalf ? 410 : 115) << indices;  // seen 426 and 120
      EXPECT_GT(m.incomplete, 225);                                 // seen 234
      EXPECT_EQ(m.wrong, 0);
    }
}

}  // namespace
}  // namespace majak::sensor
