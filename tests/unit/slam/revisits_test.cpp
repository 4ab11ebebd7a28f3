// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/revisits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "majak/core/random.hpp"
#include "tests/unit/slam/drive.hpp"

namespace majak::slam {
namespace {

using Partners = std::vector<std::vector<std::size_t>>;

/// Loop closing that knows the ways and sees nothing again.
LoopCloser ways_of(KeyScans& keys) {
  LoopClosingOptions blind;
  blind.near = blind.drift_translation = 0;
  LoopCloser loops(blind);
  loops.update(keys, true);
  return loops;
}

/// Key scans without points, anywhere on a field of so many metres.
KeyScans strewn(std::uint64_t seed, int n, double field) {
  RandomStream r(seed);
  KeyScans keys(static_cast<std::size_t>(n));
  for (KeyScan& key : keys) {
    key.T_map_robot = {r.uniform(-field, field), r.uniform(-field, field), r.uniform(-kPi, kPi)};
    key.T_front_robot = key.T_map_robot;
    key.match_information = key.motion_information = 1e4 * Mat3::Identity();
  }
  return keys;
}

/// There and back on a line, a quarter metre a key scan, `n` of them out and as many back.
KeyScans there_and_back(int n) {
  KeyScans keys = strewn(1, 2 * n, 1);
  for (int i = 0; i < 2 * n; ++i) {
    KeyScan& key = keys[static_cast<std::size_t>(i)];
    key.T_front_robot = {0.25 * (i < n ? i : 2 * n - 1 - i), 0, i < n ? 0 : kPi};
    key.T_map_robot = key.T_front_robot;
  }
  return keys;
}

double far(const KeyScans& keys, std::size_t i, std::size_t j) {
  return between(keys[j].T_map_robot, keys[i].T_map_robot).translation().norm();
}
double rank(const KeyScans& keys, std::size_t i, std::size_t j) {
  return far(keys, i, j) + std::abs(between(keys[j].T_map_robot, keys[i].T_map_robot).theta);
}

/// The slow twin looks at all pairs.
Partners slow_revisits(const KeyScans& keys, const LoopCloser& loops, const RevisitOptions& o) {
  Partners all(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t j = 0; j + 20 <= i; ++j)
      if (far(keys, i, j) <= o.reach &&
          loops.ways().from(loops.submap_of(i))[loops.submap_of(j)] <= o.known_way)
        ranked.push_back({rank(keys, i, j), j});
    std::sort(ranked.begin(), ranked.end());
    for (const auto& [r, j] : ranked) {
      bool stop = static_cast<int>(all[i].size()) >= o.count;
      for (const std::size_t chosen : all[i]) stop |= chosen < j + 5 && j < chosen + 5;
      if (!stop) all[i].push_back(j);
    }
  }
  return all;
}

TEST(Revisits, EqualTheirSlowTwin) {
  for (const RevisitOptions& o :
       {RevisitOptions{}, RevisitOptions{10, 1.0, 1e9}, RevisitOptions{1, 7.0, 300.0}}) {
    KeyScans keys = strewn(3, 150, 9);
    const LoopCloser loops = ways_of(keys);
    const Partners fast = revisits(keys, loops, o);
    EXPECT_EQ(fast, slow_revisits(keys, loops, o));
    EXPECT_TRUE(std::any_of(fast.begin(), fast.end(), [](const auto& p) { return !p.empty(); }));
  }
}

TEST(Revisits, WithoutLoopClosingThereAreNone) {
  const KeyScans keys = there_and_back(40);
  const Partners none = revisits(keys, LoopCloser({}), {});
  ASSERT_EQ(none.size(), keys.size());
  for (const auto& partners : none) EXPECT_TRUE(partners.empty());
  EXPECT_TRUE(revisits({}, LoopCloser({}), {}).empty());
}

TEST(Revisits, HoldToTheirOptions) {
  KeyScans keys = there_and_back(100);
  const LoopCloser loops = ways_of(keys);
  for (const int count : {0, 1, 3, 8})
    for (const double reach : {0.3, 1.0, 4.0}) {
      const Partners all = revisits(keys, loops, {count, reach, 100.0});
      ASSERT_EQ(all.size(), keys.size());
      for (std::size_t i = 0; i < keys.size(); ++i) {
        EXPECT_LE(all[i].size(), static_cast<std::size_t>(count));
        if (count > 0 && i >= 112) {
          EXPECT_FALSE(all[i].empty()) << i;  // it has been here before
        }
        double before = 0;
        for (const std::size_t j : all[i]) {
          EXPECT_LE(j + 12, i);  // older, and not of the same visit
          EXPECT_LE(far(keys, i, j), reach);
          EXPECT_GE(rank(keys, i, j), before);  // the nearest first
          before = rank(keys, i, j);
        }
      }
    }
}

TEST(Revisits, WhoOnlyStandsIsOnOneVisit) {
  // Eleven key scans on one spot, as when turning there.
  KeyScans keys = there_and_back(6);
  for (KeyScan& key : keys) key.T_map_robot = key.T_front_robot = {};
  const LoopCloser loops = ways_of(keys);
  ASSERT_GT(loops.ways().size(), 0U);
  for (const auto& partners : revisits(keys, loops, {})) EXPECT_TRUE(partners.empty());
}

TEST(Revisits, PlacesTooFarByWayAreNotKnownWellEnough) {
  KeyScans keys = there_and_back(200);  // 50 m out
  const LoopCloser loops = ways_of(keys);
  for (const double known : {10.0, 40.0, 1000.0}) {
    const Partners all = revisits(keys, loops, {3, 2.5, known});
    for (std::size_t i = 212; i < 400; ++i) {
      const double way = 0.5 * (static_cast<double>(i) - 199.5);  // since it was here
      if (way < known - 6) {
        EXPECT_FALSE(all[i].empty()) << known << ' ' << i;
      }
      if (way > known + 8) {
        EXPECT_TRUE(all[i].empty()) << known << ' ' << i;
      }
    }
  }
}

TEST(Revisits, ARecognisedPlaceIsAShortCut) {
  Drive d = drive(ring(), "abcdabc");
  Drive blind = d;
  const RevisitOptions options{3, 4.0, 15.0};  // a lap is 40 m
  LoopCloser loops({});
  loops.update(d.keys, true);
  ASSERT_FALSE(loops.closures().empty());
  const LoopCloser blind_loops = ways_of(blind.keys);
  const auto other_lap = [](const Partners& all) {
    int n = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
      n += static_cast<int>(
          std::count_if(all[i].begin(), all[i].end(), [i](std::size_t j) { return i - j > 80; }));
    return n;
  };
  EXPECT_EQ(other_lap(revisits(blind.keys, blind_loops, options)), 0);
  const Partners paired = revisits(d.keys, loops, options);
  EXPECT_GT(other_lap(paired), 100);
  for (std::size_t i = 0; i < paired.size(); ++i)  // and truly near
    for (const std::size_t j : paired[i])
      EXPECT_LT(between(d.truth[i], d.truth[j]).translation().norm(), options.reach + 0.5);
}

}  // namespace
}  // namespace majak::slam
