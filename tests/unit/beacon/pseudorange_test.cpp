// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/pseudorange.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/beacon/beacon_kind.hpp"
#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "tests/unit/beacon/scatter.hpp"

namespace majak::beacon {
namespace {

using Places2 = std::vector<Vec2>;
using Places3 = std::vector<Vec3>;

const Places2 kAround = {{0, 0}, {20, 2}, {8, 19}, {-3, 12}, {23, 14}, {12, -4}, {2, 22}, {18, 24}};

/// The receiver's side of it: what arrives, by a clock that is off by bias / speed.
template <int D>
std::vector<PseudorangeTo<D>> received(const std::vector<Eigen::Matrix<double, D, 1>>& beacons,
                                       const Eigen::Matrix<double, D, 1>& p, double bias,
                                       double sigma = 0.05, RandomStream* noise = nullptr) {
  std::vector<PseudorangeTo<D>> out;
  for (const auto& b : beacons) {
    const double e = noise == nullptr ? 0 : sigma * noise->normal();
    out.push_back({b, (b - p).norm() + bias + e, sigma});
  }
  return out;
}

template <int D>
PseudorangeFix<D> fix_of(const std::vector<PseudorangeTo<D>>& ranges,
                         const std::optional<Eigen::Matrix<double, D, 1>>& prior = {}) {
  return locate<D>(ranges, prior);
}

/// Satellites on their orbits, seen more than 10 degrees above the horizon of the origin.
Places3 satellites(RandomStream& random, int n) {
  Places3 out;
  while (static_cast<int>(out.size()) < n) {
    const double up = std::asin(random.uniform(0.2, 1)), around = random.uniform(-kPi, kPi);
    out.push_back(2.2e7 * Vec3(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                               std::sin(up)));
  }
  return out;
}

TEST(Pseudorange, ThreeInThePlaneAreEnough) {
  RandomStream random(1);
  int unique = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p(random.uniform(2, 16), random.uniform(2, 16));
    const double bias = random.uniform(-1e5, 1e5);
    const auto ranges = received<2>({{0, 0}, {20, 2}, {8, 19}}, p, bias, 1e-3);
    const auto fix = fix_of<2>(ranges, Vec2(p + Vec2(0.1, 0)));
    EXPECT_EQ(fix.problem, FixProblem::none) << p.transpose();
    EXPECT_LT((fix.p_map - p).norm(), 1e-8);  // seen: 2.3e-10; the bias has but 16 digits
    EXPECT_NEAR(fix.bias, bias, 1e-8);
    EXPECT_EQ(fix.dof, 0);
    unique += !fix.mirror;
  }
  EXPECT_GT(unique, 1000);
}

TEST(Pseudorange, TwoPlacesAreToldAndThePriorDecides) {
  // Far outside, two hyperbolas meet twice.
  const Places2 beacons = {{0, 0}, {10, 0}, {0, 10}};
  int doubtful = 0;
  for (int i = 0; i < 200; ++i) {
    RandomStream random(2, i);
    const Vec2 p(random.uniform(-30, 0), random.uniform(-30, 0));
    const auto open = fix_of<2>(received<2>(beacons, p, 3, 1e-4));
    if (open.problem != FixProblem::ambiguous) continue;
    ++doubtful;
    ASSERT_TRUE(open.mirror);
    EXPECT_LT(std::min((open.p_map - p).norm(), (*open.mirror - p).norm()), 1e-7);
    const auto fix = fix_of<2>(received<2>(beacons, p, 3, 1e-4), p);
    EXPECT_LT((fix.p_map - p).norm(), 1e-7);
  }
  EXPECT_GT(doubtful, 20);
}

TEST(Pseudorange, FourSatellitesGivePlaceAndClock) {
  RandomStream random(3);
  for (int i = 0; i < 500; ++i) {
    const Places3 sky = satellites(random, 4 + i % 5);
    const Vec3 p(random.uniform(-1e4, 1e4), random.uniform(-1e4, 1e4), random.uniform(0, 1e3));
    const double clock = random.uniform(-1e-3, 1e-3);  // s
    const auto fix = fix_of<3>(received<3>(sky, p, clock * kSpeedOfLight, 1e-4), Vec3(p));
    EXPECT_LT((fix.p_map - p).norm(), 2e-5 * fix.dilution.pdop);
    EXPECT_NEAR(fix.bias / kSpeedOfLight, clock, 1e-13 * fix.dilution.tdop);
  }
}

TEST(Pseudorange, ScatterIsTheStatedCovarianceOverAField) {
  for (int place = 0; place < 16; ++place) {
    const Vec2 p(5.0 * (place % 4) + 2.1, 5.0 * (place / 4) + 1.2);
    Scatter<3> scatter(fix_of<2>(received<2>(kAround, p, 7)).covariance);
    RandomStream random(4, place);
    for (int i = 0; i < 16000; ++i) {
      const auto fix = fix_of<2>(received<2>(kAround, p, 7, 0.05, &random));
      scatter.add({fix.p_map.x() - p.x(), fix.p_map.y() - p.y(), fix.bias - 7});
    }
    EXPECT_LT(scatter.difference(), 0.05) << p.transpose();
  }
}

TEST(Pseudorange, GrossErrorsLeaveTheResultWithinItsEllipse) {
  RandomStream random(5);
  int inside = 0, found = 0;
  constexpr int kRuns = 2000;
  for (int run = 0; run < kRuns; ++run) {
    const Vec2 p(random.uniform(0, 20), random.uniform(0, 20));
    auto ranges = received<2>(kAround, p, -4, 0.05, &random);
    ranges.push_back({{-8, 3}, (Vec2(-8, 3) - p).norm() - 4, 0.05});
    ranges.push_back({{28, 9}, (Vec2(28, 9) - p).norm() - 4, 0.05});
    for (const int i : {run % 10, (run / 10) % 10}) ranges[i].range += random.uniform(1, 20);
    const auto fix = fix_of<2>(ranges);
    if (fix.problem != FixProblem::none) continue;
    ++found;
    const Vec3 e(fix.p_map.x() - p.x(), fix.p_map.y() - p.y(), fix.bias + 4);
    inside += e.dot(fix.covariance.inverse() * e) < 7.815;  // 95 %, 3 dof
  }
  EXPECT_GT(found, 0.98 * kRuns);
  EXPECT_GT(inside, 0.935 * found);
}

TEST(Pseudorange, WithoutTheClockTheFixIsBent) {
  // What the thesis leaves out: a microsecond is 300 m of every range, and no mean takes it away.
  RandomStream random(6);
  const Places3 sky = satellites(random, 6);
  const double bias = 1e-6 * kSpeedOfLight;
  const auto fix = fix_of<3>(received<3>(sky, Vec3(10, 20, 30), bias, 1e-3), Vec3(0, 0, 0));
  EXPECT_NEAR(fix.bias, bias, 1e-4);
  EXPECT_LT((fix.p_map - Vec3(10, 20, 30)).norm(), 1e-4);
}

TEST(Pseudorange, DilutionOfAKnownLayout) {
  // Four around in the plane, at the middle: H = diag(2, 2, 4).
  const auto fix = fix_of<2>(received<2>({{9, 0}, {-9, 0}, {0, 9}, {0, -9}}, {0, 0}, 1));
  EXPECT_NEAR(fix.dilution.hdop, 1, 1e-12);
  EXPECT_NEAR(fix.dilution.pdop, 1, 1e-12);
  EXPECT_NEAR(fix.dilution.tdop, 0.5, 1e-12);
  EXPECT_NEAR(fix.dilution.gdop, std::sqrt(1.25), 1e-12);
  EXPECT_EQ(fix.dilution.vdop, HUGE_VAL);
  // One overhead and three at the horizon, a third of a turn apart: the best of four (Kaplan and
  // Hegarty 2006): by hand HDOP = sqrt(4/3), VDOP = sqrt(4/3), TDOP = sqrt(1/3).
  const double s = std::sqrt(0.75);
  const auto best = fix_of<3>(
      received<3>({{0, 0, 50}, {50, 0, 0}, {-25, 50 * s, 0}, {-25, -50 * s, 0}}, {0, 0, 0}, 1),
      Vec3(0, 0, 0));
  EXPECT_NEAR(best.dilution.hdop, std::sqrt(4.0 / 3), 1e-9);
  EXPECT_NEAR(best.dilution.vdop, std::sqrt(4.0 / 3), 1e-9);
  EXPECT_NEAR(best.dilution.tdop, std::sqrt(1.0 / 3), 1e-9);
  EXPECT_NEAR(best.dilution.gdop, std::sqrt(3.0), 1e-9);
}

TEST(Pseudorange, BeaconsInALineLeaveTheMirror) {
  const auto ranges = received<2>({{0, 0}, {5, 0}, {9, 0}, {15, 0}}, {4, 6}, 2, 0.01);
  const auto open = fix_of<2>(ranges);
  EXPECT_EQ(open.problem, FixProblem::ambiguous);
  const auto fix = fix_of<2>(ranges, Vec2(3, 5));
  EXPECT_LT((fix.p_map - Vec2(4, 6)).norm(), 1e-6);
  ASSERT_TRUE(fix.mirror);
  EXPECT_LT((*fix.mirror - Vec2(4, -6)).norm(), 1e-6);
}

TEST(Pseudorange, BadInput) {
  EXPECT_EQ(fix_of<2>({}).problem, FixProblem::too_few);
  EXPECT_EQ(fix_of<2>(received<2>({{0, 0}, {9, 0}}, {3, 3}, 1)).problem, FixProblem::too_few);
  EXPECT_EQ(fix_of<3>(received<3>({{0, 0, 0}, {9, 0, 1}, {0, 9, 2}}, {3, 3, 3}, 1)).problem,
            FixProblem::too_few);
  EXPECT_EQ(fix_of<2>(received<2>({{1, 1}, {1, 1}, {1, 1}}, {3, 3}, 1)).problem,
            FixProblem::identical);
  auto ranges = received<2>(kAround, {3, 3}, 1);
  ranges[2].range = std::nan("");
  EXPECT_EQ(fix_of<2>(ranges).problem, FixProblem::bad_value);
  ranges = received<2>(kAround, {3, 3}, 1);
  ranges[2].sigma = 0;
  EXPECT_EQ(fix_of<2>(ranges).problem, FixProblem::bad_value);
  EXPECT_THROW(fix_of<2>(std::vector<PseudorangeTo<2>>(65)), Error);
}

// ---- what beacons send ------------------------------------------------------------------------

TEST(BeaconKind, SpeedOfSound) {
  EXPECT_NEAR(speed_of_sound(0), 331.3, 1e-12);
  EXPECT_NEAR(speed_of_sound(20), 343.2, 0.05);  // printed tables: 343.2
  EXPECT_NEAR(speed_of_sound(-20), 318.9, 0.1);  // 318.9
  EXPECT_NEAR(speed_of_sound(40), 354.7, 0.1);   // 354.7
}

TEST(BeaconKind, TemperatureCorrectsTheRange) {
  const BeaconKind& ultrasound = kBeaconKinds[1];
  const double delay = 8.0 / speed_of_sound(35);
  EXPECT_NEAR(range_by_delay(ultrasound, {0, 0}, delay, 35)->range, 8, 1e-12);
  EXPECT_NEAR(range_by_delay(ultrasound, {0, 0}, delay)->range, 7.80, 0.01);  // 15 degrees off
  const BeaconKind& radio = kBeaconKinds[3];
  EXPECT_NEAR(range_by_delay(radio, {0, 0}, 1e-7, 35)->range, 29.98, 0.01);
}

TEST(BeaconKind, RefusesWhatNoSuchBeaconCanSay) {
  for (const BeaconKind& kind : kBeaconKinds) {
    const double most = kind.max_range / speed_of(kind);
    EXPECT_TRUE(range_by_delay(kind, {0, 0}, 0.99 * most));
    EXPECT_FALSE(range_by_delay(kind, {0, 0}, 1.01 * most));
    EXPECT_FALSE(range_by_delay(kind, {0, 0}, -0.1 * most));
    EXPECT_FALSE(range_by_delay(kind, {0, 0}, std::nan("")));
    EXPECT_EQ(range_by_delay(kind, {0, 0}, 0)->sigma, kind.range_sigma);
  }
}

TEST(BeaconKind, EveryKindGivesAFix) {
  for (const BeaconKind& kind : kBeaconKinds) {
    RandomStream random(7);
    const double size = 0.4 * kind.max_range;
    int good = 0;
    for (int run = 0; run < 300; ++run) {
      std::vector<RangeTo> ranges;
      for (int i = 0; i < 8; ++i) {
        const double angle = i * kPi / 4;
        const Vec2 beacon = size * Vec2(std::cos(angle), std::sin(angle));
        const double detour =
            random.uniform() < kind.outlier_rate ? random.uniform(0.2, 1) * size : 0;
        const double way = beacon.norm() + kind.range_sigma * random.normal() + detour;
        if (const auto range = range_by_delay(kind, beacon, way / speed_of(kind))) {
          ranges.push_back(*range);
        }
      }
      const auto fix = trilaterate(ranges);
      good += fix.problem == FixProblem::none && fix.p_map.norm() < 4 * kind.range_sigma;
    }
    EXPECT_GT(good, 290) << kind.name;
  }
}

}  // namespace
}  // namespace majak::beacon
