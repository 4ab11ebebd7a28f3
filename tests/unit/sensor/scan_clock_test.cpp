// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/scan_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "majak/core/random.hpp"

namespace majak::sensor {
namespace {

constexpr Duration kMillisecond = kSecond / 1000;
constexpr Duration kPeriod = 26'640'000;  // ns, two turns of a mirror

struct Outcome {
  double worst = 0;  ///< s, of the stamps, after the first quarter
  int backwards = 0;
  double period = 0;
};

/// n scans whose first bytes are held up by delay(i); the mirror runs off by `skew`.
Outcome run(int n, double skew, const std::function<Duration(int)>& delay, int every = 1,
            bool indexed = false) {
  ScanClock clock({.period = kPeriod});
  Outcome out;
  Time before = 0;
  for (int i = 0; i < n; ++i) {
    const int beat = i * every;
    const auto truth = static_cast<Time>(
        std::llround(5e9 + static_cast<double>(beat) * static_cast<double>(kPeriod) * (1 + skew)));
    const auto index = static_cast<std::uint8_t>(2 * beat + 77);
    const Time told =
        indexed ? clock.stamp(truth + delay(i), index, 2) : clock.stamp(truth + delay(i));
    out.backwards += i > 0 && told <= before;
    if (i > n / 4) {
      out.worst = std::max(out.worst, std::abs(to_seconds(told - truth)));
      EXPECT_EQ(clock.last_step(), every) << i;
    }
    before = told;
  }
  out.period = clock.period();
  return out;
}

TEST(ScanClock, WithoutDelayTheArrivalIsTheTruth) {
  const Outcome out = run(400, 0, [](int) { return Duration{0}; });
  EXPECT_LT(out.worst, 1e-8);
  EXPECT_NEAR(out.period, kPeriod, 1);
}

TEST(ScanClock, AnAdaptersJitterGoes) {
  // Up to 16 ms late, as with a USB adapter's latency timer; now and then nearly in time.
  RandomStream r(1);
  const Outcome out = run(2000, 0, [&](int) {
    return static_cast<Duration>(std::pow(r.uniform(0, 1), 2) * 16 * kMillisecond);
  });
  EXPECT_LT(out.worst, 1e-4);
  EXPECT_EQ(out.backwards, 0);
}

TEST(ScanClock, FollowsAMirrorThatIsNotNominal) {
  for (const double skew : {-0.003, 0.001}) {
    RandomStream r(2);
    const Outcome out = run(4000, skew, [&](int) {
      return static_cast<Duration>(std::pow(r.uniform(0, 1), 2) * 5 * kMillisecond);
    });
    EXPECT_LT(out.worst, 1e-4) << skew;
    EXPECT_NEAR(out.period, kPeriod * (1 + skew), 1e-6 * kPeriod);
  }
}

TEST(ScanClock, SlowLinesSkipBeats) {
  RandomStream r(3);
  const auto late = [&](int) { return static_cast<Duration>(r.uniform(0, 2e6)); };
  EXPECT_LT(run(800, 0.0005, late, 8).worst, 1.5e-4);
}

TEST(ScanClock, ABacklogIsCountedRightByTheDevicesIndex) {
  // The computer sleeps for 0.3 s; then eleven scans arrive at once.
  const auto delay = [](int i) -> Duration {
    const int k = i % 200;
    return k >= 150 && k < 161 ? (161 - k) * kPeriod : 0;
  };
  EXPECT_LT(run(1000, 0, delay, 1, true).worst, 1e-6);
}

TEST(ScanClock, ScansHeldUpForABeatOrTwoSpoilNoOthers) {
  // The computer is busy now and then; there is no index to count by.
  ScanClock clock({.period = kPeriod});
  RandomStream r(5);
  double worst = 0, worst_late = 0;
  std::int64_t steps = 0;
  int late = 0;
  Time before = 0;
  for (int i = 0; i < 6000; ++i) {
    const bool busy = i > 100 && r.uniform() < 0.01;
    const double delay = busy ? r.uniform(0.5, 1.9) : 0.04 * r.uniform();
    const Time truth = 5 * kSecond + i * kPeriod;
    // Nothing overtakes what is held up.
    const Time arrival = before =
        std::max(truth + static_cast<Duration>(delay * kPeriod), before + 1);
    const bool held_up = arrival - truth > kPeriod / 10;
    const double off = std::abs(to_seconds(clock.stamp(arrival) - truth));
    if (i > 0) steps += clock.last_step();
    late += held_up;
    if (i > 1500) (held_up ? worst_late : worst) = std::max(held_up ? worst_late : worst, off);
  }
  EXPECT_GT(late, 30);
  EXPECT_LT(worst, 1e-4);
  EXPECT_LT(worst_late, 2e-9 * kPeriod);
  EXPECT_EQ(steps, 5999);
}

TEST(ScanClock, LostScansAreSeen) {
  ScanClock clock({.period = kPeriod});
  clock.stamp(0);
  clock.stamp(kPeriod);
  EXPECT_EQ(clock.last_step(), 1);
  clock.stamp(4 * kPeriod + kMillisecond);
  EXPECT_EQ(clock.last_step(), 3);
}

TEST(ScanClock, NeverLaterThanTheArrivalNorBeforeTheScanBefore) {
  RandomStream r(4);
  ScanClock clock({.period = kPeriod});
  Time arrival = 0, before = -1;
  for (int i = 0; i < 5000; ++i) {
    arrival += static_cast<Duration>(r.uniform(0, 4) * kPeriod) + 2;
    const Time told = clock.stamp(arrival);
    EXPECT_LE(told, arrival);
    EXPECT_GT(told, before);
    before = told;
  }
}

TEST(ScanClock, AfterALongPauseItBeginsAnew) {
  ScanClock clock({.period = kPeriod});
  for (int i = 0; i < 100; ++i) clock.stamp(i * kPeriod);
  const Time later = 500 * kSecond + 12345;
  EXPECT_EQ(clock.stamp(later), later);
}

}  // namespace
}  // namespace majak::sensor
