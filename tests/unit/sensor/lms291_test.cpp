// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/lms291.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <set>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/event.hpp"

namespace majak::sensor {
namespace {

constexpr double kTurnMs = 1000.0 / 75.0;

double beam_ms(const Variant& v, int beam) { return to_seconds(beam_time(v, beam)) * 1e3; }

TEST(Lms291, VariantsHaveTheBeamsOfTheManual) {
  std::vector<int> beams;
  for (const Variant& v : kVariants) beams.push_back(v.beams());
  EXPECT_THAT(beams, testing::ElementsAre(181, 361, 101, 201, 401));
  for (const Variant& v : kVariants) {
    EXPECT_EQ(variant_of_beams(v.beams()), v);
    // Symmetric about straight ahead.
    EXPECT_NEAR(v.start_angle() + (v.beams() - 1) * v.angle_step(), -v.start_angle(), 1e-12);
  }
  EXPECT_THROW(variant_of_beams(180), Error);
}

TEST(Lms291, FinerScansTakeMoreTurnsOfTheMirror) {
  const double rates[5] = {75, 37.5, 75, 37.5, 18.75};  // Hz
  for (std::size_t i = 0; i < kVariants.size(); ++i) {
    const double period = to_seconds(kVariants[i].turns() * kMirrorTurn);
    EXPECT_NEAR(1 / period, rates[i], 1e-5);
  }
}

TEST(Lms291, BeamTimesOfOneDegree) {
  const Variant v{180, 100};
  EXPECT_EQ(beam_time(v, 0), 0);
  EXPECT_NEAR(beam_ms(v, 1), 0.037, 1e-4);  // fired every 37 us
  EXPECT_NEAR(beam_ms(v, 180), kTurnMs / 2, 1e-5);
  EXPECT_NEAR(to_seconds(scan_duration(v)) * 1e3, 6.667, 1e-3);
}

TEST(Lms291, HalfADegreeInterleavesTwoTurns) {
  const Variant v{180, 50};
  EXPECT_NEAR(beam_ms(v, 1) - beam_ms(v, 0), kTurnMs + 0.0185, 1e-4);
  EXPECT_NEAR(beam_ms(v, 2) - beam_ms(v, 0), 0.037, 1e-4);
  EXPECT_NEAR(beam_ms(v, 360), kTurnMs / 2, 1e-5);
  EXPECT_NEAR(beam_ms(v, 359), kTurnMs + 359 * 0.5 / 360 * kTurnMs, 1e-5);
  EXPECT_EQ(scan_duration(v), beam_time(v, 359));
}

TEST(Lms291, AQuarterOfADegreeInterleavesFourTurns) {
  const Variant v{100, 25};
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(beam_ms(v, k), k * (kTurnMs + 0.25 / 360 * kTurnMs), 1e-4);
  EXPECT_NEAR(beam_ms(v, 4), 1.0 / 360 * kTurnMs, 1e-5);
  EXPECT_EQ(scan_duration(v), beam_time(v, 399));
}

TEST(Lms291, EveryBeamIsFiredWhenTheMirrorPointsThere) {
  for (const Variant& v : kVariants) {
    std::set<Duration> times;
    for (int i = 0; i < v.beams(); ++i) {
      const Duration t = beam_time(v, i);
      const double mirror = 360.0 * static_cast<double>(t % kMirrorTurn) / kMirrorTurn;
      EXPECT_NEAR(mirror, i * v.resolution / 100.0, 1e-3);
      EXPECT_LE(t, scan_duration(v));
      EXPECT_LT(scan_duration(v), v.turns() * kMirrorTurn);
      times.insert(t);
    }
    EXPECT_EQ(times.size(), static_cast<std::size_t>(v.beams()));  // one laser: one beam at a time
  }
}

TEST(Lms291, SpotGrowsAsInTheManual) {
  const double range[6] = {1, 5, 10, 20, 30, 80}, diameter_cm[6] = {3, 8, 14, 26, 38, 97};
  for (int i = 0; i < 6; ++i) {
    const double spot = 200 * range[i] * std::tan(half_beam_angle(range[i]));
    EXPECT_LE(spot, diameter_cm[i] + 1e-9);  // the manual rounds up
    EXPECT_GT(spot, diameter_cm[i] - 1);
  }
}

RangeNoiseOptions only_statistical() {
  RangeNoiseOptions o;
  o.systematic_error = 0;
  o.no_return = 0;
  return o;
}

TEST(Lms291, TheLineDecidesHowManyScansArrive) {
  // Telegram listing, table 10-17.
  const struct {
    Variant variant;
    std::array<double, 4> rates;  // Hz at 9600, 19200, 38400, 500000 Bd
  } table[] = {{{180, 100}, {2.50, 5.01, 9.38, 75.1}},
               {{180, 50}, {1.29, 2.50, 4.69, 37.5}},
               {{100, 25}, {1.17, 2.35, 4.69, 18.8}}};
  for (const auto& row : table) {
    int k = 0;
    for (const int baud : {9600, 19200, 38400, 500000}) {
      const double told = row.rates[static_cast<std::size_t>(k++)];
      EXPECT_NEAR(delivered_rate(row.variant, baud), told, 0.01 * told) << baud;
    }
  }
}

TEST(RangeNoise, PerfectRangeIsTheTrueOne) {
  const RangeNoise noise(perfect_range(), RandomStream(1));
  RandomStream beam(2);
  for (const double r : {0.001, 0.5, 7.123, 79.99}) {
    EXPECT_EQ(noise.simulate_range(r, 1.5, 0.001, beam), static_cast<float>(r));
  }
}

TEST(RangeNoise, RangesAreWholeCentimetresAndNeverBelowOne) {
  const RangeNoise noise(RangeNoiseOptions{}, RandomStream(3));
  for (int i = 0; i < 5000; ++i) {
    RandomStream beam(4, static_cast<std::uint64_t>(i));
    const double truth = i < 1000 ? 0.0001 * i : 0.008 * i;
    const float range = noise.simulate_range(truth, 0, 0.6, beam);
    if (!std::isfinite(range)) continue;
    EXPECT_GE(range, 0.01f);
    EXPECT_NEAR(range * 100, std::round(range * 100), 1e-3);
  }
}

TEST(RangeNoise, StatisticalErrorHasItsSigmaAndNoBias) {
  const RangeNoise noise(only_statistical(), RandomStream(5));
  constexpr int n = 20000;
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    RandomStream beam(6, static_cast<std::uint64_t>(i));
    const double truth = 1.0 + 18.0 * i / n;
    const double e = noise.simulate_range(truth, 0, 0.6, beam) - truth;
    sum += e;
    squares += e * e;
  }
  // Rounding to 10 mm adds its own variance (Sheppard). Bounds: four sigma of the statistic.
  const double variance = 0.010 * 0.010 + 0.010 * 0.010 / 12;
  EXPECT_NEAR(sum / n, 0, 4 * std::sqrt(variance / n));
  EXPECT_NEAR(squares / variance, n, 4 * std::sqrt(2.0 * n));
}

TEST(RangeNoise, SystematicErrorIsBoundedSlowAndFixedInARun) {
  const RangeNoiseOptions o;
  double largest = 0, sum = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const RangeNoise noise(o, RandomStream(seed)), again(o, RandomStream(seed));
    for (double r = 0.5; r < 40; r += 0.5) {
      const double e = noise.systematic_error(r);
      EXPECT_EQ(e, again.systematic_error(r));
      EXPECT_LE(std::abs(e), kLms291.systematic_error);
      EXPECT_LT(std::abs(noise.systematic_error(r + 0.1) - e), 0.001);
      largest = std::max(largest, std::abs(e));
    }
    sum += noise.systematic_error(5);
  }
  EXPECT_GT(largest, 0.025);  // the bound is used
  EXPECT_NEAR(sum / 400, 0, 0.004);
  EXPECT_EQ(RangeNoise(only_statistical(), RandomStream(1)).systematic_error(5), 0);
}

TEST(EchoStrength, IsOneWhereATargetIsJustSeen) {
  const RangeNoiseOptions o;
  for (const double reflectivity : {0.02, 0.1, 0.3}) {
    for (const double incidence : {0.0, 0.5, 1.2}) {
      const double far = reach(o, reflectivity, incidence);
      EXPECT_NEAR(echo_strength(o, {far, incidence, reflectivity}), 1, 1e-12);
      EXPECT_NEAR(echo_strength(o, {far / 3, incidence, reflectivity}), 9, 1e-12);
    }
  }
  EXPECT_NEAR(echo_strength(o, {5, 0, 20}) / echo_strength(o, {5, 0, 0.5}), 40, 1e-12);
  EXPECT_EQ(echo_strength(o, {std::numeric_limits<double>::infinity(), 0, 0.5}), 0);
}

TEST(RangeNoise, ReachFollowsReflectivityAndIncidence) {
  const RangeNoiseOptions o;
  EXPECT_NEAR(reach(o, 0.10, 0), 30, 1e-9);  // black card
  EXPECT_NEAR(reach(o, 0.025, 0), 15, 1e-9);
  EXPECT_EQ(reach(o, 0.80, 0), 80);  // white paper: the device's own end
  EXPECT_NEAR(reach(o, 0.10, radians(60)), 30 * std::sqrt(0.5), 1e-9);
  EXPECT_LT(reach(o, 0.5, radians(89.99)), 1.0);
  const RangeNoise noise(only_statistical(), RandomStream(1));
  RandomStream beam(2);
  EXPECT_TRUE(std::isfinite(noise.simulate_range(29, 0, 0.10, beam)));
  EXPECT_EQ(noise.simulate_range(31, 0, 0.10, beam), kNoReturn);
  EXPECT_EQ(noise.simulate_range(std::numeric_limits<double>::infinity(), 0, 1, beam), kNoReturn);
}

TEST(RangeNoise, MillimetreModeEndsAtEightMetres) {
  RangeNoiseOptions o = only_statistical();
  o.max_range = kLms291.range_mm_mode;
  const RangeNoise noise(o, RandomStream(1));
  for (std::uint64_t i = 0; i < 1000; ++i) {
    RandomStream beam(7, i);
    const float range = noise.simulate_range(7.99, 0, 0.6, beam);
    EXPECT_TRUE(range < 8.0f || range == kNoReturn);
    EXPECT_EQ(noise.simulate_range(8.1, 0, 0.6, beam), kNoReturn);
  }
}

TEST(RangeNoise, ShareOfLostBeams) {
  RangeNoiseOptions o;
  o.no_return = 0.02;
  const RangeNoise noise(o, RandomStream(1));
  constexpr int n = 20000;
  int lost = 0;
  for (std::uint64_t i = 0; i < n; ++i) {
    RandomStream beam(8, i);
    lost += noise.simulate_range(3, 0, 0.6, beam) == kNoReturn ? 1 : 0;
  }
  EXPECT_NEAR(lost, n * 0.02, 4 * std::sqrt(n * 0.02));
}

float of_spot(int near_patches, double near, double far) {
  std::vector<Echo> echoes;
  for (int i = 0; i < 5; ++i) echoes.push_back({i < near_patches ? near : far, 0, 0.6});
  const RangeNoise noise(perfect_range(), RandomStream(1));
  RandomStream beam(1);
  return noise.simulate_range(echoes.data(), echoes.size(), beam);
}

TEST(RangeNoise, EchoesWithinAPulseRunTogether) {
  EXPECT_FLOAT_EQ(of_spot(5, 3.0, 3.6), 3.0f);
  EXPECT_FLOAT_EQ(of_spot(0, 3.0, 3.6), 3.6f);
  float last = 3.0f;
  for (const int near_patches : {4, 3, 2, 1}) {
    const float r = of_spot(near_patches, 3.0, 3.6);
    EXPECT_GT(r, last);
    EXPECT_LT(r, 3.6f);
    last = r;
  }
}

TEST(RangeNoise, EchoesFarApartGiveOneOfThem) {
  EXPECT_FLOAT_EQ(of_spot(3, 3.0, 8.0), 3.0f);
  EXPECT_FLOAT_EQ(of_spot(2, 3.0, 8.0), 3.0f);
  EXPECT_FLOAT_EQ(of_spot(1, 3.0, 8.0), 8.0f);  // too little of the spot for an echo
  EXPECT_FLOAT_EQ(of_spot(2, 3.0, std::numeric_limits<double>::infinity()), 3.0f);
  EXPECT_EQ(of_spot(1, 3.0, std::numeric_limits<double>::infinity()), kNoReturn);
}

TEST(RangeNoise, OptionsDescribeThemselves) {
  RangeNoiseOptions o;
  OptionFields fields;
  describe(fields, o);
  EXPECT_EQ(fields.list.size(), 7u);
  for (const OptionField& f : fields.list) {
    const double value = *std::get<double*>(f.value);
    EXPECT_GE(value, f.info.min) << f.name;
    EXPECT_LE(value, f.info.max) << f.name;
  }
}

}  // namespace
}  // namespace majak::sensor
