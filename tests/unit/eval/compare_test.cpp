// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/compare.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/known_map.hpp"
#include "majak/sim/simulator.hpp"

namespace majak::eval {
namespace {

using testing::HasSubstr;

Scan scan_at(Time time, float range = 2) {
  Scan scan;
  scan.time = time;
  scan.start_angle = -1;
  scan.angle_step = 0.1;
  scan.max_range = 30;
  scan.ranges.assign(21, range);
  return scan;
}

/// n scans and odometry between them, one way or round a bend.
std::vector<Event> straight(int n, const Vec3& step = {0.11, 0, 0}) {
  std::vector<Event> events;
  Pose2 pose{5, 6, 0.7};
  for (int i = 0; i < n; ++i) {
    const Time t = i * kSecond / 10;
    events.emplace_back(Odometry{t, pose, {}, {}});
    events.emplace_back(scan_at(t));
    pose = pose * exp(step);
  }
  return events;
}

// ---- Splice
// --------------------------------------------------------------------------------------

std::vector<Time> scan_times(const std::vector<Event>& events) {
  std::vector<Time> times;
  for (const Event& event : events)
    if (std::holds_alternative<Scan>(event)) times.push_back(time_of(event));
  return times;
}

TEST(Splice, TheWheelsGoOnAsIfNothingHadBeen) {
  const auto events = straight(90, {0.1, 0.01, 0.03});
  const auto result = splice(events, {}, 3);
  ASSERT_TRUE(result);
  const Trajectory wheels = wheels_of(result->events);
  ASSERT_EQ(wheels.size(), 31 + 29U);  // the record with the scan there comes before it
  for (std::size_t i = 1; i < wheels.size(); ++i) {
    const Vec3 step = log(between(wheels[i - 1].pose, wheels[i].pose));
    EXPECT_NEAR((step - Vec3(0.1, 0.01, 0.03)).norm(), 0, 1e-12) << i;
  }
}

TEST(Splice, TimeGoesOnAtTheSamePace) {
  const auto result = splice(straight(90), {}, 3);
  ASSERT_TRUE(result);
  const auto times = scan_times(result->events);
  ASSERT_EQ(times.size(), 31 + 30U);
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_EQ(times[i] - times[i - 1], kSecond / 10);
  EXPECT_EQ(result->jump, times[31]);
  EXPECT_EQ(result->last, times[30]);
}

TEST(Splice, APathIsCutLikeTheLog) {
  const auto events = straight(90);
  const Trajectory old = wheels_of(events);
  const auto result = splice(events, old, 3);
  ASSERT_TRUE(result);
  const Trajectory path = result->spliced(old);
  ASSERT_EQ(path.size(), 61U);
  const auto times = scan_times(result->events);
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(path[i].time, times[i]);
    EXPECT_EQ(path[i].pose, old[i < 31 ? i : i + 29].pose);
  }
}

TEST(Splice, TheOtherPlaceIsFarEnough) {
  // There and back again: at two thirds it is where it was at a third.
  const auto events = straight(90);
  Trajectory way;
  for (int i = 0; i < 90; ++i) way.push_back({i * kSecond / 10, {0.1 * std::abs(i - 45), 0, 0}});
  const auto result = splice(events, way, 2.5);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->jump + result->later, way[85].time);  // 4.0 m against 1.5 m
  EXPECT_FALSE(splice(events, way, 3.5)) << "it never is that far";
  EXPECT_FALSE(splice(straight(5), {}, 3)) << "too short";
}

TEST(Splice, OdometryInTheScansGoesAlong) {
  std::vector<Event> events;
  for (int i = 0; i < 30; ++i) {
    Scan scan = scan_at(i * kSecond);
    scan.T_odom_robot = Pose2{i * 1.0, 0, 0};
    events.emplace_back(scan);
  }
  const auto result = splice(events, {}, 3);
  ASSERT_TRUE(result);
  const Trajectory wheels = wheels_of(result->events);
  ASSERT_EQ(wheels.size(), 21U);
  EXPECT_EQ(wheels[10].pose, wheels[11].pose) << "while it is carried the wheels stand still";
  EXPECT_NEAR(wheels.back().pose.x, 19, 1e-12);
}

// ---- A simulated drive
// ------------------------------------------------------------------------------

struct Drive {
  localize::PlacePtr place;
  std::vector<Event> events;
  Trajectory truth;
};

const Drive& drive() {
  static const Drive drive = [] {
    const sim::World world(sim::building());
    Drive d{localize::place_of(sim::known_map(world)), {}, {}};
    d.events = sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), {});
    std::vector<Truth> truth;
    for (const Event& event : d.events)
      if (const auto* t = std::get_if<Truth>(&event)) truth.push_back(*t);
    d.truth = truth_of(truth);
    return d;
  }();
  return drive;
}

CompareInput on_drive() {
  CompareInput in{drive().events, drive().truth, {}, {}, {}, {}};
  in.options.place = drive().place;
  in.options.start = drive().truth.front().pose;
  return in;
}

// ---- The table
// ------------------------------------------------------------------------------------

MethodResult dead_reckoning(const std::vector<Event>& events, const Pose2& off) {
  CompareInput in{events, wheels_of(events), {}, {}, {}, {}};
  in.options.start = in.truth.front().pose * off;
  return compare(in, {"dead-reckoning"}).methods.at(0);
}

TEST(Compare, ErrorsAreThoseOfTheOffsetOnAStraightWay) {
  const auto near = dead_reckoning(straight(60), {0.06, -0.08, 0});
  ASSERT_TRUE(near.translation && near.right && near.wrong);
  EXPECT_NEAR(near.translation->median, 0.1, 1e-9);
  EXPECT_NEAR(near.translation->p95, 0.1, 1e-9);
  EXPECT_NEAR(near.rotation->p95, 0, 1e-9);
  EXPECT_EQ(*near.right, 1);
  EXPECT_EQ(*near.wrong, 0);
  const auto far = dead_reckoning(straight(60), {3, 4, 0});
  EXPECT_NEAR(far.translation->median, 5, 1e-9);
  EXPECT_EQ(*far.right, 0);
  EXPECT_EQ(*far.wrong, 1) << "it says ok, and is not right";
}

TEST(Compare, TheHeadingCountsToo) {
  const auto turned = dead_reckoning(straight(3, {0, 0, 0.01}), {0, 0, radians(11)});
  EXPECT_NEAR(turned.translation->p95, 0, 1e-9);
  EXPECT_NEAR(turned.rotation->median, radians(11), 1e-9);
  EXPECT_EQ(*turned.right, 0);
}

TEST(Compare, WheelsNeverKnowThatTheRobotWasCarried) {
  const auto r = dead_reckoning(straight(60), {});
  ASSERT_TRUE(r.recovery);
  EXPECT_TRUE(r.recovery->knew);
  EXPECT_FALSE(r.recovery->told_lost);
  EXPECT_FALSE(r.recovery->right_again);
  EXPECT_TRUE(r.told);
  EXPECT_FALSE(r.found);
  EXPECT_FALSE(dead_reckoning(straight(60), {3, 4, 0}).recovery->knew);
  EXPECT_FALSE(dead_reckoning(straight(20, {0.01, 0, 0}), {}).recovery) << "goes nowhere else";
}

TEST(Compare, UpdatesAreCountedAlongTheWay) {
  const auto updates = [](const std::vector<Event>& events) {
    return compare({events, {}, {}, {}, {}, {}}, {"dead-reckoning"}).updates;
  };
  EXPECT_EQ(updates(straight(61, {0.11, 0, 0})), 31);  // each second scan
  EXPECT_EQ(updates(straight(61, {0, 0, 0.21})), 61);
  EXPECT_EQ(updates(straight(61, {0, 0, 0})), 1);
}

TEST(Compare, TheClockCountsTheMethodsWorkAlone) {
  const auto events = straight(50);
  double ticks = 0;
  CompareInput in{events, {}, {}, {}, [&] { return ticks += 1; }, {}};
  int told = 0;
  in.progress = [&](const char*, std::int64_t) { ticks += 1000, ++told; };
  const auto c = compare(in, {"dead-reckoning"});
  EXPECT_EQ(told, 100 + 34 + 11) << "each event of the log, and of that with the jump";
  EXPECT_EQ(c.scans, 50U);
  EXPECT_EQ(c.methods[0].cpu_mean, 101 / 50.0) << "one tick an event, and one at the end";
  EXPECT_EQ(c.methods[0].cpu_most, 2);
}

TEST(Compare, WithoutTruthColumnsStayEmpty) {
  const auto events = straight(50);
  const auto c = compare({events, {}, {}, {}, {}, {}}, {"dead-reckoning"});
  EXPECT_FALSE(c.methods[0].translation || c.methods[0].right || c.methods[0].wrong);
  EXPECT_THAT(comparison_csv(c), HasSubstr("dead-reckoning,1,,,,,,,1.0000,0.0000,0.0000,"));
}

TEST(Compare, SaysWhatAMethodMisses) {
  const std::vector<Event> nothing{scan_at(0)};
  EXPECT_THROW(compare({nothing, {}, {}, {}, {}, {}}, {"dead-reckoning"}), Error);
  EXPECT_THROW(compare({nothing, {}, {}, {}, {}, {}}, {"guessing"}), Error);
  EXPECT_THROW(compare({nothing, {}, {}, {}, {}, {}}, {"markov"}), Error) << "no map";
}

TEST(Compare, AMethodThatFindsNothingToUseIsLeftOut) {
  const CompareInput whole = on_drive();
  std::vector<Event> blind;  // no wheels
  for (const Event& event : drive().events)
    if (const auto* scan = std::get_if<Scan>(&event)) {
      blind.emplace_back(*scan);
      std::get<Scan>(blind.back()).T_odom_robot.reset();
    }
  const auto c =
      compare({blind, whole.truth, whole.options, {}, {}, {}}, {"dead-reckoning", "tracking"});
  ASSERT_EQ(c.methods.size(), 1U);
  EXPECT_EQ(c.methods[0].method, "tracking");
  EXPECT_LT(c.methods[0].translation->median, 0.1);
  ASSERT_EQ(c.left_out.size(), 1U);
  EXPECT_THAT(c.left_out[0], HasSubstr("dead-reckoning needs odometry"));
}

TEST(Compare, MemoryIsThatOfTheBelief) {
  localize::Localization result;
  result.estimates.resize(4);
  for (int i = 0; i < 4; ++i) result.estimates[static_cast<std::size_t>(i)].time = i;
  result.hypotheses = {{1, std::vector<localize::Hypothesis>(3)}, {3, {}}};
  const std::size_t one = sizeof(Pose2) + sizeof(Mat3), more = 3 * sizeof(localize::Hypothesis);
  EXPECT_EQ(belief_bytes(result), (std::vector<std::size_t>{one, one + more, one, one}));
  result.belief_bytes = {1, 2, 3, 4};
  EXPECT_EQ(belief_bytes(result), result.belief_bytes);
}

TEST(Compare, MethodsOnAMapFindTheRobotAgainAndTrackingDoesNot) {
  const auto c = compare(on_drive(), {"global", "tracking", "monte-carlo", "dead-reckoning"});
  ASSERT_EQ(c.methods.size(), 4U);
  for (const MethodResult& r : c.methods) {
    ASSERT_TRUE(r.translation && r.recovery) << r.method;
    EXPECT_TRUE(r.recovery->knew || r.method == "dead-reckoning") << r.method;
  }
  for (const int k : {0, 2}) {
    const MethodResult& r = c.methods[static_cast<std::size_t>(k)];
    EXPECT_LT(r.translation->median, 0.1) << r.method;
    ASSERT_TRUE(r.found && r.recovery->told_lost && r.recovery->right_again) << r.method;
    EXPECT_LE(*r.recovery->told_lost, *r.recovery->right_again) << r.method;
    EXPECT_LT(*r.recovery->right_again, 40) << r.method;
  }
  EXPECT_FALSE(c.methods[3].recovery->right_again);
  EXPECT_EQ(c.methods[1].belief_most, sizeof(Pose2) + sizeof(Mat3));
  EXPECT_EQ(c.methods[2].belief_most % 24, 0U) << "four floats and a weight a particle";
  EXPECT_GE(c.methods[2].belief_median, 500 * 24U);
  EXPECT_LE(c.methods[2].belief_most, 5000 * 24U);
  EXPECT_LT(c.methods[2].updates, static_cast<std::int64_t>(c.scans) / 2);
}

TEST(Compare, TheSameBytesEachTime) {
  const auto csv = [] { return comparison_csv(compare(on_drive(), {"tracking", "monte-carlo"})); };
  const std::string once = csv();
  EXPECT_EQ(once, csv());
  EXPECT_EQ(std::count(once.begin(), once.end(), '\n'), 3);
}

TEST(Compare, TruthOfAnotherFrameIsSeenByTheScans) {
  EXPECT_GT(share_on_map(*drive().place, drive().events, drive().truth), 0.95);
  Trajectory moved = drive().truth;
  for (StampedPose& p : moved) p.pose = Pose2{1, -2, 0.5} * p.pose;
  EXPECT_LT(share_on_map(*drive().place, drive().events, moved), 0.4);
  EXPECT_EQ(share_on_map(*drive().place, drive().events, {}), 0);
}

TEST(Compare, ARunIsOfThisLogIfItsScansAre) {
  Site site;
  std::size_t i = 0;
  for (const Event& event : drive().events)
    if (const auto* scan = std::get_if<Scan>(&event)) {
      PosedScan posed;
      posed.scan = *scan;
      posed.estimate.T_map_robot = Pose2{double(i++), 0, 0};
      site.scans.push_back(posed);
    }
  const auto path = path_of_same_log(site, drive().events);
  ASSERT_TRUE(path);
  ASSERT_EQ(path->size(), site.scans.size());
  EXPECT_EQ((*path)[7].pose.x, 7);
  EXPECT_EQ((*path)[7].time, site.scans[7].scan.time);

  Site later = site;  // the same place at another time
  for (PosedScan& s : later.scans) s.scan.time += kSecond / 1000;
  EXPECT_FALSE(path_of_same_log(later, drive().events));
  Site other = site;  // another place at the same times: simulators begin at 0
  for (PosedScan& s : other.scans)
    for (float& r : s.scan.ranges) r += 0.3F;
  EXPECT_FALSE(path_of_same_log(other, drive().events));
}

}  // namespace
}  // namespace majak::eval
