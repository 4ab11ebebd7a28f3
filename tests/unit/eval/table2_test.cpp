// SPDX-License-Identifier: Apache-2.0
// Logs made worse, methods of mapping tried on them, and the table that comes out.
#include "majak/eval/table2.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/eval/spoil.hpp"
#include "majak/sim/buildings.hpp"
#include "majak/sim/simulator.hpp"
#include "majak/sim/tour.hpp"

namespace majak::eval {
namespace {

using testing::HasSubstr;

/// 200 steps straight on, a record in each scan, and beside it.
std::vector<Event> straight() {
  std::vector<Event> events;
  for (int i = 0; i < 200; ++i) {
    const Pose2 at{0.1 * i, 0, 0};
    events.emplace_back(Odometry{i * kSecond, at, {}, {}});
    events.emplace_back(WheelMotion{i * kSecond, 0.1, 0});
    Scan scan;
    scan.time = i * kSecond;
    scan.T_odom_robot = at;
    scan.ranges = {1, 2, kNoReturn, 4, kInvalidRange};
    events.emplace_back(scan);
  }
  return events;
}

double end_of(const std::vector<Event>& events) {
  Pose2 last;
  for (const Event& e : events)
    if (const auto* o = std::get_if<Odometry>(&e)) last = o->T_odom_robot;
  return (last.translation() - Vec2(19.9, 0)).norm();
}

TEST(WornWheels, ErrByTheRootOfTheWay) {
  const WheelWear along{.way = 0.02, .turn = 0, .spin = 0, .scale = 0};
  for (const double factor : {1.0, 3.0}) {
    double square = 0;
    const int runs = 200;
    for (int seed = 1; seed <= runs; ++seed) {
      const double off =
          end_of(with_worn_wheels(straight(), factor, static_cast<std::uint64_t>(seed), along));
      square += off * off / runs;
    }
    // Two axes, 19.9 m of way each with 0.02 m per root of a metre.
    EXPECT_NEAR(square / (2 * 19.9 * std::pow(0.02 * factor, 2)), 1, 0.15);
  }
}

TEST(WornWheels, WithoutWearNothingChanges) {
  const auto worn = with_worn_wheels(straight(), 0, 1);
  EXPECT_NEAR(end_of(worn), 0, 1e-12);
  const auto scaled =
      with_worn_wheels(straight(), 1, 3, {.way = 0, .turn = 0, .spin = 0, .scale = 0.1});
  double rolled = 0, scans = 0;
  for (const Event& e : scaled) {
    if (const auto* w = std::get_if<WheelMotion>(&e)) rolled = w->speed;
    if (const auto* s = std::get_if<Scan>(&e)) scans = s->T_odom_robot->x;
  }
  EXPECT_GT(std::abs(rolled - 0.1), 1e-4);
  EXPECT_GT(std::abs(scans - 19.9), 1e-3);
}

TEST(StrayReturns, AreThatShareAndEndBefore) {
  int shorter = 0, returns = 0;
  const auto events = straight(), spoilt = with_stray_returns(events, 0.2, 1);
  for (std::size_t i = 0; i < events.size(); ++i) {
    const auto* before = std::get_if<Scan>(&events[i]);
    if (!before) continue;
    const auto& after = std::get<Scan>(spoilt[i]);
    for (std::size_t b = 0; b < before->ranges.size(); ++b) {
      if (!std::isfinite(before->ranges[b])) {
        EXPECT_EQ(std::isnan(before->ranges[b]), std::isnan(after.ranges[b]));
        continue;
      }
      ++returns;
      EXPECT_GT(after.ranges[b], 0);
      EXPECT_LE(after.ranges[b], before->ranges[b]);
      shorter += after.ranges[b] < before->ranges[b];
    }
  }
  EXPECT_NEAR(shorter / static_cast<double>(returns), 0.2, 0.04);
}

TEST(WithoutWheels, NothingOfThemIsLeft) {
  for (const Event& e : without_wheels(straight())) {
    const auto* scan = std::get_if<Scan>(&e);
    ASSERT_TRUE(scan);
    EXPECT_FALSE(scan->T_odom_robot);
  }
}

TEST(FirstPart, CountsScans) {
  for (const double share : {0.0, 0.25, 1.0}) {
    const auto part = first_part(straight(), share);
    EXPECT_EQ(std::count_if(part.begin(), part.end(),
                            [](const Event& e) { return std::holds_alternative<Scan>(e); }),
              std::lround(200 * share));
  }
}

// ---- Trials ------------------------------------------------------------------------------------

const TrialLog& table_drive() {
  static const TrialLog log = [] {
    const sim::World world(sim::building());
    TrialLog made{sim::simulate(world, sim::plan_tour(world, {.short_tour = true}), {}), {}, {}};
    std::vector<Truth> truth;
    for (const Event& e : made.events)
      if (const auto* t = std::get_if<Truth>(&e)) truth.push_back(*t);
    made.truth = truth_of(truth);
    return made;
  }();
  return log;
}

/// Half of it.
const TrialLog& half() {
  static const TrialLog log{first_part(table_drive().events, 0.5), table_drive().truth, {}};
  return log;
}

TEST(MappingTrial, SaysHowRightAndHowHonest) {
  double ticks = 0;
  const auto clock = [&] { return ticks += 1e-3; };
  const MappingScore s =
      try_mapping(table_drive(), methods::mapping_method("graph-slam"), {}, {}, clock);
  ASSERT_TRUE(s.ran);
  EXPECT_LT(s.rms, 0.03);
  EXPECT_GE(s.worst, s.rms);
  EXPECT_LT(s.map_error, 0.03);
  EXPECT_NEAR(s.way, 101, 2);
  ASSERT_TRUE(s.recognised);
  EXPECT_GT(*s.recognised, 0.99);
  ASSERT_TRUE(s.nees);
  EXPECT_LT(*s.nees, 6);
  EXPECT_TRUE(s.online);
  // A tick before and one after each event, and those of finish().
  EXPECT_NEAR(s.cpu, 1e-3 * (static_cast<double>(table_drive().events.size()) + 1), 1e-6);
  EXPECT_GT(s.cpu_first, 0);
  EXPECT_GT(s.bytes, 1000U);
}

TEST(MappingTrial, SaysWhatAMethodSaid) {
  TrialLog empty;
  empty.events.emplace_back(Odometry{});
  const MappingScore s = try_mapping(empty, methods::mapping_method("graph-slam"), {}, {}, {});
  EXPECT_FALSE(s.ran);
  EXPECT_THAT(s.said, HasSubstr("nothing to map"));
}

TEST(MapsAtPoses, AreWorseAtWorsePoses) {
  slam::GraphSlam slam({}, {});
  for (const Event& e : half().events) slam.add(e);
  const Site site = slam.finish().site;
  for (const GivenMap& map : given_maps()) {
    const auto score = [&](PosesFrom from) { return try_given(map, site, half().truth, from, {}); };
    const GivenScore right = score(PosesFrom::truth), wheels = score(PosesFrom::wheels);
    EXPECT_LT(right.map_error, 0.1) << map.name;
    EXPECT_LT(score(PosesFrom::graph_slam).map_error, right.map_error + 0.02) << map.name;
    EXPECT_GT(wheels.map_error, 3 * right.map_error) << map.name;
    EXPECT_GT(right.bytes, 1000U) << map.name;
    EXPECT_GT(right.elements, 20U) << map.name;
  }
}

TEST(PlanTrials, ByGroups) {
  const auto all = plan_trials({.seeds = 3, .rings = 2, .few = 1});
  EXPECT_EQ(all.front().group, "seeds");
  EXPECT_EQ(std::count_if(all.begin(), all.end(), [](auto& s) { return s.group == "wheels"; }), 3);
  const auto some = plan_trials({.seeds = 3, .rings = 2, .few = 1}, {"ring", "seeds"});
  EXPECT_EQ(some.size(), 5U);
  EXPECT_THROW(plan_trials({}, {"none"}), Error);
}

TEST(VariationsOf, ALogIsNoRingAndNoCrowd) {
  const auto of = variations_of(table_drive());
  EXPECT_FALSE(of({.group = "ring", .where = Surroundings::ring}));
  EXPECT_FALSE(of({.group = "crowd", .people = 3}));
  EXPECT_EQ(of({.group = "size", .where = Surroundings::large})->events.size(),
            table_drive().events.size());
  EXPECT_LT(of({.group = "size", .where = Surroundings::large, .part = 0.5})->events.size(),
            table_drive().events.size() * 6 / 10);
}

// ---- The table ---------------------------------------------------------------------------------

MappingComparison made_up() {
  MappingComparison c;
  c.methods = {"graph-slam", "incremental-ml"};
  for (const int seed : {1, 2}) c.settings.push_back({.group = "seeds", .seed = seed});
  c.settings.push_back({.group = "ring", .where = Surroundings::ring});
  for (const double part : {0.5, 1.0})
    c.settings.push_back({.group = "size", .where = Surroundings::large, .part = part});
  const auto score = [](double rms, double recognised, double way) {
    MappingScore s;
    s.ran = true, s.rms = rms, s.recognised = recognised, s.way = way, s.online = true;
    s.cpu = way * way, s.bytes = static_cast<std::size_t>(1000 * way), s.scans = 100;
    return s;
  };
  c.scores.assign(2, {});
  for (auto& scores : c.scores)
    scores = {score(0.1, 1, 100), score(0.7, 0.5, 100), score(0.2, 1, 60), score(0.1, 1, 100),
              score(0.1, 1, 200)};
  c.scores[0][0]->nees = 3, c.scores[0][1]->nees = 5;
  c.scores[1][2]->recognised = 0.2;
  c.scores[1][1]->ran = false, c.scores[1][1]->said = "cannot";
  c.given.assign(given_maps().size(), std::vector<std::optional<std::array<GivenScore, 3>>>(5));
  c.given[0][0] = {GivenScore{0.01, 10, 100, 1, 50}, GivenScore{0.02, 10, 100, 1, 50},
                   GivenScore{0.5, 10, 100, 1, 50}};
  return c;
}

const Table2Cell& cell(const Table2& table, const std::string& row, const std::string& column) {
  for (const Table2Row& r : table.rows)
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      if (r.name == row && table.columns[c].name == column) return r.cells[c];
  throw Error("no cell " + row + ", " + column);
}

TEST(Table2, HasAWordAMeasurementAndACommandInEachCell) {
  const Table2 t = table2_of(made_up(), "majak compare");
  EXPECT_EQ(t.rows.size(), 12U);
  EXPECT_EQ(t.columns.size(), 3U);  // and a map that is told the poses
  const Table2Cell& convergence = cell(t, "Convergence", "incremental-ml");
  EXPECT_EQ(convergence.word, "none");
  EXPECT_EQ(convergence.measured, "1 of 2, 0.10 m");
  EXPECT_EQ(convergence.command, "majak compare --methods incremental-ml --only seeds");
  EXPECT_EQ(cell(t, "Uncertainty", "graph-slam").measured, "posterior poses: NEES 4.0");
  EXPECT_EQ(cell(t, "Uncertainty", "incremental-ml").measured, "none kept of poses");
  EXPECT_TRUE(*cell(t, "Uncertainty", "incremental-ml").agrees);
  EXPECT_EQ(cell(t, "Maps cycles", "graph-slam").measured, "ring 1 of 1");
  EXPECT_TRUE(*cell(t, "Maps cycles", "incremental-ml").agrees);  // "no", and it did not
  EXPECT_THAT(cell(t, "Dimensionality", "graph-slam").measured, HasSubstr("CPU ^2.0, memory ^1.0"));
  EXPECT_EQ(cell(t, "Correspondence", "graph-slam").measured, "83 %");
  EXPECT_THAT(cell(t, "Needs poses", "occupancy-grid").measured,
              HasSubstr("1.0 cm at true poses, 2.0 cm at graph SLAM's, 0.50 m at the wheels'"));
  EXPECT_EQ(cell(t, "Maps cycles", "occupancy-grid").measured, "");
}

TEST(Table2, FiguresAndWhatWasSaid) {
  const Table2 t = table2_of(made_up(), "majak compare");
  ASSERT_EQ(t.figures.size(), 2U);
  EXPECT_EQ(t.figures[1].method, "graph-slam");
  EXPECT_EQ(t.figures[1].usable, 1U);
  EXPECT_NEAR(t.figures[1].rms, 0.4, 1e-12);
  EXPECT_THAT(t.figures[0].said, testing::ElementsAre("cannot"));
}

TEST(CompareMappings, TriesEachMethodOnEachLogForAnyNumberOfThreads) {
  MappingComparisonInput input{
      .what = "a table_drive",
      .methods = {"graph-slam", "incremental-ml"},
      .maps = {"occupancy-grid"},
      .settings = {{.group = "seeds"}, {.group = "ring", .where = Surroundings::ring}},
      .log_of = variations_of(half()),
      .options = {},
      .threads = {1},
      .clock = {}};
  const MappingComparison one = compare_mappings(input);
  input.threads = {2};
  const MappingComparison two = compare_mappings(input);
  for (std::size_t m = 0; m < 2; ++m) {
    ASSERT_TRUE(one.scores[m][0]);
    EXPECT_FALSE(one.scores[m][1]);
    EXPECT_TRUE(one.scores[m][0]->ran);
    EXPECT_EQ(one.scores[m][0]->rms, two.scores[m][0]->rms);
  }
  EXPECT_TRUE(one.given[0][0]);
  EXPECT_FALSE(one.given[1][0]);
  input.methods = {"magic"};
  EXPECT_THROW(compare_mappings(input), Error);
}

}  // namespace
}  // namespace majak::eval
