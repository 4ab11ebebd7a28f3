// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/satellites.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/sim/park.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::sim {
namespace {

constexpr Duration kLong = 1'000'000 * kSecond;

SatelliteOptions switched_on(SatelliteOptions o = {}) {
  o.on = true;
  return o;
}

SatelliteOptions exact() {
  SatelliteOptions o = switched_on();
  o.sigma = o.bias_sigma = 0;
  return o;
}

TEST(Satellites, BurstsAndOutagesHaveTheirMeans) {
  const Satellites satellites(switched_on(), kLong, 3);
  const auto& bursts = satellites.bursts();
  double on = 0, off = 0;
  const auto n = static_cast<double>(bursts.size() - 1);  // the last is cut to end with the run
  for (std::size_t i = 0; i + 1 < bursts.size(); ++i) {
    on += to_seconds(bursts[i].end - bursts[i].begin);
    off += to_seconds(bursts[i + 1].begin - bursts[i].end);
  }
  EXPECT_GT(n, 10000);
  EXPECT_NEAR(on / n, 8, 4 * 8 / std::sqrt(n));
  EXPECT_NEAR(off / n, 55, 4 * 55 / std::sqrt(n));
}

TEST(Satellites, ARunBeginsAndEndsWithABurst) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Duration run = static_cast<Duration>(seed) * 3 * kSecond;
    const Satellites satellites(switched_on(), run, seed);
    const auto& bursts = satellites.bursts();
    ASSERT_FALSE(bursts.empty());
    EXPECT_EQ(bursts.front().begin, 0);
    EXPECT_EQ(bursts.back().end, run);
    for (std::size_t i = 1; i < bursts.size(); ++i)
      EXPECT_TRUE(bursts[i - 1].end < bursts[i].begin && bursts[i].begin <= bursts[i].end);
    EXPECT_TRUE(satellites.fix(0, {}));
    for (std::int64_t k = 0; satellites.time(k) <= run; ++k) {
      bool within = false;
      for (const auto& b : bursts)
        within |= satellites.time(k) >= b.begin && satellites.time(k) <= b.end;
      EXPECT_EQ(satellites.fix(k, {}).has_value(), within);
    }
  }
}

// Both axes: mean 0, the said sigma, no relation between neighbours or axes.
TEST(Satellites, ErrorsHaveTheirSigmasAndFixesAreIndependentWithinABurst) {
  const Satellites satellites(switched_on(), kLong / 10, 7);
  double n = 0, b = 0;
  Vec2 sum = Vec2::Zero(), squares = sum, biases = sum, next = sum, before = sum;
  double across = 0;
  for (const auto& burst : satellites.bursts()) {
    biases += burst.bias.cwiseAbs2();
    ++b;
    const auto first = static_cast<std::int64_t>(std::ceil(to_seconds(burst.begin) * 5));
    before.setZero();
    for (std::int64_t k = first; satellites.time(k) <= burst.end; ++k, ++n) {
      const auto fix = satellites.fix(k, {});
      ASSERT_TRUE(fix);
      EXPECT_EQ(fix->sigma, 0);  // not said
      const Vec2 e = (Vec2(fix->east, fix->north) - burst.bias) / 0.08;
      sum += e, squares += e.cwiseAbs2(), next += e.cwiseProduct(before), across += e.x() * e.y();
      before = e;
    }
  }
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(sum[axis], 0, 4 * std::sqrt(n));
    EXPECT_NEAR(squares[axis], n, 4 * std::sqrt(2 * n));
    EXPECT_NEAR(next[axis], 0, 4 * std::sqrt(n));
    EXPECT_NEAR(biases[axis] / (0.35 * 0.35), b, 4 * std::sqrt(2 * b));
  }
  EXPECT_NEAR(across, 0, 4 * std::sqrt(n));
}

TEST(Satellites, TheAntennaTurnsWithTheRobot) {
  SatelliteOptions o = exact();
  o.antenna_x = 1.2, o.antenna_y = -0.4, o.outage = 0;
  const Satellites satellites(o, 100 * kSecond, 1);
  for (std::int64_t k = 0; k < 100; ++k) {
    const Pose2 T{3.0 * static_cast<double>(k), -7, 0.1 * static_cast<double>(k)};
    const auto fix = satellites.fix(k, T);
    ASSERT_TRUE(fix);
    const double c = std::cos(T.theta), s = std::sin(T.theta);
    EXPECT_NEAR(fix->east, T.x + 1.2 * c + 0.4 * s, 1e-12);
    EXPECT_NEAR(fix->north, T.y + 1.2 * s - 0.4 * c, 1e-12);
  }
}

TEST(Satellites, FaultsActInTheirTimeOnly) {
  SatelliteOptions o = switched_on();
  o.outage = 0;
  const Satellites sound(o, 200 * kSecond, 5);
  o.jump = 12, o.jump_begin = 40, o.jump_duration = 7;
  const Satellites jumps(o, 200 * kSecond, 5);
  o.jump = 0, o.missing_until = 90;
  const Satellites late(o, 200 * kSecond, 5);
  for (std::int64_t k = 0; k < 1000; ++k) {
    const double time = 0.2 * static_cast<double>(k);
    const auto a = sound.fix(k, {}), b = jumps.fix(k, {}), c = late.fix(k, {});
    ASSERT_TRUE(a && b);
    const bool off = k >= 200 && k < 235;
    EXPECT_NEAR(std::hypot(b->east - a->east, b->north - a->north), off ? 12 : 0, 1e-12) << time;
    EXPECT_EQ(c.has_value(), k >= 450) << time;
    if (c) {
      EXPECT_EQ(c->east, a->east);
    }
  }
}

TEST(Satellites, AJumpWaitsForTheNextBurst) {
  SatelliteOptions o = exact();
  o.jump = 5, o.jump_duration = 2;
  int waited = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Satellites satellites(o, 600 * kSecond, seed);
    double first = -1, last = -1;
    for (std::int64_t k = 0; k <= 3000; ++k) {
      const auto fix = satellites.fix(k, {});
      if (!fix || std::hypot(fix->east, fix->north) < 1e-9) continue;
      EXPECT_NEAR(std::hypot(fix->east, fix->north), 5, 1e-12);
      last = to_seconds(satellites.time(k));
      if (first < 0) first = last;
    }
    if (first < 0) continue;  // a burst too short for a fix
    EXPECT_GE(first, 60);
    EXPECT_LE(last - first, 2);
    waited += first > 60;
    for (const auto& burst : satellites.bursts()) {  // none between 60 s and the first one
      EXPECT_FALSE(to_seconds(burst.begin) > 60 && to_seconds(burst.begin) < first - 0.2 &&
                   burst.end - burst.begin > kSecond / 5)
          << seed;
    }
  }
  EXPECT_GT(waited, 30);
}

TEST(Satellites, OffThereIsNothing) {
  const Satellites satellites({}, 100 * kSecond, 1);
  EXPECT_TRUE(satellites.bursts().empty());
  EXPECT_FALSE(satellites.fix(0, {}));
}

TEST(Satellites, NonsenseIsAnError) {
  const auto refuses = [](auto change) {
    SatelliteOptions o = switched_on();
    change(o);
    EXPECT_THROW(Satellites(o, kSecond, 1), Error);
  };
  refuses([](SatelliteOptions& o) { o.rate = 0; });
  refuses([](SatelliteOptions& o) { o.burst = 0; });
  refuses([](SatelliteOptions& o) { o.outage = std::nan(""); });
  refuses([](SatelliteOptions& o) { o.sigma = -1; });
}

class SimulatedFixes : public testing::Test {
 protected:
  static const World& world() {
    static const World w(park());
    return w;
  }
  static const Path& path() {
    static const Path p = plan_tour(world(), {.short_tour = true});
    return p;
  }
  static SimulationOptions car() {
    SimulationOptions o;
    make_car(o);
    o.robot.reports_steering = true;
    o.satellites.on = true;
    o.satellites.outage = 6;
    return o;
  }
};

TEST_F(SimulatedFixes, AreOfTheAntennaAtTheirTime) {
  SimulationOptions o = car();
  o.odometry_lag = 0.3;  // the satellites have none
  scale_noise(o, 0);
  Simulator simulator(world(), path(), o);
  int fixes = 0;
  Time last = 0;
  while (const auto event = simulator.next()) {
    EXPECT_GE(time_of(*event), last);
    last = time_of(*event);
    const auto* fix = std::get_if<GpsFix>(&*event);
    if (fix == nullptr) continue;
    const Pose2 T = simulator.run().truth(fix->time - from_seconds(o.start_time));
    const Vec2 antenna = T * Vec2(o.satellites.antenna_x, o.satellites.antenna_y);
    EXPECT_NEAR((Vec2(fix->east, fix->north) - antenna).norm(), 0, 1e-9);
    ++fixes;
  }
  EXPECT_GT(fixes, 30);
}

TEST_F(SimulatedFixes, AreTheSameForASeedAndLeaveAllElseAlone) {
  SimulationOptions o = car();
  const auto twice = simulate(world(), path(), o), with = simulate(world(), path(), o);
  o.satellites.on = false;
  const auto without = simulate(world(), path(), o);
  ASSERT_EQ(with.size(), twice.size());
  std::size_t k = 0;
  for (std::size_t i = 0; i < with.size(); ++i) {
    if (const auto* fix = std::get_if<GpsFix>(&with[i])) {
      EXPECT_EQ(fix->east, std::get<GpsFix>(twice[i]).east);
      continue;
    }
    ASSERT_LT(k, without.size());
    ASSERT_EQ(with[i].index(), without[k].index());
    EXPECT_EQ(time_of(with[i]), time_of(without[k]));
    if (const auto* scan = std::get_if<Scan>(&with[i])) {
      EXPECT_EQ(scan->ranges, std::get<Scan>(without[k]).ranges);
    }
    ++k;
  }
  EXPECT_EQ(k, without.size());
  EXPECT_LT(k, with.size());
}

}  // namespace
}  // namespace majak::sim
