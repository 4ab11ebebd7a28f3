// SPDX-License-Identifier: Apache-2.0
#include "majak/sim/simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/sim/buildings.hpp"

namespace majak::sim {
namespace {

class SimulatorTest : public testing::Test {
 protected:
  static const World& world() {
    static const World w(building());
    return w;
  }
  /// A quarter of a minute with corners.
  static const Path& path() {
    static const Path p = [] {
      Path whole = plan_tour(world());
      whole.points.resize(200);
      return whole;
    }();
    return p;
  }
  static SimulationOptions quiet() {
    SimulationOptions o;
    scale_noise(o, 0);
    return o;
  }
  template <class T>
  static std::vector<T> all(const std::vector<Event>& events) {
    std::vector<T> out;
    for (const Event& e : events) {
      if (const T* t = std::get_if<T>(&e)) out.push_back(*t);
    }
    return out;
  }
};

/// Every bit of every number, in order.
std::uint64_t fingerprint(const std::vector<Event>& events) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto add = [&hash](auto value) {
    hash = (hash ^ static_cast<std::uint64_t>(value)) * 1099511628211ULL;
  };
  const auto add_pose = [&](const Pose2& T) {
    for (const double v : {T.x, T.y, T.theta}) add(std::bit_cast<std::uint64_t>(v));
  };
  for (const Event& e : events) {
    add(e.index());
    add(time_of(e));
    if (const auto* scan = std::get_if<Scan>(&e)) {
      for (const float r : scan->ranges) add(std::bit_cast<std::uint32_t>(r));
      add_pose(*scan->T_odom_robot);
    } else if (const auto* odometry = std::get_if<Odometry>(&e)) {
      add_pose(odometry->T_odom_robot);
    } else if (const auto* truth = std::get_if<Truth>(&e)) {
      add_pose(truth->T_world_robot);
    } else if (const auto* fix = std::get_if<GpsFix>(&e)) {
      add_pose({fix->east, fix->north, 0});
    }
  }
  return hash;
}

TEST_F(SimulatorTest, EqualSeedsGiveEqualBytes) {
  SimulationOptions o;
  o.people = 3, o.vehicles = 2;
  o.stamp_bursts = 0.1;
  o.satellites.on = true;
  o.felled = 0.3, o.felled_at = 10;
  const auto once = fingerprint(simulate(world(), path(), o));
  EXPECT_EQ(once, fingerprint(simulate(world(), path(), o)));
  o.seed = 2;
  EXPECT_NE(once, fingerprint(simulate(world(), path(), o)));
}

TEST_F(SimulatorTest, WithoutNoiseEveryBeamIsTheRayFromWhereTheRobotWasThen) {
  for (const int beams : {181, 361, 401}) {
    SimulationOptions o = quiet();
    o.beams = beams;
    o.mounting_y = -0.07;
    o.mounting_theta = 0.1;
    Simulator simulator(world(), path(), o);
    const auto variant = sensor::variant_of_beams(beams);
    double moved = 0;
    while (const auto event = simulator.next()) {
      const auto* scan = std::get_if<Scan>(&*event);
      if (scan == nullptr) continue;
      const Duration begin = scan->time - from_seconds(o.start_time);
      ASSERT_EQ(static_cast<int>(scan->ranges.size()), beams);
      const Pose2 T_standing = simulator.run().truth(begin) * scan->T_robot_laser;
      for (int i = 0; i < beams; i += 7) {
        const Pose2 T =
            simulator.run().truth(begin + sensor::beam_time(variant, i)) * scan->T_robot_laser;
        const double expected = world().cast(T.translation(), T.theta + scan->angle(i), 80).range;
        // Stamps are rounded to a microsecond: at a wall's edge the ray may pass it, then.
        if (std::abs(scan->ranges[i] - expected) > 1e-4) {
          const double aside =
              world().cast(T.translation(), T.theta + scan->angle(i) + 1e-5, 80).range;
          const double other =
              world().cast(T.translation(), T.theta + scan->angle(i) - 1e-5, 80).range;
          EXPECT_GT(std::abs(aside - other), 0.01) << scan->ranges[i] << " " << expected;
        }
        const double standing =
            world().cast(T_standing.translation(), T_standing.theta + scan->angle(i), 80).range;
        moved = std::max(moved, std::abs(standing - scan->ranges[i]));
      }
    }
    EXPECT_GT(moved, 0.01);  // the motion within a scan is there
  }
}

TEST_F(SimulatorTest, NoiseIsWhatTheSensorModelSays) {
  SimulationOptions o = quiet();
  o.laser.statistical_error = 0.01;
  const auto clean = all<Scan>(simulate(world(), path(), quiet()));
  const auto noisy = all<Scan>(simulate(world(), path(), o));
  double sum = 0, squares = 0;
  int n = 0;
  for (std::size_t s = 0; s < clean.size(); s += 5) {
    for (std::size_t i = 0; i < clean[s].ranges.size(); ++i) {
      const double e =
          static_cast<double>(noisy[s].ranges[i]) - static_cast<double>(clean[s].ranges[i]);
      sum += e;
      squares += e * e;
      ++n;
    }
  }
  EXPECT_NEAR(sum / n, 0, 4 * 0.01 / std::sqrt(n));
  EXPECT_NEAR(squares / (0.01 * 0.01), n, 4 * std::sqrt(2.0 * n));
}

TEST_F(SimulatorTest, EventsComeInTheOrderOfTheirTimes) {
  for (const double bursts : {0.0, 0.2}) {
    SimulationOptions o;
    o.stamp_bursts = bursts;
    const auto events = simulate(world(), path(), o);
    for (std::size_t i = 1; i < events.size(); ++i) {
      EXPECT_LE(time_of(events[i - 1]), time_of(events[i]));
    }
    for (const Event& e : events) EXPECT_EQ(time_of(e) % 1000, 0);  // whole microseconds
  }
}

TEST_F(SimulatorTest, EveryScanIsFollowedByItsTruth) {
  SimulationOptions o;
  Simulator simulator(world(), path(), o);
  std::optional<Time> open;
  int truths = 0;
  while (const auto event = simulator.next()) {
    if (const auto* scan = std::get_if<Scan>(&*event)) {
      EXPECT_FALSE(open.has_value());
      open = scan->time;
    } else if (const auto* truth = std::get_if<Truth>(&*event)) {
      ASSERT_TRUE(open == truth->time);
      const Pose2 T = simulator.run().truth(truth->time - from_seconds(o.start_time));
      EXPECT_LT(log(between(T, truth->T_world_robot)).norm(), 1e-6);
      open.reset();
      ++truths;
    }
  }
  EXPECT_GT(truths, 200);
}

TEST_F(SimulatorTest, RatesAreWholeTurnsOfTheMirror) {
  SimulationOptions o;
  for (const auto& [wanted, got] : {std::pair{7.5, 7.5}, {10.0, 9.375}, {75.0, 75.0}}) {
    o.scan_rate = wanted;
    const auto scans = all<Scan>(simulate(world(), path(), o));
    const double span = to_seconds(scans.back().time - scans.front().time);
    EXPECT_NEAR(static_cast<double>(scans.size() - 1) / span, got, 1e-4);
  }
  o.beams = 361;
  o.scan_rate = 75;  // half a degree needs two turns
  EXPECT_EQ(Simulator(world(), path(), o).scan_period(), 2 * sensor::kMirrorTurn);
  const auto odometry = all<Odometry>(simulate(world(), path(), {}));
  EXPECT_EQ(odometry[30].time - odometry[20].time, kSecond);
}

TEST_F(SimulatorTest, LaggingOdometryShowsThePast) {
  SimulationOptions o;
  o.odometry_lag = 0.15;
  Simulator simulator(world(), path(), o);
  const Duration lag = from_seconds(0.15);
  while (const auto event = simulator.next()) {
    const Duration t = time_of(*event) - from_seconds(o.start_time);
    const Pose2 late = simulator.run().odometry(t - lag);
    if (const auto* odometry = std::get_if<Odometry>(&*event)) {
      EXPECT_LT(log(between(late, odometry->T_odom_robot)).norm(), 1e-6);
    } else if (const auto* scan = std::get_if<Scan>(&*event)) {
      EXPECT_LT(log(between(late, *scan->T_odom_robot)).norm(), 1e-5);
    }
  }
}

TEST_F(SimulatorTest, MountingIsToldOrNot) {
  SimulationOptions o = quiet();
  o.mounting_x = 0.3;
  const auto told = all<Scan>(simulate(world(), path(), o));
  o.tell_mounting = false;
  const auto untold = all<Scan>(simulate(world(), path(), o));
  EXPECT_EQ(told[0].T_robot_laser, (Pose2{0.3, 0, 0}));
  EXPECT_EQ(untold[0].T_robot_laser, Pose2{});
  EXPECT_EQ(told[9].ranges, untold[9].ranges);  // what is seen does not change
}

TEST_F(SimulatorTest, BurstsMoveStampsAndNothingElse) {
  SimulationOptions o;
  const auto regular = all<Scan>(simulate(world(), path(), o));
  o.stamp_bursts = 0.1;
  const auto events = simulate(world(), path(), o);
  const auto bursty = all<Scan>(events);
  const auto truths = all<Truth>(events);
  ASSERT_EQ(regular.size(), bursty.size());
  std::size_t late = 0;
  for (std::size_t i = 0; i < regular.size(); ++i) {
    EXPECT_EQ(regular[i].ranges, bursty[i].ranges);
    EXPECT_GE(bursty[i].time, regular[i].time);
    EXPECT_LT(to_seconds(bursty[i].time - regular[i].time), 1.2);
    EXPECT_EQ(truths[i].time, bursty[i].time);
    late += bursty[i].time != regular[i].time ? 1 : 0;
  }
  EXPECT_GT(late, regular.size() / 10);
  EXPECT_LT(late, regular.size() * 6 / 10);
}

TEST_F(SimulatorTest, PeopleAreSeenAndWalk) {
  SimulationOptions o = quiet();
  const auto empty = all<Scan>(simulate(world(), path(), o));
  o.people = 20;
  const auto busy = all<Scan>(simulate(world(), path(), o));
  std::size_t nearer = 0, farther = 0;
  for (std::size_t s = 0; s < empty.size(); ++s) {
    for (std::size_t i = 0; i < empty[s].ranges.size(); ++i) {
      nearer += busy[s].ranges[i] < empty[s].ranges[i] - 0.01f ? 1 : 0;
      farther += busy[s].ranges[i] > empty[s].ranges[i] + 0.01f ? 1 : 0;
    }
  }
  EXPECT_GT(nearer, empty.size());
  EXPECT_EQ(farther, 0u);
  // In its first second the robot rests: only what walks can change the picture.
  EXPECT_EQ(empty[0].ranges, empty[6].ranges);
  EXPECT_NE(busy[0].ranges, busy[6].ranges);
}

TEST_F(SimulatorTest, VehiclesDriveBesideTheWay) {
  Scene plain;
  plain.straight = true;
  plain.discs = {{{-1, 9}, 0.2, 0.4}, {{61, -9}, 0.2, 0.4}};
  plain.tour = {{60, 0}};
  const World field(plain);
  SimulationOptions o = quiet();
  o.vehicles = 4;
  Simulator simulator(field, plan_tour(field), o);
  std::size_t seen = 0;
  double fastest = 0;
  std::optional<double> last;
  while (const auto event = simulator.next()) {
    const auto* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr) continue;
    double nearest = 100;
    for (std::size_t i = 0; i < scan->ranges.size(); ++i) {
      if (!std::isfinite(scan->ranges[i])) continue;
      const Duration begin = scan->time - from_seconds(o.start_time);
      const Pose2 T = simulator.run().truth(
                          begin + sensor::beam_time(simulator.variant(), static_cast<int>(i))) *
                      scan->T_robot_laser;
      const double r = scan->ranges[i], a = scan->angle(i);
      const Vec2 p = T * Vec2(r * std::cos(a), r * std::sin(a));
      if (field.clearance(p) < 0.01) continue;
      EXPECT_TRUE(std::abs(p.y()) > 1.85 && std::abs(p.y()) < 3.15) << p.transpose();
      ++seen;
      if (p.y() > 0) nearest = std::min(nearest, p.x());
    }
    const double moved = last ? std::abs(nearest - *last) : 0;
    last = nearest;
    if (moved < 2) fastest = std::max(fastest, moved * 7.5);  // m/s
  }
  EXPECT_GT(seen, 500u);
  EXPECT_GT(fastest, 2);
}

// Where a felled trunk stood nothing is seen from its time on, and until then all is as without.
TEST_F(SimulatorTest, FelledTrunksVanishAtTheirTime) {
  Scene grove;
  grove.straight = true;
  for (int i = 0; i < 200; ++i) {
    RandomStream r(5, 0, static_cast<std::uint64_t>(i));
    const double side = i % 2 == 0 ? 1 : -1;
    grove.discs.push_back({{0.1 * i, side * r.uniform(1, 12)}, 0.1, 0.4});
  }
  grove.tour = {{15, 0}};
  const World world(grove);
  const Path path = plan_tour(world);
  SimulationOptions o = quiet();
  const auto all_of = all<Scan>(simulate(world, path, o));
  o.felled = 0.3, o.felled_at = 8.05;  // between two scans
  Simulator simulator(world, path, o);
  const auto& felled = simulator.felled();
  EXPECT_NEAR(static_cast<double>(felled.size()), 60, 4 * std::sqrt(200 * 0.3 * 0.7));
  std::size_t n = 0, before = 0;
  while (const auto event = simulator.next()) {
    const auto* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr) continue;
    const Duration begin = scan->time - from_seconds(o.start_time);
    const bool late = begin > from_seconds(8.05);
    if (!late) {
      EXPECT_EQ(scan->ranges, all_of[n].ranges);
    }
    ++n;
    for (std::size_t i = 0; i < scan->ranges.size(); ++i) {
      if (!std::isfinite(scan->ranges[i])) continue;
      const Pose2 T = simulator.run().truth(
                          begin + sensor::beam_time(simulator.variant(), static_cast<int>(i))) *
                      scan->T_robot_laser;
      const double r = scan->ranges[i], a = scan->angle(i);
      const Vec2 p = T * Vec2(r * std::cos(a), r * std::sin(a));
      const auto on = [&](std::size_t k) {
        return std::abs((grove.discs[k].centre - p).norm() - grove.discs[k].radius) < 1e-4;
      };
      const bool of_felled = std::any_of(felled.begin(), felled.end(), on);
      EXPECT_FALSE(late && of_felled) << p.transpose();
      before += of_felled;
    }
  }
  EXPECT_GT(before, 100u);
  o.felled = 0.6;
  const auto more = Simulator(world, path, o).felled();
  EXPECT_TRUE(std::includes(more.begin(), more.end(), felled.begin(), felled.end()));
}

TEST_F(SimulatorTest, ReflectorsAreNotFelled) {
  Scene scene = world().scene();
  const std::size_t posts = scene.discs.size();
  scene.discs.push_back(reflector({7, 12}));
  SimulationOptions o = quiet();
  o.felled = 1;
  EXPECT_EQ(Simulator(World(scene), path(), o).felled().size(), posts);
}

TEST_F(SimulatorTest, ShortSightedInTheLongCorridor) {
  const World empty(corridor());
  SimulationOptions o = quiet();
  o.laser.max_range = 8;
  Simulator simulator(empty, plan_tour(empty, {.short_tour = true}), o);
  std::size_t returns = 0;
  while (const auto event = simulator.next()) {
    const auto* scan = std::get_if<Scan>(&*event);
    if (scan == nullptr) continue;
    EXPECT_EQ(scan->max_range, 8.0f);
    const Pose2 T =
        simulator.run().truth(scan->time - from_seconds(o.start_time)) * scan->T_robot_laser;
    for (std::size_t i = 0; i < scan->ranges.size(); ++i) {
      if (!std::isfinite(scan->ranges[i])) continue;
      const double r = scan->ranges[i], a = scan->angle(i);
      EXPECT_NEAR(std::abs((T * Vec2(r * std::cos(a), r * std::sin(a))).y()), 1.2, 0.03);
      ++returns;
    }
  }
  EXPECT_GT(returns, 10000u);
}

TEST_F(SimulatorTest, NonsenseIsAnError) {
  const auto refuses = [&](auto change) {
    SimulationOptions o;
    change(o);
    EXPECT_THROW(Simulator(world(), path(), o), Error);
  };
  refuses([](SimulationOptions& o) { o.beams = 180; });
  refuses([](SimulationOptions& o) { o.scan_rate = 0; });
  refuses([](SimulationOptions& o) { o.odometry_rate = -1; });
  refuses([](SimulationOptions& o) { o.odometry_lag = 100; });
  refuses([](SimulationOptions& o) { o.people = -1; });
  refuses([](SimulationOptions& o) { o.vehicles = -1; });
  refuses([](SimulationOptions& o) { o.felled = 1.1; });
  refuses([](SimulationOptions& o) { o.felled_at = std::nan(""); });
  refuses([](SimulationOptions& o) { o.start_time = std::nan(""); });
}

TEST_F(SimulatorTest, IntensitiesLeaveTheRangesAlone) {
  SimulationOptions o;
  const auto plain = all<Scan>(simulate(world(), path(), o));
  o.intensities = true;
  const auto bright = all<Scan>(simulate(world(), path(), o));
  ASSERT_EQ(plain.size(), bright.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(plain[i].ranges, bright[i].ranges);
    EXPECT_TRUE(plain[i].intensities.empty());
    ASSERT_EQ(bright[i].intensities.size(), bright[i].ranges.size());
    for (std::size_t k = 0; k < bright[i].ranges.size(); ++k) {
      EXPECT_EQ(bright[i].intensities[k] > 0, std::isfinite(bright[i].ranges[k]));
    }
  }
}

TEST_F(SimulatorTest, AReflectorIsSeenBetweenTwoBeamsAndOutshinesTheWall) {
  Scene scene;
  scene.segments = {{{-20, -20}, {20, -20}},
                    {{20, -20}, {20, 20}},
                    {{20, 20}, {-20, 20}},
                    {{-20, 20}, {-20, -20}}};
  scene.start = {-5, 0, 0};
  // 10 cm wide at 12 m is half a degree, in the middle between two beams.
  const double angle = radians(0.5);
  scene.discs = {reflector({-5 + 12 * std::cos(angle), 12 * std::sin(angle)})};
  const World room(scene);
  SimulationOptions o;
  o.mounting_x = 0;
  o.intensities = true;
  o.laser.statistical_error = o.laser.systematic_error = o.laser.no_return = 0;
  Path way{.start = scene.start, .points = {}};
  for (int i = 0; i <= 20; ++i) way.points.push_back({-5 + kPathStep * i, 0});
  const Scan first = all<Scan>(simulate(room, way, o)).at(0);
  float brightest = 0;
  std::size_t at = 0;
  for (std::size_t k = 0; k < first.ranges.size(); ++k) {
    if (first.intensities[k] > brightest) brightest = first.intensities[k], at = k;
  }
  EXPECT_NEAR(first.angle(at), angle, radians(0.6));
  EXPECT_NEAR(first.ranges[at], 11.97, 0.03);
  EXPECT_GT(brightest, 5 * first.intensities[at - 3]);
}

TEST_F(SimulatorTest, OptionsDescribeThemselves) {
  SimulationOptions o;
  OptionFields fields;
  describe(fields, o);
  std::vector<std::string> names;
  for (const OptionField& f : fields.list) {
    names.push_back(f.name);
    if (const auto* value = std::get_if<double*>(&f.value)) {
      EXPECT_TRUE(**value >= f.info.min && **value <= f.info.max) << f.name;
    }
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
}

}  // namespace
}  // namespace majak::sim
