// SPDX-License-Identifier: Apache-2.0
// Graph SLAM end to end, on simulated runs with ordinary noise and on logs that are hardly one.
#include "majak/slam/graph_slam.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>
#include <vector>

#include "majak/core/error.hpp"
#include "tests/support/ascii_room.hpp"
#include "tests/unit/slam/simulated.hpp"

namespace majak::slam {
namespace {

using fixture::all_around;
using fixture::AsciiRoom;
using fixture::Laser;

const Site& building_site() {
  static const Site site = map_of(building_run());
  return site;
}

/// Every number of a site that a run may differ in.
std::vector<double> numbers(const Site& site) {
  std::vector<double> all;
  const auto add = [&](const Pose2& p) { all.insert(all.end(), {p.x, p.y, p.theta}); };
  const auto add3 = [&](const Mat3& m) { all.insert(all.end(), m.data(), m.data() + 9); };
  for (const PosedScan& s : site.scans) {
    add(s.estimate.T_map_robot), add3(s.estimate.covariance), add(s.T_map_robot_front_end);
    all.insert(all.end(), {static_cast<double>(s.estimate.health), s.estimate.weak_direction.x(),
                           s.match_score, s.key ? 1.0 : 0.0});
  }
  for (const Constraint& c : site.constraints) {
    add(c.T_from_to), add3(c.information);
    all.insert(all.end(), {static_cast<double>(c.from), static_cast<double>(c.to), c.score,
                           c.overlap, c.chi2});
  }
  return all;
}

TEST(GraphSlam, MapsABuilding) {
  const Site& site = building_site();
  const PathError error = error_of(site);
  EXPECT_LT(error.rms, 0.025);  // 100 m of way, 35 mm of systematic range error at most
  EXPECT_LT(error.worst, 0.06);
  EXPECT_GT(closures_of(site), 5);
  EXPECT_TRUE(site.used_odometry);
}

TEST(GraphSlam, EveryScanHasAPoseAndACovariance) {
  const Site& site = building_site();
  std::size_t scans = 0, keys = 0, ok = 0;
  for (const Event& e : building_run()) scans += std::holds_alternative<Scan>(e);
  ASSERT_EQ(site.scans.size(), scans);
  std::size_t next = 0;
  for (const Event& e : building_run()) {
    const auto* scan = std::get_if<Scan>(&e);
    if (scan == nullptr) continue;
    const PosedScan& posed = site.scans[next++];
    ASSERT_EQ(posed.scan.time, scan->time);  // in the log's order
    ASSERT_EQ(posed.scan.ranges, scan->ranges);
    ASSERT_EQ(posed.estimate.time, scan->time);
    ASSERT_TRUE(posed.estimate.T_map_robot.finite());
    ASSERT_TRUE(posed.T_map_robot_front_end.finite());
    const Mat3& c = posed.estimate.covariance;
    ASSERT_TRUE(c.allFinite());
    ASSERT_LT((c - c.transpose()).norm(), 1e-9 * c.norm());
    ASSERT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(c).eigenvalues()(0), 0);
    keys += posed.key;
    ok += posed.estimate.health != Health::lost;
  }
  EXPECT_GT(keys, 200U);
  EXPECT_LT(keys, scans / 2);
  EXPECT_EQ(ok, scans);
}

TEST(GraphSlam, ConstraintsNameKeyScansAndFitThePoses) {
  const Site& site = building_site();
  ASSERT_FALSE(site.constraints.empty());
  int closures = 0, close = 0;
  for (const Constraint& c : site.constraints) {
    ASSERT_LT(c.from, site.scans.size());
    ASSERT_LT(c.to, site.scans.size());
    ASSERT_NE(c.from, c.to);
    EXPECT_TRUE(site.scans[c.from].key);
    EXPECT_TRUE(site.scans[c.to].key);
    EXPECT_GE(c.chi2, 0);
    EXPECT_LT((c.information - c.information.transpose()).norm(), 1e-6 * c.information.norm());
    if (c.kind != ConstraintKind::closure) continue;
    EXPECT_GE(c.score, LoopClosingOptions{}.agreement);
    EXPECT_GE(c.overlap, LoopClosingOptions{}.overlap);
    const Pose2 poses =
        between(site.scans[c.from].estimate.T_map_robot, site.scans[c.to].estimate.T_map_robot);
    ++closures;
    // Along a corridor one may slide, but then it must say so.
    EXPECT_LT(c.chi2, 40);
    close += between(c.T_from_to, poses).translation().norm() < 0.05;
  }
  EXPECT_GT(close, 0.8 * closures);
}

TEST(GraphSlam, SameBytesForAnyNumberOfThreads) {
  const auto one = numbers(building_site());
  EXPECT_EQ(numbers(map_of(building_run(), {}, 2)), one);
  EXPECT_EQ(numbers(map_of(building_run(), {}, 8)), one);
}

TEST(GraphSlam, PeopleWhoWalkAlongDoNotTakeItWithThem) {
  for (const int seed : {2, 3, 4}) {
    sim::SimulationOptions options;
    options.seed = seed, options.people = 4;
    EXPECT_LT(error_of(map_of(simulated_run("building", 0, options))).rms, 0.03) << seed;
  }
}

// Recesses that repeat look like the place that is due when a lap is full.
TEST(GraphSlam, WallsThatRepeatAreNotTakenForOneAnother) {
  for (const auto& [seed, range] : {std::pair{3, 80.0}, std::pair{2, 8.0}}) {
    sim::SimulationOptions options;
    options.seed = seed, options.laser.max_range = range;
    options.robot.left_scale = 1.02, options.robot.slip = 0.02;
    const Site site = map_of(simulated_run("large_ring", 0, options));
    const auto pose = [](const PosedScan& s) { return s.estimate.T_map_robot; };
    EXPECT_LT(shape_error_of(site, pose).rms, 0.2) << seed;
    EXPECT_GE(closures_of(site), 15) << seed;
  }
}

TEST(GraphSlam, WithoutLoopsThereAreNone) {
  GraphSlamOptions options;
  options.close_loops = false;
  const Site site = map_of(building_run(), options);
  EXPECT_EQ(closures_of(site), 0);
  EXPECT_LT(error_of(site).worst, 0.15);
  EXPECT_GT(error_of(site).worst, error_of(building_site()).worst);
}

TEST(GraphSlam, AClosureSwitchedOffIsListedAndNotUsed) {
  const auto first = std::find_if(
      building_site().constraints.begin(), building_site().constraints.end(),
      [](const Constraint& c) { return c.kind == ConstraintKind::closure && c.enabled; });
  ASSERT_NE(first, building_site().constraints.end());
  GraphSlamOptions options;
  options.loops.switched_off = {{first->from, first->to}};
  const Site site = map_of(building_run(), options);
  int listed = 0;
  for (const Constraint& c : site.constraints) {
    if (c.kind != ConstraintKind::closure || c.from != first->from || c.to != first->to) continue;
    ++listed;
    EXPECT_FALSE(c.enabled);
  }
  EXPECT_EQ(listed, 1);
  EXPECT_NE(numbers(site), numbers(building_site()));
}

TEST(GraphSlam, WithoutLoopsTheFrontEndIsNotMadeWorse) {
  for (const bool wheels : {true, false})
    for (const char* world : {"building", "ring"}) {
      GraphSlamOptions options;
      options.close_loops = false;
      options.chain.use_odometry = wheels;
      const Site site = map_of(simulated_run(world), options);
      const double refined =
          shape_error_of(site, [](const PosedScan& s) { return s.estimate.T_map_robot; }).worst;
      const double front_end =
          shape_error_of(site, [](const PosedScan& s) { return s.T_map_robot_front_end; }).worst;
      EXPECT_LT(refined, 1.3 * front_end + 0.03) << world << (wheels ? "" : " without wheels");
    }
}

TEST(GraphSlam, TheLaserAloneIsEnough) {
  GraphSlamOptions options;
  options.chain.use_odometry = false;
  const Site site = map_of(building_run(), options);
  EXPECT_FALSE(site.used_odometry);
  EXPECT_LT(error_of(site).rms, 0.035);
  for (const PosedScan& s : site.scans) ASSERT_FALSE(s.T_odom_robot.has_value());
}

TEST(GraphSlam, ALogWithoutOdometryIsTheSameAsOneWhoseOdometryIsNotUsed) {
  std::vector<Event> bare;
  for (Event e : building_run()) {
    if (std::holds_alternative<Odometry>(e)) continue;
    if (auto* scan = std::get_if<Scan>(&e)) scan->T_odom_robot.reset();
    bare.push_back(std::move(e));
  }
  bare.resize(bare.size() / 3);
  std::vector<Event> full(building_run());
  while (std::get_if<Scan>(&full.back()) == nullptr || time_of(full.back()) > time_of(bare.back()))
    full.pop_back();
  while (std::get_if<Scan>(&bare.back()) == nullptr) bare.pop_back();
  GraphSlamOptions alone;
  alone.chain.use_odometry = false;
  const Site without = map_of(bare), unused = map_of(full, alone);
  ASSERT_EQ(without.scans.size(), unused.scans.size());
  EXPECT_FALSE(without.used_odometry);
  EXPECT_EQ(numbers(without), numbers(unused));
}

// What is learnt of the clock late in a run holds for its first scans, too.
TEST(GraphSlam, TheOdometryOfEveryScanIsMended) {
  sim::SimulationOptions options;
  options.odometry_lag = 0.3;
  const Site site = map_of(simulated_run("building", 0, options));
  ASSERT_TRUE(site.odometry.lag_s.used);
  double worst = 0;
  for (std::size_t i = 1; i < site.scans.size(); ++i) {
    const PosedScan &a = site.scans[i - 1], &b = site.scans[i];
    if (!a.T_odom_robot || !b.T_odom_robot) continue;
    const Pose2 off = between(between(*a.T_odom_robot, *b.T_odom_robot),
                              between(a.estimate.T_map_robot, b.estimate.T_map_robot));
    worst = std::max(worst, std::abs(off.theta));
  }
  EXPECT_LT(worst, 0.018);  // seen: 0.0138; 0.083 unmended
}

TEST(GraphSlam, GivesAnEstimateAsItGoes) {
  GraphSlam slam({}, {});
  const auto truth = truth_of(building_run());
  std::size_t estimates = 0, fed = 0;
  Pose2 T_world_map;
  double worst = 0;
  for (const Event& e : building_run()) {
    if (++fed > 1500) break;
    const auto estimate = slam.add(e);
    if (!estimate) continue;
    if (estimates++ == 0) T_world_map = truth.at(estimate->time) * estimate->T_map_robot.inverse();
    worst = std::max(worst, between(truth.at(estimate->time), T_world_map * estimate->T_map_robot)
                                .translation()
                                .norm());
  }
  EXPECT_GT(estimates, 400U);
  EXPECT_LT(worst, 0.2);
}

// Logs that are hardly one.

const AsciiRoom& room() {
  static const AsciiRoom r({
      "####################",
      "#........#.........#",
      "#........#.........#",
      "#..................#",
      "#.....a............#",
      "#..................#",
      "#..................#",
      "###.......#........#",
      "###.......##.......#",
      "####################",
  });
  return r;
}

Scan scan_at(const Pose2& T_map_robot, double seconds, int beams = 181) {
  Laser laser = all_around(beams);
  laser.noise = 0.005;
  laser.seed = static_cast<int>(100 * seconds) + 1;
  Scan scan = room().scan(T_map_robot, laser);
  scan.time = from_seconds(seconds);
  return scan;
}

/// A metre a second to the right and turning, 4 s.
Pose2 walk(double seconds) {
  return room().pose('a') * exp(Vec3(0.9 * seconds, 0.1 * seconds, 0.2 * seconds));
}

double worst_of(const Site& site, const std::vector<Pose2>& truth) {
  const Pose2 T_world_map = truth.front() * site.scans.front().estimate.T_map_robot.inverse();
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    worst = std::max(
        worst,
        between(truth[i], T_world_map * site.scans[i].estimate.T_map_robot).translation().norm());
  return worst;
}

TEST(GraphSlam, OneScanIsAMap) {
  const Site site = map_of({scan_at(walk(0), 0)});
  ASSERT_EQ(site.scans.size(), 1U);
  EXPECT_TRUE(site.scans[0].key);
  EXPECT_TRUE(site.constraints.empty());
  EXPECT_LT(site.scans[0].estimate.T_map_robot.vector().norm(), 1e-3);
  EXPECT_TRUE(site.scans[0].estimate.covariance.allFinite());
  EXPECT_FALSE(site.used_odometry);
}

TEST(GraphSlam, NothingToMapIsAnError) {
  EXPECT_THROW(map_of({}), Error);
  Scan blind;
  blind.angle_step = 0.01;
  blind.ranges.assign(181, kNoReturn);
  EXPECT_THROW(map_of({blind, blind, blind}), Error);
  blind.ranges.assign(181, kInvalidRange);
  EXPECT_THROW(map_of({blind}), Error);
  EXPECT_THROW(map_of({Odometry{}, Odometry{}}), Error);
}

TEST(GraphSlam, ScansWithTooFewReturnsAreCarriedAlong) {
  std::vector<Event> events;
  std::vector<Pose2> truth;
  for (int i = 0; i < 40; ++i) {
    const double t = 0.1 * i;
    Scan scan = scan_at(walk(t), t);
    if (i < 3 || i % 7 == 5) std::fill(scan.ranges.begin() + 6, scan.ranges.end(), kNoReturn);
    scan.T_odom_robot = walk(t);
    truth.push_back(walk(t));
    events.push_back(scan);
  }
  const Site site = map_of(events);
  ASSERT_EQ(site.scans.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i)
    EXPECT_FALSE(site.scans[i].key && (i < 3 || i % 7 == 5)) << i;
  EXPECT_LT(worst_of(site, truth), 0.03);
}

TEST(GraphSlam, BeamCountsMayChange) {
  std::vector<Event> events;
  std::vector<Pose2> truth;
  for (int i = 0; i < 40; ++i) {
    const int beams[] = {181, 361, 90};
    events.push_back(scan_at(walk(0.1 * i), 0.1 * i, beams[i % 3]));
    truth.push_back(walk(0.1 * i));
  }
  const Site site = map_of(events);
  ASSERT_EQ(site.scans.size(), 40U);
  EXPECT_LT(worst_of(site, truth), 0.03);
}

TEST(GraphSlam, TimeMayRunBackwards) {
  std::vector<Event> events;
  std::vector<Pose2> truth;
  for (int i = 0; i < 40; ++i) {
    Scan scan = scan_at(walk(0.1 * i), 0.1 * i);
    if (i == 12 || i == 25) scan.time = -3600 * kSecond;  // a clock that was set
    if (i > 30) scan.time = 0;
    events.push_back(scan);
    truth.push_back(walk(0.1 * i));
  }
  const Site site = map_of(events);
  ASSERT_EQ(site.scans.size(), 40U);
  EXPECT_LT(worst_of(site, truth), 0.03);
  EXPECT_EQ(site.scans[12].scan.time, -3600 * kSecond);
}

TEST(GraphSlam, OnlyTheFrontLaserMaps) {
  Scan rear = scan_at(walk(0), 0);
  rear.laser = 1;
  const Site site = map_of({scan_at(walk(0), 0), rear, scan_at(walk(0.1), 0.1)});
  EXPECT_EQ(site.scans.size(), 2U);
}

TEST(GraphSlam, ScansThatWaitForOdometryAreNotForgotten) {
  // All odometry before the last scans: those wait for more of it, which never comes.
  std::vector<Event> events;
  for (int i = 0; i < 20; ++i)
    events.push_back(Odometry{from_seconds(0.1 * i), walk(0.1 * i), {}, {}});
  for (int i = 0; i < 40; ++i) events.push_back(scan_at(walk(0.1 * i), 0.1 * i));
  GraphSlam slam({}, {});
  Time newest = 0;
  for (const Event& e : events)
    if (const auto estimate = slam.add(e)) newest = estimate->time;
  EXPECT_GT(newest, from_seconds(2.5));  // it does not wait for ever
  const Site site = slam.finish().site;
  ASSERT_EQ(site.scans.size(), 40U);
  EXPECT_TRUE(site.scans[5].T_odom_robot.has_value());
  EXPECT_FALSE(site.scans[39].T_odom_robot.has_value());
  std::vector<Pose2> truth;
  for (int i = 0; i < 40; ++i) truth.push_back(walk(0.1 * i));
  EXPECT_LT(worst_of(site, truth), 0.03);
}

TEST(GraphSlam, AnEmptyCorridorIsReportedAsWeak) {
  // Two walls and nothing else within reach: the way along them is the odometry's.
  const AsciiRoom corridor({std::string(120, '#'), "", "", "", std::string(120, '#')});
  std::vector<Event> events;
  for (int i = 0; i < 60; ++i) {
    Laser laser;
    laser.max_range = 6;
    laser.noise = 0.005;
    laser.seed = i + 1;
    const Pose2 T{20 + 0.1 * i, 1.2, 0};
    Scan scan = corridor.scan(T, laser);
    scan.time = from_seconds(0.1 * i);
    scan.T_odom_robot = T;
    events.push_back(scan);
  }
  const Site site = map_of(events);
  int weak = 0;
  for (const PosedScan& s : site.scans) {
    if (s.estimate.health != Health::degraded) continue;
    ++weak;
    EXPECT_NEAR(std::abs(s.estimate.weak_direction.x()), 1, 0.05);
    EXPECT_NEAR(s.estimate.weak_direction.norm(), 1, 1e-6);
  }
  EXPECT_GT(weak, 50);
  const Estimate& last = site.scans.back().estimate;
  EXPECT_GT(last.covariance(0, 0), 10 * last.covariance(1, 1));
  const double error = between(site.scans.front().estimate.T_map_robot, last.T_map_robot).x - 5.9;
  EXPECT_LT(std::abs(error), 3 * std::sqrt(last.covariance(0, 0)));
  EXPECT_LT(std::abs(error), 0.6);
}

// Options.

TEST(GraphSlamOptions, EachIsListedOnceWithinItsRange) {
  GraphSlamOptions options;
  OptionFields fields;
  describe(fields, options);
  std::set<std::string> names;
  std::set<const void*> places;
  for (const OptionField& f : fields.list) {
    EXPECT_TRUE(names.insert(f.name).second) << f.name << " twice";
    EXPECT_TRUE(
        places
            .insert(std::visit([](const auto* v) { return static_cast<const void*>(v); }, f.value))
            .second)
        << f.name;
    EXPECT_NE(f.name.find('.'), std::string::npos) << f.name;
    EXPECT_STRNE(f.info.help, "") << f.name;
    const double value = std::visit([](const auto* v) { return static_cast<double>(*v); }, f.value);
    EXPECT_GE(value, f.info.min) << f.name;
    EXPECT_LE(value, f.info.max) << f.name;
  }
  EXPECT_TRUE(names.count("slam.use_odometry"));
  EXPECT_TRUE(names.count("slam.close_loops"));
}

TEST(GraphSlamOptions, WhatIsReadIsWhatWasWritten) {
  GraphSlamOptions written, read;
  OptionFields from, to;
  describe(from, written);
  describe(to, read);
  for (OptionField& f : from.list) {
    if (auto* b = std::get_if<bool*>(&f.value)) **b = !**b;
    if (auto* i = std::get_if<int*>(&f.value)) **i += 1;
    if (auto* d = std::get_if<double*>(&f.value)) **d *= 1.25;
  }
  ASSERT_EQ(from.list.size(), to.list.size());
  for (std::size_t i = 0; i < from.list.size(); ++i)
    std::visit([&](auto* v) { *v = *std::get<std::decay_t<decltype(v)>>(from.list[i].value); },
               to.list[i].value);
  EXPECT_FALSE(read.chain.use_odometry);
  EXPECT_EQ(read.chain.front_end.key_distance, written.chain.front_end.key_distance);
  EXPECT_EQ(read.loops.near, 1.25 * LoopClosingOptions{}.near);
  EXPECT_EQ(read.refinement.rounds, JointRefinementOptions{}.rounds + 1);
}

TEST(GraphSlamOptions, TakeEffect) {
  GraphSlamOptions coarse;
  coarse.chain.front_end.key_distance = 0.6;
  coarse.chain.front_end.key_turn = 0.5;
  std::vector<Event> part(building_run().begin(), building_run().begin() + 1000);
  const auto keys = [](const Site& site) {
    return std::count_if(site.scans.begin(), site.scans.end(),
                         [](const PosedScan& s) { return s.key; });
  };
  EXPECT_LT(2 * keys(map_of(part, coarse)), keys(map_of(part)) + 2);
}

}  // namespace
}  // namespace majak::slam
